//! Value → bytes.

use serde::ser::{
    Impossible, Serialize, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple,
    SerializeTupleStruct, SerializeTupleVariant, Serializer,
};

use super::CdrError;

type Done = Result<(), CdrError>;

const OPTION: CdrError = CdrError::new("CDR has no optional values");
const MAP: CdrError = CdrError::new("CDR has no maps");
const COUNT: CdrError =
    CdrError::new("CDR counts no further than a u32, and counts before it begins");
const ZERO: CdrError = CdrError::new("the string holds a zero");

/// Appends a value to no bytes yet. `BIG`: the most significant byte comes first.
pub fn encode<const BIG: bool, T: Serialize>(value: &T, bytes: &mut Vec<u8>) -> Done {
    value.serialize(&mut Encoder::<BIG> { bytes })
}

struct Encoder<'b, const BIG: bool> {
    bytes: &'b mut Vec<u8>,
}

impl<const BIG: bool> Encoder<'_, BIG> {
    /// The bytes of a number, the least significant one first, at a multiple of their count.
    fn number<const N: usize>(&mut self, mut number: [u8; N]) -> Done {
        let at = self.bytes.len().next_multiple_of(N);
        self.bytes.resize(at, 0);
        if BIG {
            number.reverse();
        }
        self.bytes.extend_from_slice(&number);
        Ok(())
    }

    fn count(&mut self, count: Option<usize>) -> Done {
        let count = count.and_then(|count| u32::try_from(count).ok());
        self.number(count.ok_or(COUNT)?.to_le_bytes())
    }
}

macro_rules! numbers {
    ($($name:ident $kind:ty;)*) => {$(
        fn $name(self, value: $kind) -> Done {
            self.number(value.to_le_bytes())
        }
    )*};
}

impl<const BIG: bool> Serializer for &mut Encoder<'_, BIG> {
    type Ok = ();
    type Error = CdrError;
    type SerializeSeq = Self;
    type SerializeTuple = Self;
    type SerializeTupleStruct = Self;
    type SerializeTupleVariant = Self;
    type SerializeMap = Impossible<(), CdrError>;
    type SerializeStruct = Self;
    type SerializeStructVariant = Self;

    numbers! {
        serialize_i8 i8; serialize_i16 i16; serialize_i32 i32; serialize_i64 i64;
        serialize_u8 u8; serialize_u16 u16; serialize_u32 u32; serialize_u64 u64;
        serialize_f32 f32; serialize_f64 f64;
    }

    fn serialize_bool(self, value: bool) -> Done {
        self.serialize_u8(value.into())
    }

    fn serialize_char(self, value: char) -> Done {
        self.serialize_u32(value.into())
    }

    fn serialize_str(self, text: &str) -> Done {
        if text.as_bytes().contains(&0) {
            return Err(ZERO);
        }
        self.count(text.len().checked_add(1))?;
        self.bytes.extend_from_slice(text.as_bytes());
        self.bytes.push(0);
        Ok(())
    }

    /// As they are: who has octets writes their count before them.
    fn serialize_bytes(self, bytes: &[u8]) -> Done {
        self.bytes.extend_from_slice(bytes);
        Ok(())
    }

    fn serialize_none(self) -> Done {
        Err(OPTION)
    }

    fn serialize_some<T: Serialize + ?Sized>(self, _: &T) -> Done {
        Err(OPTION)
    }

    fn serialize_unit(self) -> Done {
        Ok(())
    }

    fn serialize_unit_struct(self, _: &'static str) -> Done {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, index: u32, _: &'static str) -> Done {
        self.serialize_u32(index)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Done {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        index: u32,
        _: &'static str,
        value: &T,
    ) -> Done {
        self.number(index.to_le_bytes())?;
        value.serialize(self)
    }

    fn serialize_seq(self, count: Option<usize>) -> Result<Self, CdrError> {
        self.count(count)?;
        Ok(self)
    }

    fn serialize_tuple(self, _: usize) -> Result<Self, CdrError> {
        Ok(self)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Self, CdrError> {
        Ok(self)
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        index: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, CdrError> {
        self.number(index.to_le_bytes())?;
        Ok(self)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self::SerializeMap, CdrError> {
        Err(MAP)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, CdrError> {
        Ok(self)
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        index: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, CdrError> {
        self.number(index.to_le_bytes())?;
        Ok(self)
    }

    fn is_human_readable(&self) -> bool {
        false
    }
}

/// What is within comes one after the other, with or without a name.
macro_rules! parts {
    ($($kind:ident $part:ident $($key:ty)?;)*) => {$(
        impl<const BIG: bool> $kind for &mut Encoder<'_, BIG> {
            type Ok = ();
            type Error = CdrError;

            fn $part<T: Serialize + ?Sized>(&mut self, $(_: $key,)? value: &T) -> Done {
                value.serialize(&mut **self)
            }

            fn end(self) -> Done {
                Ok(())
            }
        }
    )*};
}

parts! {
    SerializeSeq serialize_element;
    SerializeTuple serialize_element;
    SerializeTupleStruct serialize_field;
    SerializeTupleVariant serialize_field;
    SerializeStruct serialize_field &'static str;
    SerializeStructVariant serialize_field &'static str;
}
