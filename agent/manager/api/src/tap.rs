//! Messages of a tap: a connection that looks at what an out-port writes, or writes to an in-port, for as long as it
//! lasts. A tap is no connector: nobody plans it, and nothing is left of it once its connection has ended.
//!
//! After [`TapHello`] and [`TapReply`] (JSON frames), samples follow in one direction: u32 length in network order,
//! counting what follows; u64 time of writing in nanoseconds since 1970; u64 number of samples that were missed before
//! it; the payload (`cdr-le`). [`END`] instead of a length ends them.
//!
//! Of an out-port the manager sends, and says [`END`] when there will be no more; of an in-port it receives. In both cases
//! [`TapEnd`] is its last frame.
//!
//! A manager that does not know taps closes the connection instead of an answer to [`TapHello`].

use serde::{Deserialize, Serialize};

use crate::control::Failure;

/// Largest payload, in bytes: that of a connector.
pub const MAX_SAMPLE: usize = 64 * 1024 * 1024;

/// Bytes of a sample before its payload, besides its length.
const HEAD: usize = 16;

/// Instead of the length of a sample: there are no more.
pub const END: [u8; 4] = [0; 4];

/// First frame of a tap.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TapHello {
    /// Oldest protocol version in which this message can be understood.
    pub version: u32,
    /// Instance with the port.
    pub instance: String,
    /// Bare name of the port.
    pub port: String,
    /// What to do there.
    pub way: TapWay,
}

/// What a tap does.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(
    tag = "kind",
    rename_all = "camelCase",
    rename_all_fields = "camelCase"
)]
pub enum TapWay {
    /// Looks at what an out-port writes.
    Print,
    /// Writes to an in-port.
    Inject {
        /// Repository id of the samples; another one than the port's is refused.
        data_type: String,
        /// How long a sample waits for room in the port's buffer before it is dropped; with 0 the oldest goes for it.
        wait_ms: u64,
        /// How long the last samples may wait to be read.
        linger_ms: u64,
    },
}

/// Answer to [`TapHello`]. After an error the connection is closed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TapReply {
    /// Outcome.
    pub result: Result<TapOpened, Failure>,
}

/// The port of a tap.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TapOpened {
    /// Incarnation of its component.
    pub incarnation: String,
    /// IDL repository id of the samples.
    pub data_type: String,
}

/// Last frame of a manager.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TapEnd {
    /// Samples that came.
    pub taken: u64,
    /// Those of them that the component has read.
    pub read: u64,
    /// Those of them that found no room.
    pub dropped: u64,
    /// Why it ended, when nobody asked for that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failure: Option<Failure>,
}

/// What stands before a payload.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TapSample {
    /// Bytes of the payload.
    pub length: usize,
    /// Time of writing, in nanoseconds since 1970.
    pub time: u64,
    /// Samples that were missed before it, since the tap began.
    pub missed: u64,
}

impl TapSample {
    /// Its bytes, with the length.
    pub fn head(&self) -> [u8; 4 + HEAD] {
        let mut head = [0; 4 + HEAD];
        let length = u32::try_from(HEAD + self.length).unwrap_or(u32::MAX);
        head[..4].copy_from_slice(&length.to_be_bytes());
        head[4..12].copy_from_slice(&self.time.to_be_bytes());
        head[12..].copy_from_slice(&self.missed.to_be_bytes());
        head
    }

    /// How many bytes follow a length; none for [`END`], and an error for a length that no sample has.
    pub fn announced(length: [u8; 4]) -> Result<Option<usize>, u32> {
        let length = u32::from_be_bytes(length);
        match length as usize {
            0 => Ok(None),
            bytes if (HEAD..=HEAD + MAX_SAMPLE).contains(&bytes) => Ok(Some(bytes)),
            _ => Err(length),
        }
    }

    /// Splits what follows a length.
    pub fn split(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let (head, payload) = bytes.split_at_checked(HEAD)?;
        let number = |at: usize| head[at..at + 8].try_into().map(u64::from_be_bytes);
        let sample = Self {
            length: payload.len(),
            time: number(0).ok()?,
            missed: number(8).ok()?,
        };
        Some((sample, payload))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_comes_back_as_it_went() {
        let sample = TapSample {
            length: 3,
            time: 1_700_000_000_000_000_001,
            missed: 7,
        };
        let mut bytes = sample.head().to_vec();
        bytes.extend_from_slice(b"abc");
        let length = TapSample::announced(bytes[..4].try_into().unwrap());
        assert_eq!(length, Ok(Some(bytes.len() - 4)));
        assert_eq!(TapSample::split(&bytes[4..]), Some((sample, &b"abc"[..])));
    }

    #[test]
    fn lengths_that_no_sample_has_are_refused() {
        assert_eq!(TapSample::announced(END), Ok(None));
        for wrong in [1, 15, u32::MAX] {
            assert_eq!(TapSample::announced(wrong.to_be_bytes()), Err(wrong));
        }
        assert_eq!(TapSample::announced(16u32.to_be_bytes()), Ok(Some(16)));
        assert_eq!(TapSample::split(&[0; 15]), None);
    }
}
