//! A frame that is on its way out.

use crate::frame::{HEADER, Header};
use crate::{Payload, Sample};

/// A frame, and how much of it has gone.
#[derive(Debug)]
pub struct Pending {
    header: [u8; HEADER],
    sample: Option<Sample>,
    gone: usize,
}

impl Pending {
    /// Of a sample.
    pub fn sample(sample: Sample) -> Self {
        let header = Header::Sample {
            size: sample.payload.len(),
            sequence: sample.sequence,
            time: sample.time,
        };
        Self {
            header: header.encode(),
            sample: Some(sample),
            gone: 0,
        }
    }

    /// Of a good-bye.
    pub fn good_bye() -> Self {
        Self {
            header: Header::GoodBye.encode(),
            sample: None,
            gone: 0,
        }
    }

    /// What is left of header and payload.
    pub fn rest(&self) -> (&[u8], &[u8]) {
        let payload = self.sample.as_ref().map_or(&[][..], |s| &s.payload[..]);
        let of_payload = self.gone.saturating_sub(HEADER).min(payload.len());
        (
            &self.header[self.gone.min(HEADER)..],
            &payload[of_payload..],
        )
    }

    /// So much more has gone; true when that was all.
    pub fn advance(&mut self, bytes: usize) -> bool {
        self.gone += bytes;
        let payload = self.sample.as_ref().map(|s| &s.payload);
        self.gone >= HEADER + payload.map_or(0, Payload::len)
    }

    /// The sample, when nothing of it has gone yet.
    pub fn untouched(self) -> Result<Sample, Self> {
        match self {
            Self {
                sample: Some(sample),
                gone: 0,
                ..
            } => Ok(sample),
            begun => Err(begun),
        }
    }
}
