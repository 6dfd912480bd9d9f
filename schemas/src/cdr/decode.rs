//! Bytes → [`Value`].

use super::encode::bounded;
use super::shape::{Shape, chosen, is_octet, shape, size};
use super::{DEEPEST, Endian, Error, Reason, Value};
use crate::idl::{Primitive, Type, Unit};

/// The value that the bytes are, all of them.
pub fn decode(unit: &Unit, r#type: &Type, bytes: &[u8], endian: Endian) -> Result<Value, Error> {
    let mut decoder = Decoder {
        unit,
        endian,
        bytes,
        at: 0,
    };
    decoder
        .value(r#type, 0)
        .and_then(|value| match bytes.len() - decoder.at {
            0 => Ok(value),
            left => Err(Error::at(Reason::Leftover(left), decoder.at)),
        })
        .map_err(|error| error.in_type(unit, r#type))
}

/// The value that begins at this byte.
pub(super) fn value_at(
    unit: &Unit,
    r#type: &Type,
    bytes: &[u8],
    at: usize,
    endian: Endian,
) -> Result<Value, Error> {
    let mut decoder = Decoder {
        unit,
        endian,
        bytes,
        at,
    };
    decoder.value(r#type, 0)
}

struct Decoder<'a> {
    unit: &'a Unit,
    endian: Endian,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Decoder<'a> {
    fn value(&mut self, r#type: &Type, depth: u32) -> Result<Value, Error> {
        if depth > DEEPEST {
            return Err(self.error(Reason::Deep));
        }
        let shape = shape(self.unit, r#type).map_err(|reason| self.error(reason))?;
        Ok(match shape {
            Shape::Primitive(primitive) => self.primitive(primitive)?,
            Shape::String(bound) => Value::String(self.string(bound)?),
            Shape::WString(bound) => Value::WString(self.wstring(bound)?),
            Shape::Sequence(element, bound) => self.sequence(element, bound, depth)?,
            Shape::Array(element, dimensions) => self.array(element, dimensions, depth)?,
            Shape::Enum(it) => {
                let (ordinal, count) = (self.ulong()?, it.enumerators.len());
                if ordinal as usize >= count {
                    return Err(Error::at(
                        Reason::Enumerator { ordinal, count },
                        self.at - 4,
                    ));
                }
                Value::Enum(ordinal)
            }
            Shape::Struct(it) => {
                let mut members = Vec::with_capacity(it.members.len().min(self.left()));
                for member in &it.members {
                    let value = self.value(&member.r#type, depth + 1);
                    members.push(value.map_err(|error| error.in_member(&member.name))?);
                }
                Value::Struct(members)
            }
            Shape::Union(union) => {
                let discriminator = self
                    .value(&union.discriminator, depth + 1)
                    .map_err(|error| error.in_member("$discriminator"))?;
                let member = match chosen(union, &discriminator) {
                    Some(case) => Some(
                        self.value(&case.r#type, depth + 1)
                            .map_err(|error| error.in_member(&case.name))?,
                    ),
                    None => None,
                };
                Value::Union {
                    discriminator: Box::new(discriminator),
                    member: member.map(Box::new),
                }
            }
        })
    }

    fn primitive(&mut self, primitive: Primitive) -> Result<Value, Error> {
        Ok(match primitive {
            Primitive::Boolean => match self.octet()? {
                0 => Value::Boolean(false),
                1 => Value::Boolean(true),
                other => return Err(Error::at(Reason::Boolean(other), self.at - 1)),
            },
            Primitive::Octet => Value::Octet(self.octet()?),
            Primitive::Char => Value::Char(self.octet()?),
            Primitive::WChar => Value::WChar(self.wchar()?),
            Primitive::Short => Value::Short(i16::from_le_bytes(self.number()?)),
            Primitive::UShort => Value::UShort(u16::from_le_bytes(self.number()?)),
            Primitive::Long => Value::Long(i32::from_le_bytes(self.number()?)),
            Primitive::ULong => Value::ULong(self.ulong()?),
            Primitive::LongLong => Value::LongLong(i64::from_le_bytes(self.number()?)),
            Primitive::ULongLong => Value::ULongLong(u64::from_le_bytes(self.number()?)),
            Primitive::Float => Value::Float(f32::from_le_bytes(self.number()?)),
            Primitive::Double => Value::Double(f64::from_le_bytes(self.number()?)),
            Primitive::LongDouble => Value::LongDouble(u128::from_le_bytes(self.number()?)),
        })
    }

    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn error(&self, reason: Reason) -> Error {
        Error::at(reason, self.at)
    }

    fn take(&mut self, needed: usize) -> Result<&'a [u8], Error> {
        let left = self.left();
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let Some((bytes, _)) = rest.split_at_checked(needed) else {
            return Err(self.error(Reason::Ends { needed, left }));
        };
        self.at += needed;
        Ok(bytes)
    }

    fn octet(&mut self) -> Result<u8, Error> {
        Ok(self.take(1)?[0])
    }

    /// The bytes of a number, the least significant one first.
    fn number<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let padding = self.at.next_multiple_of(N.min(8)) - self.at;
        self.take(padding)?;
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        if self.endian == Endian::Big {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn ulong(&mut self) -> Result<u32, Error> {
        self.number().map(u32::from_le_bytes)
    }

    fn string(&mut self, bound: Option<u32>) -> Result<String, Error> {
        let length = self.ulong()? as usize;
        let start = self.at;
        let refuse = |reason| Error::at(reason, start);
        // Some write an empty string without its zero.
        if length == 0 {
            return Ok(String::new());
        }
        bounded(length - 1, bound).map_err(refuse)?;
        let Some((0, text)) = self.take(length)?.split_last() else {
            return Err(refuse(Reason::Text("the string does not end with a zero")));
        };
        if text.contains(&0) {
            return Err(refuse(Reason::Text("the string holds a zero")));
        }
        let text = str::from_utf8(text).map_err(|error| {
            let at = start + error.valid_up_to();
            Error::at(Reason::Text("the string is no UTF-8"), at)
        })?;
        Ok(text.to_owned())
    }

    fn wstring(&mut self, bound: Option<u32>) -> Result<String, Error> {
        let length = self.ulong()? as usize;
        let start = self.at;
        let units = utf16(self.take(length)?).map_err(|reason| Error::at(reason, start))?;
        bounded(units.len(), bound).map_err(|reason| Error::at(reason, start))?;
        if units.contains(&0) {
            return Err(Error::at(Reason::Text("the wstring holds a zero"), start));
        }
        String::from_utf16(&units)
            .map_err(|_| Error::at(Reason::Text("the wstring is no UTF-16"), start))
    }

    fn wchar(&mut self) -> Result<char, Error> {
        let length = self.octet()?.into();
        let start = self.at;
        let unit = match *self.take(length)? {
            // Two bytes are a character, even where they look like a mark.
            [high, low] | [0xfe, 0xff, high, low] | [0xff, 0xfe, low, high] => [high, low],
            _ => [0xd8, 0],
        };
        char::from_u32(u16::from_be_bytes(unit).into())
            .ok_or_else(|| Error::at(Reason::Text("it is no character up to U+FFFF"), start))
    }

    fn sequence(&mut self, element: &Type, bound: Option<u32>, depth: u32) -> Result<Value, Error> {
        let count = self.ulong()?;
        let start = self.at;
        bounded(count as usize, bound).map_err(|reason| Error::at(reason, start))?;
        // Every element has one byte at least.
        let left = self.left();
        if count as usize > left {
            return Err(self.error(Reason::Claim { count, left }));
        }
        self.elements(element, &[], count, depth)
    }

    fn array(&mut self, element: &Type, dimensions: &[u32], depth: u32) -> Result<Value, Error> {
        match dimensions.split_first() {
            None => self.value(element, depth),
            Some(_) if depth > DEEPEST => Err(self.error(Reason::Deep)),
            Some((count, inner)) => self.elements(element, inner, *count, depth),
        }
    }

    /// What is within a sequence, or a dimension of an array. Memory grows with the elements that are there.
    fn elements(
        &mut self,
        element: &Type,
        inner: &[u32],
        count: u32,
        depth: u32,
    ) -> Result<Value, Error> {
        if inner.is_empty() && is_octet(self.unit, element) {
            return Ok(Value::Octets(self.take(count as usize)?.to_vec()));
        }
        let mut elements = Vec::new();
        if inner.is_empty()
            && let Ok(Shape::Primitive(primitive)) = shape(self.unit, element)
        {
            let left = self.left();
            if (count as usize).saturating_mul(size(primitive)) > left {
                return Err(self.error(Reason::Claim { count, left }));
            }
            elements.reserve_exact(count as usize);
        }
        for index in 0..count as usize {
            let value = self.array(element, inner, depth + 1);
            elements.push(value.map_err(|error| error.in_element(index))?);
        }
        Ok(Value::Sequence(elements))
    }
}

/// UTF-16 by its byte order mark, and without one with the most significant byte first.
fn utf16(bytes: &[u8]) -> Result<Vec<u16>, Reason> {
    let (units, rest) = bytes.as_chunks::<2>();
    if !rest.is_empty() {
        return Err(Reason::Text("UTF-16 has an even number of bytes"));
    }
    Ok(match units.split_first() {
        Some(([0xff, 0xfe], text)) => text.iter().map(|unit| u16::from_le_bytes(*unit)).collect(),
        Some(([0xfe, 0xff], text)) => text.iter().map(|unit| u16::from_be_bytes(*unit)).collect(),
        _ => units.iter().map(|unit| u16::from_be_bytes(*unit)).collect(),
    })
}
