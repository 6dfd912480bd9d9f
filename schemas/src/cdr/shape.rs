//! What a type is under its names.

use super::{Reason, Value};
use crate::idl::{
    ConstantValue, EnumType, Kind, Label, Primitive, StructType, Type, Union, UnionCase, Unit,
};

/// A type without aliases.
#[derive(Debug, Clone, Copy)]
pub(super) enum Shape<'a> {
    Primitive(Primitive),
    String(Option<u32>),
    WString(Option<u32>),
    Sequence(&'a Type, Option<u32>),
    Array(&'a Type, &'a [u32]),
    Struct(&'a StructType),
    Union(&'a Union),
    Enum(&'a EnumType),
}

/// Follows aliases; a type that no value can have is refused.
pub(super) fn shape<'a>(unit: &'a Unit, mut r#type: &'a Type) -> Result<Shape<'a>, Reason> {
    for _ in 0..=unit.definitions.len() {
        let index = match r#type {
            Type::Primitive(primitive) => return Ok(Shape::Primitive(*primitive)),
            Type::String { bound } => return Ok(Shape::String(*bound)),
            Type::WString { bound } => return Ok(Shape::WString(*bound)),
            Type::Sequence { element, bound } => return Ok(Shape::Sequence(element, *bound)),
            // Elements without a byte could be there without end.
            Type::Array { dimensions, .. } if dimensions.contains(&0) => {
                return Err(Reason::Type("it is an array without elements"));
            }
            Type::Array {
                element,
                dimensions,
            } => return Ok(Shape::Array(element, dimensions)),
            Type::Any => return Err(Reason::Type("`any` is not carried")),
            Type::Object => return Err(Reason::Type("object references are not carried")),
            Type::Named(index) => *index,
        };
        match unit.definitions.get(index).map(|d| &d.kind) {
            Some(Kind::Typedef(alias)) => r#type = &alias.r#type,
            Some(Kind::Struct(it)) if it.members.is_empty() => {
                return Err(Reason::Type("it is a struct without members"));
            }
            Some(Kind::Struct(it)) => return Ok(Shape::Struct(it)),
            Some(Kind::Union(it)) => return Ok(Shape::Union(it)),
            Some(Kind::Enum(it)) => return Ok(Shape::Enum(it)),
            Some(Kind::Interface(_)) => {
                return Err(Reason::Type("object references are not carried"));
            }
            Some(Kind::Forward) => return Err(Reason::Type("its definition was not read")),
            Some(Kind::Constant(_) | Kind::Exception(_)) | None => {
                return Err(Reason::Type("it is no type"));
            }
        }
    }
    Err(Reason::Type("its typedefs go round in a circle"))
}

pub(super) fn is_octet(unit: &Unit, r#type: &Type) -> bool {
    matches!(shape(unit, r#type), Ok(Shape::Primitive(Primitive::Octet)))
}

/// Bytes of a value on the wire, without alignment.
pub(super) fn size(primitive: Primitive) -> usize {
    match primitive {
        Primitive::Boolean | Primitive::Octet | Primitive::Char => 1,
        // A length and a character of UTF-16.
        Primitive::WChar => 3,
        Primitive::Short | Primitive::UShort => 2,
        Primitive::Long | Primitive::ULong | Primitive::Float => 4,
        Primitive::LongLong | Primitive::ULongLong | Primitive::Double => 8,
        Primitive::LongDouble => 16,
    }
}

/// The case that a discriminator chooses; without one the union has no member.
pub(super) fn chosen<'a>(union: &'a Union, discriminator: &Value) -> Option<&'a UnionCase> {
    let labelled = union
        .cases
        .iter()
        .find(|case| case.labels.iter().any(|label| is(label, discriminator)));
    labelled.or_else(|| {
        union
            .cases
            .iter()
            .find(|case| case.labels.contains(&Label::Default))
    })
}

fn is(label: &Label, discriminator: &Value) -> bool {
    let Label::Value(label) = label else {
        return false;
    };
    match (label, discriminator) {
        (ConstantValue::Integer(label), value) => value.integer() == Some(*label),
        (ConstantValue::Boolean(label), Value::Boolean(value)) => label == value,
        (ConstantValue::Char(label), Value::Char(value)) => *label == char::from(*value),
        (ConstantValue::Char(label), Value::WChar(value)) => label == value,
        (ConstantValue::Enumerator { ordinal, .. }, Value::Enum(value)) => ordinal == value,
        _ => false,
    }
}

/// The discriminator that a label stands for.
pub(super) fn discriminator(unit: &Unit, union: &Union, label: &Label) -> Option<Value> {
    let Label::Value(constant) = label else {
        return None;
    };
    match (shape(unit, &union.discriminator).ok()?, constant) {
        (Shape::Primitive(primitive), ConstantValue::Integer(number)) => {
            Value::from_integer(primitive, *number)
        }
        (Shape::Primitive(Primitive::Boolean), ConstantValue::Boolean(it)) => {
            Some(Value::Boolean(*it))
        }
        (Shape::Primitive(Primitive::Char), ConstantValue::Char(it)) => {
            u8::try_from(u32::from(*it)).ok().map(Value::Char)
        }
        (Shape::Primitive(Primitive::WChar), ConstantValue::Char(it)) => Some(Value::WChar(*it)),
        (Shape::Enum(_), ConstantValue::Enumerator { ordinal, .. }) => Some(Value::Enum(*ordinal)),
        _ => None,
    }
}
