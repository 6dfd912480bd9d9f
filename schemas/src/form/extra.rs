//! What a type has no field for, and in which order everything stood.

use super::FormType;
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
}

static NOTHING: Beside = Beside {
    attributes: Vec::new(),
    attribute_order: Vec::new(),
    strays: Vec::new(),
    node_order: Vec::new(),
    keys: Vec::new(),
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

    /// The same beside a form of another type. The order is that of the other type's schema; what has no field stays
    /// before what stood behind it.
    #[must_use]
    pub fn moved(&self, from: &FormType, to: &FormType) -> Self {
        let Some(beside) = &self.0 else {
            return Self::default();
        };
        let mut beside = beside.clone();
        for order in [&mut beside.attribute_order, &mut beside.node_order] {
            *order = moved(std::mem::take(order), from, to);
        }
        Self(Some(beside))
    }

    /// Forgets what says nothing: an order that is that of the fields, and an empty box.
    pub fn tidy(&mut self) {
        let Some(beside) = &mut self.0 else { return };
        for order in [&mut beside.attribute_order, &mut beside.node_order] {
            let mut last = 0;
            let usual = order.iter().all(|place| match *place {
                Place::Field(at, _) => std::mem::replace(&mut last, at) <= at,
                Place::Spelled(..) | Place::Other => false,
            });
            if usual {
                *order = Vec::new();
            }
        }
        if **beside == NOTHING {
            self.0 = None;
        }
    }
}

/// An order in the fields of another type, which are found by their names.
fn moved(order: Vec<Place>, from: &FormType, to: &FormType) -> Vec<Place> {
    let index = |at: usize| {
        let old = from.fields.get(at)?;
        let new = to.fields.iter().position(|field| field.name == old.name)?;
        Some((u16::try_from(new).ok()?, to.fields[new].local == old.local))
    };
    let mut groups: Vec<(u16, Vec<Place>)> = Vec::new();
    let mut others = Vec::new();
    for place in order {
        let Some((new, same)) = place.field().and_then(index) else {
            others.extend((place == Place::Other).then_some(Place::Other));
            continue;
        };
        let place = match place {
            Place::Spelled(_, start, name) if same => Place::Spelled(new, start, name),
            _ => Place::fresh(usize::from(new)),
        };
        let mut group = std::mem::take(&mut others);
        group.push(place);
        groups.push((new, group));
    }
    groups.sort_by_key(|(field, _)| *field);
    let groups = groups.into_iter().flat_map(|(_, group)| group);
    groups.chain(others).collect()
}

/// A node without a field.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Stray {
    /// An element that has no field here.
    Element(Box<Element>),
    /// A comment.
    Comment(String),
    /// A processing instruction.
    Instruction(String),
    /// Text that is not blank.
    Text(String),
}

/// One thing in an order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// The next value of the field with this index, and where it started in the file.
    Field(u16, u32),
    /// The same, under a name that is not the usual one: another prefix, or none.
    Spelled(u16, u32, Box<str>),
    /// The next one without a field.
    Other,
}

/// Where a value started that was not read, or too far behind.
const NOWHERE: u32 = u32::MAX;

impl Place {
    /// A value of a field, which is new.
    pub fn fresh(field: usize) -> Self {
        Self::Field(u16::try_from(field).unwrap_or(u16::MAX), NOWHERE)
    }

    /// Where it started in the file.
    pub fn start(&self) -> Option<usize> {
        match self {
            Self::Field(_, start) | Self::Spelled(_, start, _) if *start != NOWHERE => {
                usize::try_from(*start).ok()
            }
            _ => None,
        }
    }

    pub(super) fn forget_start(&mut self) {
        match self {
            Self::Field(_, start) | Self::Spelled(_, start, _) => *start = NOWHERE,
            Self::Other => {}
        }
    }

    /// Index of the field.
    pub fn field(&self) -> Option<usize> {
        match self {
            Self::Field(at, _) | Self::Spelled(at, ..) => Some(usize::from(*at)),
            Self::Other => None,
        }
    }
}
