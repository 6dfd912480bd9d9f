//! A value of any IDL type.

use super::shape::{Shape, chosen, is_octet, shape};
use super::{DEEPEST, Error, Reason};
use crate::idl::{Primitive, Type, Unit};

/// A value of any IDL type. What it means is said by its type alone: neither names nor bounds stand here.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// `boolean`.
    Boolean(bool),
    /// `octet`.
    Octet(u8),
    /// `char`: a character of ISO 8859-1.
    Char(u8),
    /// `wchar`: a character up to U+FFFF.
    WChar(char),
    /// `short`.
    Short(i16),
    /// `unsigned short`.
    UShort(u16),
    /// `long`.
    Long(i32),
    /// `unsigned long`.
    ULong(u32),
    /// `long long`.
    LongLong(i64),
    /// `unsigned long long`.
    ULongLong(u64),
    /// `float`.
    Float(f32),
    /// `double`.
    Double(f64),
    /// `long double`: the bits of an IEEE 754 binary128.
    LongDouble(u128),
    /// `string`, without the zero that CDR adds.
    String(String),
    /// `wstring`.
    WString(String),
    /// An enumerator by its number.
    Enum(u32),
    /// A sequence of octets, or the innermost dimension of an array of octets.
    Octets(Vec<u8>),
    /// Any other sequence, or a dimension of an array.
    Sequence(Vec<Value>),
    /// Members in the order of the struct.
    Struct(Vec<Value>),
    /// A union.
    Union {
        /// What chooses the member.
        discriminator: Box<Value>,
        /// None where the discriminator chooses no member.
        member: Option<Box<Value>>,
    },
}

impl Value {
    /// What it is, for messages.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Boolean(_) => "a boolean",
            Self::Octet(_) => "an octet",
            Self::Char(_) => "a char",
            Self::WChar(_) => "a wchar",
            Self::Short(_) => "a short",
            Self::UShort(_) => "an unsigned short",
            Self::Long(_) => "a long",
            Self::ULong(_) => "an unsigned long",
            Self::LongLong(_) => "a long long",
            Self::ULongLong(_) => "an unsigned long long",
            Self::Float(_) => "a float",
            Self::Double(_) => "a double",
            Self::LongDouble(_) => "a long double",
            Self::String(_) => "a string",
            Self::WString(_) => "a wstring",
            Self::Enum(_) => "an enumerator",
            Self::Octets(_) => "a sequence of octets",
            Self::Sequence(_) => "a sequence",
            Self::Struct(_) => "a struct",
            Self::Union { .. } => "a union",
        }
    }

    /// Its number, where it is of an integer type.
    pub(super) fn integer(&self) -> Option<i128> {
        Some(match self {
            Self::Octet(it) => (*it).into(),
            Self::Short(it) => (*it).into(),
            Self::UShort(it) => (*it).into(),
            Self::Long(it) => (*it).into(),
            Self::ULong(it) => (*it).into(),
            Self::LongLong(it) => (*it).into(),
            Self::ULongLong(it) => (*it).into(),
            _ => return None,
        })
    }

    /// A number of an integer type, where it fits.
    pub(super) fn from_integer(primitive: Primitive, number: i128) -> Option<Self> {
        match primitive {
            Primitive::Octet => number.try_into().ok().map(Self::Octet),
            Primitive::Short => number.try_into().ok().map(Self::Short),
            Primitive::UShort => number.try_into().ok().map(Self::UShort),
            Primitive::Long => number.try_into().ok().map(Self::Long),
            Primitive::ULong => number.try_into().ok().map(Self::ULong),
            Primitive::LongLong => number.try_into().ok().map(Self::LongLong),
            Primitive::ULongLong => number.try_into().ok().map(Self::ULongLong),
            _ => None,
        }
    }
}

/// Elements that a value made of nothing may have.
const LARGEST: u64 = 1 << 16;

/// The value of a type that nobody gave: zeros, empty strings and sequences, first enumerators.
pub fn zero(unit: &Unit, r#type: &Type) -> Result<Value, Error> {
    made(unit, r#type, 0, &mut { LARGEST }).map_err(|error| error.in_type(unit, r#type))
}

fn made(unit: &Unit, r#type: &Type, depth: u32, budget: &mut u64) -> Result<Value, Error> {
    if depth > DEEPEST {
        return Err(Reason::Deep.into());
    }
    *budget = budget.checked_sub(1).ok_or(Reason::Large)?;
    Ok(match shape(unit, r#type)? {
        Shape::Primitive(primitive) => zero_of(primitive),
        Shape::String(_) => Value::String(String::new()),
        Shape::WString(_) => Value::WString(String::new()),
        Shape::Sequence(element, _) if is_octet(unit, element) => Value::Octets(Vec::new()),
        Shape::Sequence(..) => Value::Sequence(Vec::new()),
        Shape::Array(element, dimensions) => array(unit, element, dimensions, depth, budget)?,
        Shape::Enum(_) => Value::Enum(0),
        Shape::Struct(it) => {
            let mut members = Vec::new();
            for member in &it.members {
                let value = made(unit, &member.r#type, depth + 1, budget);
                members.push(value.map_err(|error| error.in_member(&member.name))?);
            }
            Value::Struct(members)
        }
        Shape::Union(union) => {
            let discriminator = made(unit, &union.discriminator, depth + 1, budget)?;
            let member = chosen(union, &discriminator)
                .map(|case| made(unit, &case.r#type, depth + 1, budget))
                .transpose()?;
            Value::Union {
                discriminator: Box::new(discriminator),
                member: member.map(Box::new),
            }
        }
    })
}

fn array(
    unit: &Unit,
    element: &Type,
    dimensions: &[u32],
    depth: u32,
    budget: &mut u64,
) -> Result<Value, Error> {
    let Some((length, inner)) = dimensions.split_first() else {
        return made(unit, element, depth, budget);
    };
    if depth > DEEPEST {
        return Err(Reason::Deep.into());
    }
    if inner.is_empty() && is_octet(unit, element) {
        *budget = budget.checked_sub((*length).into()).ok_or(Reason::Large)?;
        return Ok(Value::Octets(vec![0; *length as usize]));
    }
    let mut elements = Vec::new();
    for _ in 0..*length {
        elements.push(array(unit, element, inner, depth + 1, budget)?);
    }
    Ok(Value::Sequence(elements))
}

/// What a primitive type is, for messages.
pub(super) fn named(primitive: Primitive) -> &'static str {
    zero_of(primitive).kind()
}

fn zero_of(primitive: Primitive) -> Value {
    match primitive {
        Primitive::Boolean => Value::Boolean(false),
        Primitive::Octet => Value::Octet(0),
        Primitive::Char => Value::Char(0),
        Primitive::WChar => Value::WChar('\0'),
        Primitive::Short => Value::Short(0),
        Primitive::UShort => Value::UShort(0),
        Primitive::Long => Value::Long(0),
        Primitive::ULong => Value::ULong(0),
        Primitive::LongLong => Value::LongLong(0),
        Primitive::ULongLong => Value::ULongLong(0),
        Primitive::Float => Value::Float(0.0),
        Primitive::Double => Value::Double(0.0),
        Primitive::LongDouble => Value::LongDouble(0),
    }
}
