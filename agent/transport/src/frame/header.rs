//! The header of a frame.

use std::fmt;

use crate::MAX_SAMPLE;

/// Bytes of a header.
pub const HEADER: usize = 24;

/// Marks of the kinds, which also tell frames from other bytes.
const SAMPLE: u32 = u32::from_be_bytes(*b"RTCs");
const GOOD_BYE: u32 = u32::from_be_bytes(*b"RTCb");

/// What a frame is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Header {
    /// A sample, whose payload follows.
    Sample {
        /// Bytes of the payload.
        size: usize,
        /// Its number.
        sequence: u64,
        /// When it was written.
        time: u64,
    },
    /// Nothing follows any more, by an order.
    GoodBye,
}

/// Bytes that are no header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Malformed {
    /// No frame begins like this.
    Kind(u32),
    /// No sample is so long.
    TooLarge(u32),
    /// No sample is so short, of version 1.
    TooShort(u32),
    /// More is said with a good-bye than that.
    GoodBye,
    /// Bytes follow a good-bye.
    AfterGoodBye,
}

impl fmt::Display for Malformed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kind(kind) => write!(f, "it sent bytes that are no frame (kind {kind:#010x})"),
            Self::TooLarge(size) => write!(
                f,
                "it announced a sample of {size} bytes: at most {MAX_SAMPLE} are taken"
            ),
            Self::TooShort(size) => write!(f, "it announced a frame of {size} bytes"),
            Self::GoodBye => f.write_str("it sent a good-bye with something in it"),
            Self::AfterGoodBye => f.write_str("it went on sending after its good-bye"),
        }
    }
}

impl std::error::Error for Malformed {}

impl Header {
    /// As it travels. The size of a sample is at most [`MAX_SAMPLE`].
    pub fn encode(self) -> [u8; HEADER] {
        let (size, kind, sequence, time) = match self {
            Self::Sample {
                size,
                sequence,
                time,
            } => (size as u32, SAMPLE, sequence, time),
            Self::GoodBye => (0, GOOD_BYE, 0, 0),
        };
        let mut bytes = [0; HEADER];
        bytes[..4].copy_from_slice(&size.to_be_bytes());
        bytes[4..8].copy_from_slice(&kind.to_be_bytes());
        bytes[8..16].copy_from_slice(&sequence.to_be_bytes());
        bytes[16..].copy_from_slice(&time.to_be_bytes());
        bytes
    }

    /// From what came.
    pub fn decode(bytes: &[u8; HEADER]) -> Result<Self, Malformed> {
        let word = |at: usize| u32::from_be_bytes(std::array::from_fn(|i| bytes[at + i]));
        let long = |at: usize| u64::from_be_bytes(std::array::from_fn(|i| bytes[at + i]));
        let (size, kind, sequence, time) = (word(0), word(4), long(8), long(16));
        match kind {
            SAMPLE if size as usize > MAX_SAMPLE => Err(Malformed::TooLarge(size)),
            SAMPLE => Ok(Self::Sample {
                size: size as usize,
                sequence,
                time,
            }),
            GOOD_BYE if (size, sequence, time) != (0, 0, 0) => Err(Malformed::GoodBye),
            GOOD_BYE => Ok(Self::GoodBye),
            kind => Err(Malformed::Kind(kind)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_is_read_as_it_was_written() {
        let sample = Header::Sample {
            size: 0x0102_0304,
            sequence: 0x1112_1314_1516_1718,
            time: u64::MAX,
        };
        for header in [sample, Header::GoodBye] {
            assert_eq!(Header::decode(&header.encode()), Ok(header));
        }
        assert_eq!(sample.encode()[..8], *b"\x01\x02\x03\x04RTCs");
    }

    #[test]
    fn what_is_no_header_is_refused() {
        let mut large = Header::GoodBye.encode();
        large[4..8].copy_from_slice(b"RTCs");
        large[..4].copy_from_slice(&(MAX_SAMPLE as u32 + 1).to_be_bytes());
        let mut talkative = Header::GoodBye.encode();
        talkative[23] = 1;
        for (bytes, malformed) in [
            ([0; HEADER], Malformed::Kind(0)),
            (large, Malformed::TooLarge(MAX_SAMPLE as u32 + 1)),
            (talkative, Malformed::GoodBye),
        ] {
            assert_eq!(Header::decode(&bytes), Err(malformed));
        }
    }
}
