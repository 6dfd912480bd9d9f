//! Constants, and labels of unions.

use super::super::model::{Constant, ConstantValue, Kind, Primitive, Type};
use super::{Writer, names};

impl Writer<'_> {
    pub(super) fn constant(&self, index: usize, found: &Constant) -> String {
        let name = self.names.own(index);
        let r#type = match self.without_alias(&found.r#type) {
            Type::String { .. } | Type::WString { .. } => "&str".to_owned(),
            Type::Primitive(Primitive::WChar) => {
                let char = self.names.prelude("char", "::core::primitive::char");
                char.to_owned()
            }
            Type::Primitive(_) => self.r#type(self.without_alias(&found.r#type), index),
            _ => self.r#type(&found.r#type, index),
        };
        let value = self.value(&found.value, &found.r#type, index);
        format!("pub const {name}: {type} = {value};\n", r#type = r#type)
    }

    /// A value of a type, which is a pattern too.
    pub(super) fn value(&self, value: &ConstantValue, r#type: &Type, from: usize) -> String {
        let is_wide = *self.without_alias(r#type) == Type::Primitive(Primitive::WChar);
        match value {
            ConstantValue::Integer(value) => value.to_string(),
            ConstantValue::Float(value) => format!("{value:?}"),
            ConstantValue::Boolean(value) => value.to_string(),
            ConstantValue::Char(value) if is_wide => format!("{value:?}"),
            ConstantValue::Char(value) => u32::from(*value).to_string(),
            ConstantValue::Text(value) => format!("{value:?}"),
            ConstantValue::Enumerator {
                definition,
                ordinal,
            } => {
                let name = match &self.unit.definitions[*definition].kind {
                    Kind::Enum(found) => usize::try_from(*ordinal)
                        .ok()
                        .and_then(|at| found.enumerators.get(at)),
                    _ => None,
                };
                let name = name.map_or_else(String::new, |name| names::word(name));
                format!("{}::{name}", self.names.path(*definition, from))
            }
        }
    }
}
