//! What expressions give, and what the types of constants take.

use super::super::model::{ConstantValue, Kind, Primitive, Type};
use super::super::token::At;
use super::{Parsed, Reader};

/// What a constant may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Goal {
    /// A whole number within bounds.
    Integer {
        least: i128,
        most: i128,
        name: &'static str,
    },
    Float,
    Double,
    Boolean,
    Char,
    WChar,
    Text(Option<u32>),
    WText(Option<u32>),
    /// One of an enum.
    Enum(usize),
    /// Nothing: the type has no constants.
    None,
    /// Anything: the type is not known, which was told.
    Unknown,
}

/// A value, with its kind.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Integer(i128),
    Float(f64),
    Boolean(bool),
    Char(char),
    WChar(char),
    Text(String),
    WText(String),
    Enumerator { definition: usize, ordinal: u32 },
}

impl Value {
    /// As a message calls it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Integer(_) => "a whole number",
            Self::Float(_) => "a floating-point number",
            Self::Boolean(_) => "a truth value",
            Self::Char(_) => "a character",
            Self::WChar(_) => "a wide character",
            Self::Text(_) => "a string",
            Self::WText(_) => "a wide string",
            Self::Enumerator { .. } => "an enumerator",
        }
    }

    /// The value of a constant of this type.
    pub fn of(value: ConstantValue, goal: &Goal) -> Self {
        match value {
            ConstantValue::Integer(value) => Self::Integer(value),
            ConstantValue::Float(value) => Self::Float(value),
            ConstantValue::Boolean(value) => Self::Boolean(value),
            ConstantValue::Char(value) if *goal == Goal::WChar => Self::WChar(value),
            ConstantValue::Char(value) => Self::Char(value),
            ConstantValue::Text(value) if matches!(goal, Goal::WText(_)) => Self::WText(value),
            ConstantValue::Text(value) => Self::Text(value),
            ConstantValue::Enumerator {
                definition,
                ordinal,
            } => Self::Enumerator {
                definition,
                ordinal,
            },
        }
    }
}

impl Goal {
    fn integer(least: impl Into<i128>, most: impl Into<i128>, name: &'static str) -> Self {
        Self::Integer {
            least: least.into(),
            most: most.into(),
            name,
        }
    }

    pub fn is_octet(&self) -> bool {
        matches!(self, Self::Integer { name: "octet", .. })
    }

    /// All bits of a number turned round: in the unsigned types of 32 and 64 bits it stays positive.
    pub fn complement(&self, value: i128) -> i128 {
        match self {
            Self::Integer { least: 0, most, .. }
                if *most >= u32::MAX.into() && (0..=*most).contains(&value) =>
            {
                most - value
            }
            _ => !value,
        }
    }

    /// What may be written.
    fn takes(&self) -> &'static str {
        match self {
            Self::Integer { .. } => "a whole number",
            Self::Float | Self::Double => "a floating-point number",
            Self::Boolean => "a truth value",
            Self::Char => "a character",
            Self::WChar => "a wide character",
            Self::Text(_) => "a string",
            Self::WText(_) => "a wide string",
            Self::Enum(_) => "an enumerator",
            Self::None | Self::Unknown => "anything",
        }
    }

    /// How that is written.
    fn example(&self) -> &'static str {
        match self {
            Self::Integer { .. } => "write a whole number, without a point",
            Self::Float | Self::Double => "write it with a point: 1.0",
            Self::Boolean => "write TRUE or FALSE",
            Self::Char => "write it as 'a'",
            Self::WChar => "write it as L'a'",
            Self::Text(_) => "write it as \"text\"",
            Self::WText(_) => "write it as L\"text\"",
            Self::Enum(_) => "name one of its enumerators",
            Self::None | Self::Unknown => "",
        }
    }
}

