//! Types where they are used.

use super::super::model::{Kind, Primitive, Type};
use super::Writer;

/// Longest array that serde knows.
const ARRAY: u32 = 32;

impl Writer<'_> {
    /// A type, named from where a definition stands.
    pub(super) fn r#type(&self, r#type: &Type, from: usize) -> String {
        match r#type {
            Type::Primitive(primitive) => self.primitive(*primitive).to_owned(),
            Type::String { .. } => self
                .names
                .prelude("String", "::std::string::String")
                .to_owned(),
            Type::Sequence { element, .. } => {
                let vec = self.names.prelude("Vec", "::std::vec::Vec");
                format!("{vec}<{}>", self.r#type(element, from))
            }
            Type::Array {
                element,
                dimensions,
            } => {
                let element = self.r#type(element, from);
                dimensions
                    .iter()
                    .rev()
                    .fold(element, |inner, count| match *count <= ARRAY {
                        true => format!("[{inner}; {count}]"),
                        false => format!("::rts_runtime::types::Array<{inner}, {count}>"),
                    })
            }
            Type::Named(index) => match self.selection.known(*index) {
                Some(name) => format!("::rts_runtime::types::{name}"),
                None => self.names.path(*index, from),
            },
            Type::WString { .. } => "::rts_runtime::types::WString".to_owned(),
            // What these are in is left out.
            Type::Any | Type::Object => "()".to_owned(),
        }
    }

    /// A name of the language itself is by its path where a definition has it.
    fn primitive(&self, primitive: Primitive) -> &'static str {
        let (name, path) = match primitive {
            Primitive::Boolean => ("bool", "::core::primitive::bool"),
            Primitive::Octet | Primitive::Char => ("u8", "::core::primitive::u8"),
            Primitive::WChar => return "::rts_runtime::types::WChar",
            Primitive::Short => ("i16", "::core::primitive::i16"),
            Primitive::UShort => ("u16", "::core::primitive::u16"),
            Primitive::Long => ("i32", "::core::primitive::i32"),
            Primitive::ULong => ("u32", "::core::primitive::u32"),
            Primitive::LongLong => ("i64", "::core::primitive::i64"),
            Primitive::ULongLong => ("u64", "::core::primitive::u64"),
            Primitive::Float => ("f32", "::core::primitive::f32"),
            Primitive::Double | Primitive::LongDouble => ("f64", "::core::primitive::f64"),
        };
        self.names.prelude(name, path)
    }

    /// A type without its aliases.
    pub(super) fn without_alias<'t>(&'t self, r#type: &'t Type) -> &'t Type {
        match r#type {
            Type::Named(index) => match &self.unit.definitions[*index].kind {
                Kind::Typedef(found) => self.without_alias(&found.r#type),
                _ => r#type,
            },
            _ => r#type,
        }
    }
}

/// A sentence on the bound of a type.
pub(super) fn bound(r#type: &Type) -> Option<String> {
    match r#type {
        Type::String { bound } => bound.map(|bound| format!("At most {bound} bytes.")),
        Type::Sequence { bound, .. } => bound.map(|bound| format!("At most {bound} elements.")),
        _ => None,
    }
}
