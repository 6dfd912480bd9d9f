//! [`Value`] → bytes.

use super::walk::{Form, mismatch, write};
use super::{Endian, Error, Reason, Value};
use crate::idl::{Primitive, Type, Unit};

/// The bytes of a value, from the alignment of a first byte on.
pub fn encode(unit: &Unit, r#type: &Type, value: &Value, endian: Endian) -> Result<Vec<u8>, Error> {
    let mut encoder = Encoder {
        endian,
        bytes: Vec::new(),
    };
    write(unit, r#type, value, &mut encoder)?;
    Ok(encoder.bytes)
}

struct Encoder {
    endian: Endian,
    bytes: Vec<u8>,
}

impl Form for Encoder {
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

    fn string(&mut self, text: &str, bound: Option<u32>) -> Result<(), Reason> {
        bounded(text.len(), bound)?;
        if text.contains('\0') {
            return Err(Reason::Text("a string cannot hold a zero"));
        }
        self.count(text.len() + 1)?;
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
            return self.count(0);
        }
        self.count(2 + 2 * units)?;
        self.bytes.extend([0xff, 0xfe]);
        self.bytes
            .extend(text.encode_utf16().flat_map(u16::to_le_bytes));
        Ok(())
    }

    fn enumerator(&mut self, ordinal: u32, _name: &str) {
        self.number(ordinal.to_le_bytes());
    }

    fn octets(&mut self, bytes: &[u8]) {
        self.bytes.extend(bytes);
    }

    fn length(&mut self, length: usize, bound: Option<u32>) -> Result<(), Reason> {
        bounded(length, bound)?;
        self.count(length)
    }
}

impl Encoder {
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

    fn count(&mut self, length: usize) -> Result<(), Reason> {
        let length = u32::try_from(length).map_err(|_| Reason::TooLong(length))?;
        self.number(length.to_le_bytes());
        Ok(())
    }
}

/// Refuses what is longer than its type permits.
pub(super) fn bounded(length: usize, bound: Option<u32>) -> Result<(), Reason> {
    match bound {
        Some(bound) if length > bound as usize => Err(Reason::Bound { length, bound }),
        _ => Ok(()),
    }
}