impl Reader<'_> {
    /// What constants of a type may be.
    pub(super) fn goal(&self, r#type: &Type) -> Goal {
        match r#type {
            Type::Primitive(primitive) => match primitive {
                Primitive::Boolean => Goal::Boolean,
                Primitive::Octet => Goal::integer(0, u8::MAX, "octet"),
                Primitive::Char => Goal::Char,
                Primitive::WChar => Goal::WChar,
                Primitive::Short => Goal::integer(i16::MIN, i16::MAX, "short"),
                Primitive::UShort => Goal::integer(0, u16::MAX, "unsigned short"),
                Primitive::Long => Goal::integer(i32::MIN, i32::MAX, "long"),
                Primitive::ULong => Goal::integer(0, u32::MAX, "unsigned long"),
                Primitive::LongLong => Goal::integer(i64::MIN, i64::MAX, "long long"),
                Primitive::ULongLong => Goal::integer(0, u64::MAX, "unsigned long long"),
                Primitive::Float => Goal::Float,
                Primitive::Double | Primitive::LongDouble => Goal::Double,
            },
            Type::String { bound } => Goal::Text(*bound),
            Type::WString { bound } => Goal::WText(*bound),
            Type::Named(index) => match &self.definitions[*index].kind {
                // Typedefs within each other are few, see `size`.
                Kind::Typedef(found) => self.goal(&found.r#type),
                Kind::Enum(_) => Goal::Enum(*index),
                _ => Goal::None,
            },
            _ => Goal::None,
        }
    }

    /// An expression whose value a type takes; `None` if it does not, which was told.
    pub(super) fn constant_of(&mut self, goal: &Goal) -> Parsed<Option<ConstantValue>> {
        let (value, at) = self.expression(goal)?;
        Ok(value.and_then(|value| self.taken(value, goal, at)))
    }

    fn taken(&mut self, value: Value, goal: &Goal, at: At) -> Option<ConstantValue> {
        let kind = value.kind();
        match (value, goal) {
            (_, Goal::None | Goal::Unknown) => None,
            (Value::Integer(value), Goal::Integer { least, most, name }) => {
                match (*least..=*most).contains(&value) {
                    true => Some(ConstantValue::Integer(value)),
                    false => {
                        let message = format!("{value} is no {name}");
                        self.error(
                            "idl-bad-value",
                            at,
                            message,
                            format!("it lies from {least} to {most}"),
                        );
                        None
                    }
                }
            }
            (Value::Float(value), Goal::Float) if value.abs() > f32::MAX.into() => {
                let message = format!("{value:e} is no float");
                self.error(
                    "idl-bad-value",
                    at,
                    message,
                    "the largest `float` is about 3.4e38; use `double`",
                );
                None
            }
            (Value::Float(value), Goal::Float | Goal::Double) => Some(ConstantValue::Float(value)),
            (Value::Boolean(value), Goal::Boolean) => Some(ConstantValue::Boolean(value)),
            (Value::Char(value), Goal::Char) | (Value::WChar(value), Goal::WChar) => {
                Some(ConstantValue::Char(value))
            }
            (Value::Text(value), Goal::Text(bound)) | (Value::WText(value), Goal::WText(bound)) => {
                let length = value.chars().count();
                let bound = bound.and_then(|bound| usize::try_from(bound).ok());
                if let Some(bound) = bound.filter(|bound| length > *bound) {
                    let message = format!("the string has {length} characters");
                    let help = format!("its type takes at most {bound}");
                    self.error("idl-bad-value", at, message, help);
                    return None;
                }
                Some(ConstantValue::Text(value))
            }
            (
                Value::Enumerator {
                    definition,
                    ordinal,
                },
                Goal::Enum(index),
            ) if definition == *index => Some(ConstantValue::Enumerator {
                definition,
                ordinal,
            }),
            (Value::Enumerator { .. }, Goal::Enum(_)) => {
                let help = "name one of its own enumerators";
                self.error(
                    "idl-bad-value",
                    at,
                    "this is an enumerator of another enum",
                    help,
                );
                None
            }
            (_, goal) => {
                let message = format!("expected {}, found {kind}", goal.takes());
                self.error("idl-bad-value", at, message, goal.example());
                None
            }
        }
    }
}

