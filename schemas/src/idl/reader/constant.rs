//! Constants, and the numbers in types.

use super::super::model::{Constant, ConstantValue, Kind};
use super::super::names::What;
use super::evaluate::Goal;
use super::types::Position;
use super::{Parsed, Reader};

impl Reader<'_> {
    /// `const type name = expression`.
    pub(super) fn constant(&mut self) -> Parsed<()> {
        self.advance();
        let type_at = self.at;
        let read = self.type_spec(Position::Parameter)?;
        let goal = read
            .as_ref()
            .map_or(Goal::Unknown, |r#type| self.goal(r#type));
        if goal == Goal::None {
            let help = "constants are numbers, characters, truth values, strings and enumerators";
            self.error("idl-wrong-name", type_at, "no constant has this type", help);
        }
        let (name, at) = self.identifier("the constant")?;
        self.expect("=", "write the value of the constant behind `=`")?;
        let value = self.constant_of(&goal)?;
        let what = match read.zip(value) {
            Some((r#type, value)) => {
                What::Definition(self.define(&name, at, Kind::Constant(Constant { r#type, value })))
            }
            None => What::Unknown,
        };
        self.declare(&name, what, at);
        Ok(())
    }

    /// A whole number from 1: a bound or a dimension.
    pub(super) fn size(&mut self) -> Parsed<Option<u32>> {
        self.number(1)
    }

    /// A whole number from 0.
    pub(super) fn size_or_zero(&mut self) -> Parsed<Option<u32>> {
        self.number(0)
    }

    fn number(&mut self, least: i128) -> Parsed<Option<u32>> {
        let goal = Goal::Integer {
            least,
            most: u32::MAX.into(),
            name: "size",
        };
        let value = self.constant_of(&goal)?;
        Ok(value.and_then(|value| match value {
            ConstantValue::Integer(value) => u32::try_from(value).ok(),
            _ => None,
        }))
    }
}
