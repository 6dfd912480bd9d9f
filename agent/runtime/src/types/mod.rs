//! Data types of data ports and their encoding: CDR (XCDR1), little endian, without an encapsulation header.

mod generated;
mod timed;

use byteorder::LittleEndian;
use serde::Serialize;
use serde::de::DeserializeOwned;

pub use generated::{Array, Nested, nested};
pub use timed::{
    Time, TimedBoolean, TimedDouble, TimedDoubleSeq, TimedFloat, TimedFloatSeq, TimedLong,
    TimedLongSeq, TimedOctet, TimedOctetSeq, TimedShort, TimedShortSeq, TimedString,
};

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
/// Only what CDR knows can be encoded: no maps, no `Option`, no sequences of empty structs.
pub trait DataType: Serialize + DeserializeOwned + Send + 'static {
    /// IDL repository id (`IDL:RTC/TimedLong:1.0`).
    const TYPE_ID: &'static str;

    /// Encodes into `buffer`, whose content is replaced and whose memory is reused.
    fn encode(&self, buffer: &mut Vec<u8>) -> Result<(), DataError> {
        buffer.clear();
        cdr_encoding::to_writer::<_, LittleEndian, _>(buffer, self).map_err(|source| {
            DataError::Encode {
                type_id: Self::TYPE_ID,
                source,
            }
        })
    }

    /// Decodes exactly one value.
    ///
    /// Memory is bounded by the input: the decoder grows a sequence with the elements that are really there and takes
    /// no hint from the length that the input claims.
    fn decode(bytes: &[u8]) -> Result<Self, DataError> {
        let (value, used) =
            cdr_encoding::from_bytes::<Self, LittleEndian>(bytes).map_err(DataError::Decode)?;
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
        source: cdr_encoding::Error,
    },
    /// The bytes are no value of the type.
    #[error("the bytes cannot be decoded")]
    Decode(#[source] cdr_encoding::Error),
    /// A value, and then more.
    #[error("{0} bytes are left over")]
    Trailing(usize),
}
