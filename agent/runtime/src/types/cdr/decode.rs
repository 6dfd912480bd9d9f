//! Bytes → value.

use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, SeqAccess,
    VariantAccess, Visitor,
};

use super::CdrError;

const END: CdrError = CdrError::new("unexpected end of input");
const BOOLEAN: CdrError = CdrError::new("a boolean is 0 or 1");
const CHARACTER: CdrError = CdrError::new("it is no character");
const NO_END: CdrError = CdrError::new("the string does not end with a zero");
const ZERO: CdrError = CdrError::new("the string holds a zero");
const UTF8: CdrError = CdrError::new("the string is no UTF-8");
const OPTION: CdrError = CdrError::new("CDR has no optional values");
const MAP: CdrError = CdrError::new("CDR has no maps");
const ANY: CdrError = CdrError::new("CDR does not say of which type a value is");

/// Reads one value, and says how many bytes it has. `BIG`: the most significant byte comes first.
pub fn decode<const BIG: bool, T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, usize), CdrError> {
    let mut decoder = Decoder::<BIG> { bytes, at: 0 };
    let value = T::deserialize(&mut decoder)?;
    Ok((value, decoder.at))
}

struct Decoder<'b, const BIG: bool> {
    bytes: &'b [u8],
    at: usize,
}

impl<'b, const BIG: bool> Decoder<'b, BIG> {
    fn left(&self) -> &'b [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    fn take(&mut self, count: usize) -> Result<&'b [u8], CdrError> {
        let taken = self.left().get(..count).ok_or(END)?;
        self.at += count;
        Ok(taken)
    }

    /// The bytes of a number, the least significant one first, at a multiple of their count.
    fn number<const N: usize>(&mut self) -> Result<[u8; N], CdrError> {
        self.take(self.at.next_multiple_of(N) - self.at)?;
        let mut number: [u8; N] = *self.left().first_chunk().ok_or(END)?;
        self.at += N;
        if BIG {
            number.reverse();
        }
        Ok(number)
    }

    fn count(&mut self) -> Result<usize, CdrError> {
        let count = u32::from_le_bytes(self.number()?);
        usize::try_from(count).map_err(|_| END)
    }

    fn string(&mut self) -> Result<&'b str, CdrError> {
        // Some write an empty string without its zero.
        let text = match self.count()? {
            0 => return Ok(""),
            count => self.take(count)?,
        };
        let Some((0, text)) = text.split_last() else {
            return Err(NO_END);
        };
        if text.contains(&0) {
            return Err(ZERO);
        }
        std::str::from_utf8(text).map_err(|_| UTF8)
    }
}

macro_rules! numbers {
    ($($name:ident $visit:ident $kind:ty;)*) => {$(
        fn $name<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, CdrError> {
            visitor.$visit(<$kind>::from_le_bytes(self.number()?))
        }
    )*};
}

/// What the format cannot hold.
macro_rules! never {
    ($($name:ident $why:expr;)*) => {$(
        fn $name<V: Visitor<'de>>(self, _: V) -> Result<V::Value, CdrError> {
            Err($why)
        }
    )*};
}

impl<'de, const BIG: bool> Deserializer<'de> for &mut Decoder<'_, BIG> {
    type Error = CdrError;

    numbers! {
        deserialize_i8 visit_i8 i8; deserialize_i16 visit_i16 i16;
        deserialize_i32 visit_i32 i32; deserialize_i64 visit_i64 i64;
        deserialize_u8 visit_u8 u8; deserialize_u16 visit_u16 u16;
        deserialize_u32 visit_u32 u32; deserialize_u64 visit_u64 u64;
        deserialize_f32 visit_f32 f32; deserialize_f64 visit_f64 f64;
    }

    never! {
        deserialize_any ANY; deserialize_ignored_any ANY; deserialize_identifier ANY;
        deserialize_option OPTION; deserialize_map MAP;
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, CdrError> {
        match self.number()? {
            [0] => visitor.visit_bool(false),
            [1] => visitor.visit_bool(true),
            _ => Err(BOOLEAN),
        }
    }

    fn deserialize_char<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, CdrError> {
        let number = u32::from_le_bytes(self.number()?);
        visitor.visit_char(char::from_u32(number).ok_or(CHARACTER)?)
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, CdrError> {
        visitor.visit_str(self.string()?)
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, CdrError> {
        self.deserialize_str(visitor)
    }

    fn deserialize_bytes<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, CdrError> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_byte_buf<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, CdrError> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_unit<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, CdrError> {
        visitor.visit_unit()
    }

    fn deserialize_unit_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, CdrError> {
        visitor.visit_unit()
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, CdrError> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, CdrError> {
        let left = self.count()?;
        // Every element has one byte at least.
        if left > self.left().len() {
            return Err(END);
        }
        visitor.visit_seq(Elements { from: self, left })
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        left: usize,
        visitor: V,
    ) -> Result<V::Value, CdrError> {
        visitor.visit_seq(Elements { from: self, left })
    }

    fn deserialize_tuple_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        left: usize,
        visitor: V,
    ) -> Result<V::Value, CdrError> {
        visitor.visit_seq(Elements { from: self, left })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, CdrError> {
        self.deserialize_tuple(fields.len(), visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, CdrError> {
        visitor.visit_enum(Variant(self))
    }

    fn is_human_readable(&self) -> bool {
        false
    }
}

/// One after the other. It gives no hint of their count, so that memory grows with what is really there.
struct Elements<'a, 'b, const BIG: bool> {
    from: &'a mut Decoder<'b, BIG>,
    left: usize,
}

impl<'de, const BIG: bool> SeqAccess<'de> for Elements<'_, '_, BIG> {
    type Error = CdrError;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, CdrError> {
        match self.left.checked_sub(1) {
            Some(left) => {
                self.left = left;
                seed.deserialize(&mut *self.from).map(Some)
            }
            None => Ok(None),
        }
    }
}

/// The number of a variant, and what is within.
struct Variant<'a, 'b, const BIG: bool>(&'a mut Decoder<'b, BIG>);

impl<'de, const BIG: bool> EnumAccess<'de> for Variant<'_, '_, BIG> {
    type Error = CdrError;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), CdrError> {
        let number = u32::from_le_bytes(self.0.number()?);
        let deserializer = IntoDeserializer::<CdrError>::into_deserializer(number);
        Ok((seed.deserialize(deserializer)?, self))
    }
}

impl<'de, const BIG: bool> VariantAccess<'de> for Variant<'_, '_, BIG> {
    type Error = CdrError;

    fn unit_variant(self) -> Result<(), CdrError> {
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, CdrError> {
        seed.deserialize(self.0)
    }

    fn tuple_variant<V: Visitor<'de>>(self, left: usize, visitor: V) -> Result<V::Value, CdrError> {
        self.0.deserialize_tuple(left, visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, CdrError> {
        self.0.deserialize_tuple(fields.len(), visitor)
    }
}
