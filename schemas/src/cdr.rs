//! CDR (XCDR1, the encoding of GIOP) of values whose type is known from IDL: bytes ↔ [`Value`] ↔ JSON.
//!
//! Alignment counts from the first byte; there is no encapsulation header. What is read is bounded by the bytes that are
//! there, never by a length that they claim. Why it is not a serde codec: docs/adr/0019-cdr.md.

mod decode;
mod encode;
mod error;
mod json;
mod quad;
mod shape;
mod swap;
#[cfg(test)]
mod tests;
mod value;
mod walk;

pub use decode::decode;
pub use encode::encode;
pub use error::{Error, Reason};
pub use json::{from_json, to_json};
pub use swap::swap;
pub use value::{Value, zero};

/// Order of the bytes of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Endian {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

/// Types within types that are followed; only a type that holds itself has more.
const DEEPEST: u32 = 64;
