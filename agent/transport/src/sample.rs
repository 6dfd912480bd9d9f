//! What travels.

use std::fmt;

/// The payload of a sample, shared by all connectors that it goes to.
pub type Payload = bytes::Bytes;

/// Largest payload of a sample in bytes.
pub const MAX_SAMPLE: usize = 64 * 1024 * 1024;

/// A sample on its way.
#[derive(Clone, PartialEq, Eq)]
pub struct Sample {
    /// Its number, given by whoever sends it.
    pub sequence: u64,
    /// When it was written, in nanoseconds of a clock that both ends agree on.
    pub time: u64,
    /// Its value, encoded.
    pub payload: Payload,
}

impl fmt::Debug for Sample {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            sequence,
            time,
            payload,
        } = self;
        write!(f, "sample {sequence} of {} bytes at {time}", payload.len())
    }
}
