//! Data types of data ports and their encoding: CDR (XCDR1) without an encapsulation header.
//!
//! Components write and read little endian; tools may use either order. docs/adr/0019-cdr.md says what CDR leaves open.

mod cdr;
mod generated;
mod octets;
mod timed;
mod wide;

use serde::Serialize;
use serde::de::DeserializeOwned;

/// All other types of OpenRTM-aist's IDL files, as `rtsctl idl generate` makes them.
mod openrtm {
    include!("openrtm.rs");
}

pub use cdr::CdrError;
pub use generated::{Array, Nested, nested};
pub use octets::octets;
pub use openrtm::RTC::*;
pub use timed::{
    Time, TimedBoolean, TimedDouble, TimedDoubleSeq, TimedFloat, TimedFloatSeq, TimedLong,
    TimedLongSeq, TimedOctet, TimedOctetSeq, TimedShort, TimedShortSeq, TimedString,
};

pub use wide::{WChar, WString};

/// Order of the bytes of a number.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Endian {
    /// Least significant byte first.
    #[default]
    Little,
    /// Most significant byte first.
    Big,
}

/// A type that ports can carry: any serde type whose fields are in the order of its IDL struct.
///
/// ```
/// #[derive(serde::Serialize, serde::Deserialize)]
/// struct Point2D { x: f64, y: f64 }
///
/// impl rts_runtime::types::DataType for Point2D {
///     const TYPE_ID: &'static str = "IDL:RTC/Point2D:1.0";
/// }
/// ```
///
/// Only what CDR knows can be encoded: no maps, no `Option`, no sequences of empty structs, no text with a zero in it. How the types of IDL are
/// written in Rust:
///
/// | IDL | Rust |
/// |---|---|
/// | `char` | `u8` (a Rust `char` has four bytes) |
/// | `wchar`, `wstring` | [`WChar`], [`WString`] |
/// | `sequence<T>` | `Vec<T>`; `sequence<octet>` with [`octets`] |
/// | `T x[2][3]` | `[[T; 3]; 2]` |
/// | `enum` | an enum without data, which is a `u32` |
/// | `union` | a tuple of the discriminator and the member: not the enum that serde derives, whose discriminator is a `u32` |
pub trait DataType: Serialize + DeserializeOwned + Send + 'static {
    /// IDL repository id (`IDL:RTC/TimedLong:1.0`).
    const TYPE_ID: &'static str;

    /// Encodes into `buffer` with the least significant byte first, as ports do.
    fn encode(&self, buffer: &mut Vec<u8>) -> Result<(), DataError> {
        self.encode_as(Endian::Little, buffer)
    }

    /// Encodes into `buffer`, whose content is replaced and whose memory is reused.
    fn encode_as(&self, endian: Endian, buffer: &mut Vec<u8>) -> Result<(), DataError> {
        buffer.clear();
        match endian {
            Endian::Little => cdr::encode::<false, _>(self, buffer),
            Endian::Big => cdr::encode::<true, _>(self, buffer),
        }
        .map_err(|source| DataError::Encode {
            type_id: Self::TYPE_ID,
            source,
        })
    }

    /// Decodes exactly one value whose least significant byte comes first.
    fn decode(bytes: &[u8]) -> Result<Self, DataError> {
        Self::decode_as(Endian::Little, bytes)
    }

    /// Decodes exactly one value.
    ///
    /// Memory is bounded by the input: the decoder grows a sequence with the elements that are really there and takes
    /// no hint from the length that the input claims.
    fn decode_as(endian: Endian, bytes: &[u8]) -> Result<Self, DataError> {
        let (value, used) = match endian {
            Endian::Little => cdr::decode::<false, Self>(bytes),
            Endian::Big => cdr::decode::<true, Self>(bytes),
        }
        .map_err(DataError::Decode)?;
        match bytes.len() - used {
            0 => Ok(value),
            left => Err(DataError::Trailing(left)),
        }
    }
}

/// A sample cannot be encoded or decoded.
#[derive(Debug, thiserror::Error)]
pub enum DataError {
    /// Not encodable.
    #[error("cannot encode a {type_id}")]
    Encode {
        /// Type.
        type_id: &'static str,
        /// Why.
        #[source]
        source: CdrError,
    },
    /// The bytes are no value of the type.
    #[error("the bytes cannot be decoded")]
    Decode(#[source] CdrError),
    /// A value, and then more.
    #[error("{0} bytes are left over")]
    Trailing(usize),
}
