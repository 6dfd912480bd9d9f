//! Typed forms of a profile's elements: each field is declared once, with its names in XML and YAML and its documentation.
//!
//! Readers, writers and the field reference are generic over [`Form`]. What a type has no field for (unknown elements and
//! attributes, comments) is kept beside the fields with the order of everything, so that a form alone writes all of it back.

mod allowance;
mod date;
mod declare;
mod extra;
mod format;
mod missing;
mod order;
mod patch;
mod patch_yaml;
mod place;
mod print_yaml;
mod read_xml;
mod read_yaml;
mod remarks;
mod same;
mod schema;
mod unknown;
mod vocabulary;
mod walk;
mod write_xml;
mod write_yaml;

pub use declare::profile_form;
pub use extra::{Beside, Extra, Place, Stray};
pub use format::{Around, Format, format};
pub use missing::{Alike, Missing, What, missing};
pub use patch::patch;
pub use patch_yaml::patch_yaml;
pub use place::{Scope, XML_NAMESPACE};
pub use read_xml::read_element;
pub use read_yaml::read_node;
pub use remarks::{Remark, keep_all_remarks};
pub use same::{same, strip_places};
pub use schema::schema;
pub use unknown::report_unknown;
pub use vocabulary::{Opened, Tree, Vocabulary, open};
pub use walk::{Taken, comments, each_text, take_fields};
pub use write_xml::element_of;
pub use write_yaml::yaml_of;

use crate::span::{Span, Text};

/// A type of element.
#[derive(Debug)]
pub struct FormType {
    /// Name of the Rust type; also the heading of its documentation.
    pub name: &'static str,
    /// Its documentation.
    pub doc: &'static str,
    /// Its fields, in the order of the schema.
    pub fields: &'static [FieldType],
    /// Bytes of memory that one takes by itself.
    pub size: usize,
}

/// A field.
#[derive(Debug)]
pub struct FieldType {
    /// Name of the Rust field.
    pub name: &'static str,
    /// Namespace URI in XML.
    pub namespace: &'static str,
    /// Local name in XML.
    pub local: &'static str,
    /// Keys in YAML, parted by `|`; the first is written.
    pub keys: &'static str,
    /// What it is in XML.
    pub kind: FieldKind,
    /// Its documentation.
    pub doc: &'static str,
}

/// What a field is.
#[derive(Debug, Clone, Copy)]
pub enum FieldKind {
    /// An attribute.
    Attribute(Scalar),
    /// At most one element with text alone.
    Text,
    /// Any number of elements with text alone.
    Texts,
    /// At most one element; in YAML a mapping.
    One(fn() -> &'static FormType),
    /// Usually one element; in YAML a mapping, or a list of several.
    Some(fn() -> &'static FormType),
    /// Any number of elements; in YAML a list.
    Many(fn() -> &'static FormType),
}

/// What an attribute says; YAML writes numbers and truth values plainly, dates as mappings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    /// Text.
    Text,
    /// A number.
    Number,
    /// `true` or `false`.
    Boolean,
    /// A date and time.
    Date,
}

impl FieldKind {
    /// True for an attribute.
    pub fn is_attribute(self) -> bool {
        matches!(self, Self::Attribute(_))
    }

    /// The type of the elements that the field holds.
    pub fn form_type(self) -> Option<&'static FormType> {
        match self {
            Self::One(of) | Self::Some(of) | Self::Many(of) => Some(of()),
            Self::Attribute(_) | Self::Text | Self::Texts => None,
        }
    }
}

impl FormType {
    /// The field that a key of YAML names, whatever stands before its `::`.
    pub fn field(&self, key: &str) -> Option<&'static FieldType> {
        read_yaml::find(self.fields, key).and_then(|at| self.fields.get(at))
    }
}

impl FieldType {
    /// The key that is written in YAML.
    pub fn key(&self) -> &'static str {
        self.keys.split('|').next().unwrap_or(self.keys)
    }
}

