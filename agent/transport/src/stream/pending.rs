//! A frame that is on its way out.

use crate::Sample;
use crate::frame::Head;

/// A frame, and how much of it has gone.
#[derive(Debug)]
pub struct Pending {
    head: Head,
    sample: Option<Sample>,
    gone: usize,
}

impl Pending {
    /// Of a sample, so much of which has gone.
    pub fn sample(sample: Sample, head: Head, gone: usize) -> Self {
        Self {
            head,
            sample: Some(sample),
            gone,
        }
    }

    /// Of a good-bye.
    pub fn good_bye() -> Self {
        Self {
            head: Head::good_bye(),
            sample: None,
            gone: 0,
        }
    }

    /// What is left of header and payload.
    pub fn rest(&self) -> (&[u8], &[u8]) {
        let (head, payload) = (self.head.bytes(), self.payload());
        let of_head = self.gone.min(head.len());
        let of_payload = (self.gone - of_head).min(payload.len());
        (&head[of_head..], &payload[of_payload..])
    }

    /// So much more has gone; true when that was all.
    pub fn advance(&mut self, bytes: usize) -> bool {
        self.gone += bytes;
        self.gone >= self.head.bytes().len() + self.payload().len()
    }

    fn payload(&self) -> &[u8] {
        self.sample.as_ref().map_or(&[], |sample| &sample.payload)
    }
}
