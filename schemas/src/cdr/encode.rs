//! [`Value`] → bytes.

use super::shape::{Shape, chosen, shape};
use super::{DEEPEST, Endian, Error, Reason, Value};
use crate::idl::{Primitive, Type, Unit};

/// The bytes of a value, from the alignment of a first byte on.
pub fn encode(unit: &Unit, r#type: &Type, value: &Value, endian: Endian) -> Result<Vec<u8>, Error> {
    let mut encoder = Encoder {
        unit,
        endian,
        bytes: Vec::new(),
    };
    encoder
        .value(r#type, value, 0)
        .map_err(|error| error.in_type(unit, r#type))?;
    Ok(encoder.bytes)
}

struct Encoder<'a> {
    unit: &'a Unit,
    endian: Endian,
    bytes: Vec<u8>,
}

impl Encoder<'_> {
    fn value(&mut self, r#type: &Type, value: &Value, depth: u32) -> Result<(), Error> {
        if depth > DEEPEST {
            return Err(Reason::Deep.into());
        }
        match (shape(self.unit, r#type)?, value) {
            (Shape::Primitive(primitive), value) => self.primitive(primitive, value)?,
            (Shape::String(bound), Value::String(text)) => self.string(text, bound)?,
            (Shape::WString(bound), Value::WString(text)) => self.wstring(text, bound)?,
            (Shape::Enum(it), Value::Enum(ordinal)) => {
                let count = it.enumerators.len();
                let ordinal = *ordinal;
                if ordinal as usize >= count {
                    return Err(Reason::Enumerator { ordinal, count }.into());
                }
                self.number(ordinal.to_le_bytes());
            }
            (Shape::Sequence(element, bound), value) => {
                self.sequence(element, bound, value, depth)?;
            }
            (Shape::Array(element, dimensions), value) => {
                self.array(element, dimensions, value, depth)?;
            }
            (Shape::Struct(it), Value::Struct(members)) => {
                let (found, count) = (members.len(), it.members.len());
                if found != count {
                    return Err(Reason::Members { found, count }.into());
                }
                for (member, value) in it.members.iter().zip(members) {
                    self.value(&member.r#type, value, depth + 1)
                        .map_err(|error| error.in_member(&member.name))?;
                }
            }
            (
                Shape::Union(union),
                Value::Union {
                    discriminator,
                    member,
                },
            ) => {
                self.value(&union.discriminator, discriminator, depth + 1)
                    .map_err(|error| error.in_member("$discriminator"))?;
                match (chosen(union, discriminator), member) {
                    (Some(case), Some(value)) => self
                        .value(&case.r#type, value, depth + 1)
                        .map_err(|error| error.in_member(&case.name))?,
                    (None, None) => {}
                    (Some(_), None) => return Err(Reason::Union("its member is missing").into()),
                    (None, Some(_)) => {
                        return Err(Reason::Union(
                            "its discriminator chooses no member, there is one",
                        )
                        .into());
                    }
                }
            }
            (Shape::String(_), other) => return Err(mismatch("a string", other).into()),
            (Shape::WString(_), other) => return Err(mismatch("a wstring", other).into()),
            (Shape::Enum(_), other) => return Err(mismatch("an enumerator", other).into()),
            (Shape::Struct(_), other) => return Err(mismatch("a struct", other).into()),
            (Shape::Union(_), other) => return Err(mismatch("a union", other).into()),
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: Primitive, value: &Value) -> Result<(), Reason> {
        match (primitive, value) {
            (Primitive::Boolean, Value::Boolean(it)) => self.bytes.push((*it).into()),
            (Primitive::Octet, Value::Octet(it)) | (Primitive::Char, Value::Char(it)) => {
                self.bytes.push(*it);
            }
            (Primitive::WChar, Value::WChar(it)) => {
                let unit = u16::try_from(u32::from(*it))
                    .map_err(|_| Reason::Text("a wchar ends at U+FFFF"))?;
                // Without a byte order mark the most significant byte comes first, whatever the stream's order.
                self.bytes.push(2);
                self.bytes.extend(unit.to_be_bytes());
            }
            (Primitive::Short, Value::Short(it)) => self.number(it.to_le_bytes()),
            (Primitive::UShort, Value::UShort(it)) => self.number(it.to_le_bytes()),
            (Primitive::Long, Value::Long(it)) => self.number(it.to_le_bytes()),
            (Primitive::ULong, Value::ULong(it)) => self.number(it.to_le_bytes()),
            (Primitive::LongLong, Value::LongLong(it)) => self.number(it.to_le_bytes()),
            (Primitive::ULongLong, Value::ULongLong(it)) => self.number(it.to_le_bytes()),
            (Primitive::Float, Value::Float(it)) => self.number(it.to_le_bytes()),
            (Primitive::Double, Value::Double(it)) => self.number(it.to_le_bytes()),
            (Primitive::LongDouble, Value::LongDouble(it)) => self.number(it.to_le_bytes()),
            (primitive, other) => return Err(mismatch(super::value::named(primitive), other)),
        }
        Ok(())
    }

    /// A number whose bytes come with the least significant one first.
    fn number<const N: usize>(&mut self, mut bytes: [u8; N]) {
        // Nothing is aligned to more than 8 bytes, long double neither.
        let aligned = self.bytes.len().next_multiple_of(N.min(8));
        self.bytes.resize(aligned, 0);
        if self.endian == Endian::Big {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
    }

    fn length(&mut self, length: usize) -> Result<(), Reason> {
        let length = u32::try_from(length).map_err(|_| Reason::TooLong(length))?;
        self.number(length.to_le_bytes());
        Ok(())
    }

    fn string(&mut self, text: &str, bound: Option<u32>) -> Result<(), Reason> {
        bounded(text.len(), bound)?;
        if text.contains('\0') {
            return Err(Reason::Text("a string cannot hold a zero"));
        }
        self.length(text.len() + 1)?;
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
        Ok(())
    }

    /// As GIOP 1.2 has it: the length in bytes, a byte order mark, UTF-16, no zero.
    fn wstring(&mut self, text: &str, bound: Option<u32>) -> Result<(), Reason> {
        let units = text.encode_utf16().count();
        bounded(units, bound)?;
        if text.contains('\0') {
            return Err(Reason::Text("a wstring cannot hold a zero"));
        }
        if units == 0 {
            return self.length(0);
        }
        self.length(2 + 2 * units)?;
        self.bytes.extend([0xff, 0xfe]);
        self.bytes
            .extend(text.encode_utf16().flat_map(u16::to_le_bytes));
        Ok(())
    }

    fn sequence(
        &mut self,
        element: &Type,
        bound: Option<u32>,
        value: &Value,
        depth: u32,
    ) -> Result<(), Error> {
        let length = length_of(value)?;
        bounded(length, bound)?;
        self.length(length)?;
        self.elements(element, &[], value, depth)
    }

    fn array(
        &mut self,
        element: &Type,
        dimensions: &[u32],
        value: &Value,
        depth: u32,
    ) -> Result<(), Error> {
        let Some((length, inner)) = dimensions.split_first() else {
            return self.value(element, value, depth);
        };
        if depth > DEEPEST {
            return Err(Reason::Deep.into());
        }
        let (found, length) = (length_of(value)?, *length);
        if found != length as usize {
            return Err(Reason::Length { found, length }.into());
        }
        self.elements(element, inner, value, depth)
    }

    /// What is within a sequence, or a dimension of an array.
    fn elements(
        &mut self,
        element: &Type,
        inner: &[u32],
        value: &Value,
        depth: u32,
    ) -> Result<(), Error> {
        let octets = inner.is_empty() && super::shape::is_octet(self.unit, element);
        match value {
            Value::Octets(bytes) if octets => self.bytes.extend(bytes),
            Value::Sequence(elements) if !octets => {
                for (index, value) in elements.iter().enumerate() {
                    self.array(element, inner, value, depth + 1)
                        .map_err(|error| error.in_element(index))?;
                }
            }
            other if octets => return Err(mismatch("a sequence of octets", other).into()),
            other => return Err(mismatch("a sequence", other).into()),
        }
        Ok(())
    }
}

pub(super) fn length_of(value: &Value) -> Result<usize, Reason> {
    match value {
        Value::Octets(bytes) => Ok(bytes.len()),
        Value::Sequence(elements) => Ok(elements.len()),
        other => Err(mismatch("a sequence", other)),
    }
}

pub(super) fn mismatch(wanted: &'static str, found: &Value) -> Reason {
    Reason::Mismatch {
        wanted,
        found: found.kind(),
    }
}

/// Refuses what is longer than its type permits.
pub(super) fn bounded(length: usize, bound: Option<u32>) -> Result<(), Reason> {
    match bound {
        Some(bound) if length > bound as usize => Err(Reason::Bound { length, bound }),
        _ => Ok(()),
    }
}
