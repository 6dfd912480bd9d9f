//! `sequence<octet>`, written as one piece.

use serde::ser::{Error, SerializeTuple};
use serde::{Serialize, Serializer};

/// Writes a `Vec<u8>` as a length and the octets: `#[serde(serialize_with = "rts_runtime::types::octets")]` on a field.
///
/// The bytes are the same without it, but serde then makes a call for each octet, which an image feels.
///
/// # Errors
/// When there are more than a `u32` counts.
pub fn octets<S: Serializer>(octets: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    let length = u32::try_from(octets.len()).map_err(S::Error::custom)?;
    let mut tuple = serializer.serialize_tuple(2)?;
    tuple.serialize_element(&length)?;
    tuple.serialize_element(&Piece(octets))?;
    tuple.end()
}

struct Piece<'a>(&'a [u8]);

impl Serialize for Piece<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.0)
    }
}
