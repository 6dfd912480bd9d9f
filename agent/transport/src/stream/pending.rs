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
    /// Of a sample, so much of which has gone.
    pub fn sample(sample: Sample, header: [u8; HEADER], gone: usize) -> Self {
        Self {
            header,
            sample: Some(sample),
            gone,
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
}
