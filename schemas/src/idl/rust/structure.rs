//! Structs.

use std::fmt::Write as _;

use super::super::model::{Primitive, StructType, Type};
use super::{SERDE, Writer, names, types};

impl Writer<'_> {
    pub(super) fn structure(&self, index: usize, found: &StructType) -> String {
        let name = self.names.own(index);
        let mut text = format!(
            "#[derive(Debug, Clone, Default, PartialEq, {SERDE})]\n#[serde(crate = \"::rts_runtime::serde\")]\npub struct {name} {{\n"
        );
        for member in &found.members {
            if let Some(bound) = types::bound(&member.r#type) {
                let _ = writeln!(text, "    /// {bound}");
            }
            if self.is_octets(&member.r#type) {
                text.push_str("    #[serde(serialize_with = \"::rts_runtime::types::octets\")]\n");
            }
            if self.selection.reaches(&member.r#type, index) {
                text.push_str(
                    "    #[serde(deserialize_with = \"::rts_runtime::types::nested\")]\n",
                );
            }
            let r#type = self.r#type(&member.r#type, index);
            let _ = writeln!(
                text,
                "    pub {}: {type},",
                names::word(&member.name),
                r#type = r#type
            );
        }
        text.push_str("}\n");
        text + &self.data_type(index)
    }

    /// What is a `Vec<u8>`.
    fn is_octets(&self, r#type: &Type) -> bool {
        let Type::Sequence { element, .. } = self.without_alias(r#type) else {
            return false;
        };
        let element = self.without_alias(element);
        matches!(element, Type::Primitive(Primitive::Octet | Primitive::Char))
    }

    /// What makes it a type of ports.
    pub(super) fn data_type(&self, index: usize) -> String {
        let (name, id) = (
            self.names.own(index),
            &self.unit.definitions[index].repository_id,
        );
        format!(
            "\nimpl ::rts_runtime::types::DataType for {name} {{\n    const TYPE_ID: &'static str = {id:?};\n}}\n"
        )
    }
}