/// Why two values give none, and advice.
type Wrong = (String, &'static str);

/// What an operator makes of two values.
pub(super) fn combine(operator: &str, left: &Value, right: &Value) -> Result<Value, Wrong> {
    match (left, right) {
        (Value::Integer(left), Value::Integer(right)) => {
            integers(operator, *left, *right).map(Value::Integer)
        }
        (Value::Float(left), Value::Float(right)) => {
            floats(operator, *left, *right).map(Value::Float)
        }
        (Value::Integer(_), Value::Float(_)) | (Value::Float(_), Value::Integer(_)) => {
            let message =
                format!("`{operator}` stands between a whole and a floating-point number");
            Err((message, "write the whole number with a point: 2.0"))
        }
        _ => {
            let message = format!(
                "`{operator}` has no meaning between {} and {}",
                left.kind(),
                right.kind()
            );
            Err((message, "only numbers can be combined"))
        }
    }
}

fn floats(operator: &str, left: f64, right: f64) -> Result<f64, Wrong> {
    let value = match operator {
        "+" => left + right,
        "-" => left - right,
        "*" => left * right,
        "/" if right == 0.0 => {
            return Err((
                "this divides by zero".to_owned(),
                "divide by another number",
            ));
        }
        "/" => left / right,
        _ => {
            let message = format!("`{operator}` has no meaning between floating-point numbers");
            return Err((message, "floating-point numbers know `+`, `-`, `*` and `/`"));
        }
    };
    match value.is_finite() {
        true => Ok(value),
        false => Err((
            "this is too large".to_owned(),
            "the largest `double` is about 1.8e308",
        )),
    }
}

fn integers(operator: &str, left: i128, right: i128) -> Result<i128, Wrong> {
    let shift = u32::try_from(right).ok().filter(|by| *by < 64);
    let value = match operator {
        "|" => Some(left | right),
        "^" => Some(left ^ right),
        "&" => Some(left & right),
        "<<" | ">>" if shift.is_none() => {
            return Err((format!("this shifts by {right}"), "shift by 0 to 63 bits"));
        }
        "<<" => left.checked_mul(1 << shift.unwrap_or_default()),
        ">>" => Some(left >> shift.unwrap_or_default()),
        "+" => left.checked_add(right),
        "-" => left.checked_sub(right),
        "*" => left.checked_mul(right),
        "/" | "%" if right == 0 => {
            return Err((
                "this divides by zero".to_owned(),
                "divide by another number",
            ));
        }
        "/" => left.checked_div(right),
        _ => left.checked_rem(right),
    };
    let fits = |value: &i128| (i128::from(i64::MIN)..=u64::MAX.into()).contains(value);
    value.filter(fits).ok_or_else(|| {
        (
            "this is too large".to_owned(),
            "numbers lie from -2^63 to 2^64-1",
        )
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn complements_are_of_the_width_of_the_type() {
        let goal = |most: i128| Goal::integer(0, most, "x");
        assert_eq!(goal(u32::MAX.into()).complement(0), u32::MAX.into());
        assert_eq!(
            goal(u64::MAX.into()).complement(1),
            i128::from(u64::MAX) - 1
        );
        assert_eq!(Goal::integer(i32::MIN, i32::MAX, "long").complement(5), -6);
    }

    proptest! {
        #[test]
        fn whole_numbers_are_as_those_of_64_bits(left: i64, right: i64, which in 0..10_usize) {
            let operator = ["|", "^", "&", "+", "-", "*", "/", "%", "<<", ">>"][which];
            let expected = match operator {
                "|" => Some(left | right),
                "^" => Some(left ^ right),
                "&" => Some(left & right),
                "+" => left.checked_add(right),
                "-" => left.checked_sub(right),
                "*" => left.checked_mul(right),
                "/" => left.checked_div(right),
                "%" => left.checked_rem(right),
                _ => None,
            };
            let found = integers(operator, left.into(), right.into());
            if let Some(expected) = expected {
                prop_assert_eq!(found, Ok(expected.into()));
            } else if let Ok(found) = found {
                prop_assert!(found > i64::MAX.into() || operator.len() == 2);
            }
        }
    }
}