/// What a field holds.
pub enum Value<'a> {
    /// A text, or nothing.
    Text(Option<&'a Text>),
    /// Texts.
    Texts(&'a [Text]),
    /// Elements in their order.
    Forms(&'a dyn Held),
}

impl Value<'_> {
    /// How many values there are.
    pub fn count(&self) -> usize {
        match self {
            Self::Text(text) => usize::from(text.is_some()),
            Self::Texts(texts) => texts.len(),
            Self::Forms(forms) => forms.count(),
        }
    }
}

/// Where a field is filled.
pub enum Slot<'a> {
    /// A text.
    Text(&'a mut Option<Text>),
    /// Texts.
    Texts(&'a mut Vec<Text>),
    /// Elements.
    Forms(&'a mut dyn Filling),
}

/// Elements of one type.
pub trait Held {
    /// How many there are.
    fn count(&self) -> usize;
    /// The one with this index.
    fn form(&self, index: usize) -> Option<&dyn Form>;
}

/// Elements of one type, to change.
pub trait Filling: Held {
    /// One more, empty, before the one with this index (or at the end). `None` when there is room for one only.
    fn add(&mut self, index: usize) -> Option<&mut dyn Form>;
    /// Makes room for so many more.
    fn reserve(&mut self, count: usize);
    /// The one with this index.
    fn form_mut(&mut self, index: usize) -> Option<&mut dyn Form>;
    /// Takes the one with this index away.
    fn remove(&mut self, index: usize);
}

/// An element as a type of our own.
pub trait Form: std::fmt::Debug + Send + Sync {
    /// Its type.
    fn form_type(&self) -> &'static FormType;
    /// The start tag, or the first token in YAML.
    fn span(&self) -> Span;
    /// Says where it stood.
    fn stand(&mut self, span: Span);
    /// What the field with this index of the type holds.
    fn value(&self, field: usize) -> Value<'_>;
    /// Where the field with this index is filled.
    fn slot(&mut self, field: usize) -> Option<Slot<'_>>;
    /// What the type does not know, and the order of all.
    fn extra(&self) -> &Extra;
    /// The same, to fill.
    fn extra_mut(&mut self) -> &mut Extra;
}

impl<T: Form> Held for Option<Box<T>> {
    fn count(&self) -> usize {
        usize::from(self.is_some())
    }
    fn form(&self, index: usize) -> Option<&dyn Form> {
        self.as_deref().filter(|_| index == 0).map(|form| form as _)
    }
}

impl<T: Form> Held for Vec<T> {
    fn count(&self) -> usize {
        self.len()
    }
    fn form(&self, index: usize) -> Option<&dyn Form> {
        self.get(index).map(|form| form as _)
    }
}

impl<T: Form + Default> Filling for Option<Box<T>> {
    fn add(&mut self, _: usize) -> Option<&mut dyn Form> {
        match self {
            Some(_) => None,
            None => Some(&mut **self.insert(Box::default())),
        }
    }
    fn reserve(&mut self, _: usize) {}
    fn form_mut(&mut self, index: usize) -> Option<&mut dyn Form> {
        self.as_deref_mut()
            .filter(|_| index == 0)
            .map(|form| form as _)
    }
    fn remove(&mut self, index: usize) {
        if index == 0 {
            *self = None;
        }
    }
}

impl<T: Form + Default> Filling for Vec<T> {
    fn add(&mut self, index: usize) -> Option<&mut dyn Form> {
        let index = index.min(self.len());
        self.insert(index, T::default());
        self.get_mut(index).map(|form| form as _)
    }
    fn reserve(&mut self, count: usize) {
        self.reserve_exact(count);
    }
    fn form_mut(&mut self, index: usize) -> Option<&mut dyn Form> {
        self.get_mut(index).map(|form| form as _)
    }
    fn remove(&mut self, index: usize) {
        if index < self.len() {
            Vec::remove(self, index);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::rtc_profile::forms::RtcProfile;
    use crate::rts_profile::forms::Profile;

    #[test]
    fn every_field_is_found_by_its_key() {
        let mut open = vec![Profile::form_type(), RtcProfile::form_type()];
        let mut seen: Vec<&super::FormType> = Vec::new();
        while let Some(kind) = open.pop() {
            if seen.iter().any(|other| std::ptr::eq(*other, kind)) {
                continue;
            }
            seen.push(kind);
            for field in kind.fields {
                let found = kind.field(field.key()).unwrap();
                assert!(std::ptr::eq(found, field), "{}.{}", kind.name, field.name);
                open.extend(field.kind.form_type());
            }
        }
    }
}
