//! What a type has no field for, and in which order everything stood.

use crate::span::Text;
use crate::xml::{Attribute, Element};
use crate::yaml;

/// [`Beside`], which most elements have no need of.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Extra(Option<Box<Beside>>);

/// What stands beside the fields.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Beside {
    /// Attributes without a field, and namespace declarations.
    pub attributes: Vec<Attribute>,
    /// Order of the attributes as read; empty when it is that of the fields.
    pub attribute_order: Vec<Place>,
    /// Nodes without a field.
    pub strays: Vec<Stray>,
    /// Order of the nodes as read; empty when it is that of the fields.
    pub node_order: Vec<Place>,
    /// Keys of YAML without a field.
    pub keys: Vec<(Text, yaml::Node)>,
    /// Names that are not the usual ones, by the number in [`Place::Spelled`].
    pub spellings: Vec<Box<str>>,
}

impl Beside {
    /// How the file writes the name of a field there, when that is not the usual name.
    pub fn spelling(&self, place: Place) -> Option<&str> {
        match place {
            Place::Spelled(_, number) => {
                self.spellings.get(usize::from(number)).map(|name| &**name)
            }
            Place::Field(_) | Place::Other => None,
        }
    }

    /// The place of a field under a name of its own. An element has few such names: of more than 255 the usual is kept.
    pub fn spell(&mut self, field: u16, name: &str) -> Place {
        let known = self.spellings.iter().position(|known| **known == *name);
        let number = known.unwrap_or(self.spellings.len());
        match u8::try_from(number) {
            Ok(number) => {
                if known.is_none() {
                    self.spellings.push(name.into());
                }
                Place::Spelled(field, number)
            }
            Err(_) => Place::Field(field),
        }
    }
}

static NOTHING: Beside = Beside {
    attributes: Vec::new(),
    attribute_order: Vec::new(),
    strays: Vec::new(),
    node_order: Vec::new(),
    keys: Vec::new(),
    spellings: Vec::new(),
};

impl Extra {
    /// What there is.
    pub fn get(&self) -> &Beside {
        self.0.as_deref().unwrap_or(&NOTHING)
    }

    /// The same, to change.
    pub fn edit(&mut self) -> &mut Beside {
        self.0.get_or_insert_default()
    }

    /// True when there is nothing.
    pub fn is_empty(&self) -> bool {
        self.0.is_none()
    }

    /// Forgets what says nothing: an order that is that of the fields, and an empty box.
    pub fn tidy(&mut self) {
        let Some(beside) = &mut self.0 else { return };
        for order in [&mut beside.attribute_order, &mut beside.node_order] {
            let mut last = 0;
            let usual = order.iter().all(|place| match *place {
                Place::Field(at) => std::mem::replace(&mut last, at) <= at,
                Place::Spelled(..) | Place::Other => false,
            });
            match usual {
                true => *order = Vec::new(),
                false => order.shrink_to_fit(),
            }
        }
        beside.attributes.shrink_to_fit();
        beside.strays.shrink_to_fit();
        beside.keys.shrink_to_fit();
        beside.spellings.shrink_to_fit();
        if **beside == NOTHING {
            self.0 = None;
        }
    }
}

/// A node without a field.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Stray {
    /// An element that has no field here.
    Element(Box<Element>),
    /// A comment.
    Comment(Box<str>),
    /// A processing instruction.
    Instruction(Box<str>),
    /// Text that is not blank.
    Text(Box<str>),
}

/// One thing in an order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The next value of the field with this index.
    Field(u16),
    /// The same, under a name that is not the usual one (another prefix, or none): its number in `spellings`.
    Spelled(u16, u8),
    /// The next one without a field.
    Other,
}

impl Place {
    /// Index of the field.
    pub fn field(self) -> Option<usize> {
        match self {
            Self::Field(at) | Self::Spelled(at, _) => Some(usize::from(at)),
            Self::Other => None,
        }
    }
}
