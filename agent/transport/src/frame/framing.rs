//! How frames look: those of today, and those that version 1 of the manager protocol has.

use super::header::{HEADER, Header, Malformed};
use crate::{MAX_SAMPLE, Sample};

/// How the frames of a connection look.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Framing {
    /// As [`Header`] has them.
    #[default]
    Timed,
    /// Of version 1: u32 length of what follows, u64 sequence number, both in network order, and the payload. No time
    /// travels, and nothing says good-bye.
    Plain,
}

/// Bytes of a header of version 1, and of its length in that.
const PLAIN: usize = 12;
const NUMBER: usize = 8;

impl Framing {
    /// Whether an end can be told from a loss.
    pub fn has_good_byes(self) -> bool {
        self == Self::Timed
    }

    /// Bytes of a header.
    pub(crate) fn header(self) -> usize {
        match self {
            Self::Timed => HEADER,
            Self::Plain => PLAIN,
        }
    }

    /// The header at the beginning of these bytes, once it is whole.
    pub(crate) fn decode(self, bytes: &[u8]) -> Result<Option<Header>, Malformed> {
        match self {
            Self::Timed => bytes.first_chunk().map(Header::decode).transpose(),
            Self::Plain => bytes.first_chunk().map(plain).transpose(),
        }
    }
}

fn plain(bytes: &[u8; PLAIN]) -> Result<Header, Malformed> {
    let length = u32::from_be_bytes(std::array::from_fn(|i| bytes[i]));
    let sequence = u64::from_be_bytes(std::array::from_fn(|i| bytes[PLAIN - NUMBER + i]));
    let size = (length as usize)
        .checked_sub(NUMBER)
        .ok_or(Malformed::TooShort(length))?;
    if size > MAX_SAMPLE {
        return Err(Malformed::TooLarge(length));
    }
    Ok(Header::Sample {
        size,
        sequence,
        time: 0,
    })
}

/// A header as it travels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Head {
    bytes: [u8; HEADER],
    length: usize,
}

impl Head {
    /// Of a sample, which is no larger than [`MAX_SAMPLE`].
    pub fn of(sample: &Sample, framing: Framing) -> Self {
        let size = sample.payload.len();
        let (sequence, time) = (sample.sequence, sample.time);
        let header = match framing {
            Framing::Timed => Header::Sample {
                size,
                sequence,
                time,
            },
            Framing::Plain => {
                let mut bytes = [0; HEADER];
                bytes[..4].copy_from_slice(&((NUMBER + size) as u32).to_be_bytes());
                bytes[4..PLAIN].copy_from_slice(&sequence.to_be_bytes());
                return Self {
                    bytes,
                    length: PLAIN,
                };
            }
        };
        Self::whole(header)
    }

    /// Of a good-bye.
    pub fn good_bye() -> Self {
        Self::whole(Header::GoodBye)
    }

    fn whole(header: Header) -> Self {
        Self {
            bytes: header.encode(),
            length: HEADER,
        }
    }

    /// What travels.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_of_version_1_is_a_length_a_number_and_the_payload() {
        let sample = Sample {
            sequence: 0x0102,
            time: 7,
            payload: vec![0; 3].into(),
        };
        let head = Head::of(&sample, Framing::Plain);
        assert_eq!(head.bytes(), [0, 0, 0, 11, 0, 0, 0, 0, 0, 0, 1, 2]);
        let expected = Header::Sample {
            size: 3,
            sequence: 0x0102,
            time: 0,
        };
        assert_eq!(Framing::Plain.decode(head.bytes()), Ok(Some(expected)));
        assert_eq!(Framing::Plain.decode(&head.bytes()[..11]), Ok(None));
    }

    #[test]
    fn lengths_that_cannot_be_are_refused() {
        for (length, malformed) in [
            (7, Malformed::TooShort(7)),
            (u32::MAX, Malformed::TooLarge(u32::MAX)),
        ] {
            let mut bytes = [0; PLAIN];
            bytes[..4].copy_from_slice(&length.to_be_bytes());
            assert_eq!(Framing::Plain.decode(&bytes), Err(malformed));
        }
    }
}
