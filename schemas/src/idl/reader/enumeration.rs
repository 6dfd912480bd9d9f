//! Enums.

use super::super::model::{EnumType, Kind, Type};
use super::super::names::What;
use super::{Parsed, Reader};

impl Reader<'_> {
    /// `enum name { a, b }`. Its enumerators stand beside it.
    pub(super) fn enumeration(&mut self) -> Parsed<Option<Type>> {
        self.advance();
        let (name, at) = self.identifier("the enum")?;
        self.expect("{", "an enum has its enumerators in braces")?;
        let index = self.define(&name, at, Kind::Enum(EnumType::default()));
        self.declare(&name, What::Definition(index), at);
        let mut enumerators = Vec::new();
        loop {
            let Ok((name, at)) = self.identifier("an enumerator") else {
                self.recover();
                break;
            };
            let ordinal = u32::try_from(enumerators.len()).unwrap_or(u32::MAX);
            self.declare(&name, What::Enumerator(index, ordinal), at);
            enumerators.push(name);
            if !self.takes(",") {
                break;
            }
        }
        self.definitions[index].kind = Kind::Enum(EnumType { enumerators });
        self.expect(
            "}",
            "enumerators are separated by commas, and `}` follows the last one",
        )?;
        Ok(Some(Type::Named(index)))
    }
}
