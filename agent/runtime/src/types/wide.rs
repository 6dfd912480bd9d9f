//! `wchar` and `wstring`, as GIOP 1.2 has them: UTF-16 with its own byte order, whatever that of the sample is.

use std::fmt;

use serde::de::{Error as _, SeqAccess, Visitor};
use serde::ser::{Error as _, SerializeTuple};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// `wchar`: a character up to U+FFFF.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct WChar(pub char);

/// `wstring`.
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct WString(pub String);

impl From<&str> for WString {
    fn from(text: &str) -> Self {
        Self(text.to_owned())
    }
}

impl From<String> for WString {
    fn from(text: String) -> Self {
        Self(text)
    }
}

impl From<char> for WChar {
    fn from(character: char) -> Self {
        Self(character)
    }
}

impl Serialize for WChar {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let unit = u16::try_from(u32::from(self.0))
            .map_err(|_| S::Error::custom("a wchar ends at U+FFFF"))?;
        let [high, low] = unit.to_be_bytes();
        [2, high, low].serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for WChar {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Bytes;
        impl<'de> Visitor<'de> for Bytes {
            type Value = WChar;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a wchar")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<WChar, A::Error> {
                let mut byte = || {
                    let byte = seq.next_element::<u8>()?;
                    byte.ok_or_else(|| A::Error::custom("a wchar ends too early"))
                };
                let length = byte()?;
                let first = [byte()?, byte()?];
                let unit = match (length, first) {
                    // Two bytes are a character, even where they look like a byte order mark.
                    (2, first) => u16::from_be_bytes(first),
                    (4, [0xfe, 0xff]) => u16::from_be_bytes([byte()?, byte()?]),
                    (4, [0xff, 0xfe]) => u16::from_le_bytes([byte()?, byte()?]),
                    _ => return Err(A::Error::custom("it is no wchar")),
                };
                let character = char::from_u32(unit.into());
                character
                    .map(WChar)
                    .ok_or_else(|| A::Error::custom("half a character"))
            }
        }
        // A length, and with a byte order mark four bytes; it stops where the character ends.
        deserializer.deserialize_tuple(5, Bytes)
    }
}

impl Serialize for WString {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.contains('\0') {
            return Err(S::Error::custom("a wstring cannot hold a zero"));
        }
        let units = self.0.encode_utf16();
        let mark = (!self.0.is_empty()).then_some(0xfeff);
        let length = 2 * (units.clone().count() + usize::from(mark.is_some()));
        let length = u32::try_from(length).map_err(S::Error::custom)?;
        let mut tuple = serializer.serialize_tuple(1 + length as usize)?;
        tuple.serialize_element(&length)?;
        for byte in mark.into_iter().chain(units).flat_map(u16::to_le_bytes) {
            tuple.serialize_element(&byte)?;
        }
        tuple.end()
    }
}

impl<'de> Deserialize<'de> for WString {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let bytes = Vec::<u8>::deserialize(deserializer)?;
        let (units, rest) = bytes.as_chunks::<2>();
        if !rest.is_empty() {
            return Err(D::Error::custom("UTF-16 has an even number of bytes"));
        }
        let text = match units.split_first() {
            Some(([0xff, 0xfe], text)) => read(text, u16::from_le_bytes),
            Some(([0xfe, 0xff], text)) => read(text, u16::from_be_bytes),
            _ => read(units, u16::from_be_bytes),
        };
        match text {
            Some(text) if text.contains('\0') => {
                Err(D::Error::custom("a wstring cannot hold a zero"))
            }
            Some(text) => Ok(Self(text)),
            None => Err(D::Error::custom("the wstring is no UTF-16")),
        }
    }
}

fn read(units: &[[u8; 2]], order: fn([u8; 2]) -> u16) -> Option<String> {
    let units = units.iter().map(|unit| order(*unit));
    char::decode_utf16(units).collect::<Result<_, _>>().ok()
}
