//! Text → the bytes of a file in the encoding in which it was read.

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE};

use super::EditError;
use crate::xml::decode;

/// The bytes that a file had, and how they mean text.
#[derive(Debug, Clone)]
pub(super) struct Bytes {
    original: Vec<u8>,
    encoding: &'static Encoding,
    mark: usize,
}

impl Bytes {
    pub(super) fn of(original: &[u8], encoding: &str) -> Self {
        Self {
            original: original.to_vec(),
            encoding: Encoding::for_label(encoding.as_bytes()).unwrap_or(UTF_8),
            mark: Encoding::for_bom(original).map_or(0, |(_, length)| length),
        }
    }

    /// The original bytes for the original text; for another the same encoding, if that keeps the original.
    pub(super) fn of_text(&self, text: &str) -> Result<Vec<u8>, EditError> {
        let lost = EditError::Encoding(self.encoding.name());
        let original = decode("", &self.original).map_err(|_| lost.clone())?.text;
        if original == text {
            return Ok(self.original.clone());
        }
        if self.encode(&original) != self.original {
            return Err(lost);
        }
        Ok(self.encode(text))
    }

    fn encode(&self, text: &str) -> Vec<u8> {
        let mut bytes = self.original[..self.mark].to_vec();
        if self.encoding == UTF_16LE {
            bytes.extend(text.encode_utf16().flat_map(u16::to_le_bytes));
        } else if self.encoding == UTF_16BE {
            bytes.extend(text.encode_utf16().flat_map(u16::to_be_bytes));
        } else {
            bytes.extend_from_slice(&self.encoding.encode(text).0);
        }
        bytes
    }
}
