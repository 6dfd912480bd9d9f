//! One end of a way to the other process and back.

use std::time::Duration;

use rts_transport::{Parting, Receiver, Sample, Sender};

use crate::bytes_of::{Payloads, expected, sum};

const PATIENCE: Duration = Duration::from_secs(20);

/// An end.
pub trait Link {
    /// Sends the sample of this number.
    fn send(&mut self, sequence: u64);

    /// Receives the sample of this number and requires that it is right; false when there is none any more.
    fn receive(&mut self, sequence: u64) -> bool;
}

/// Over a transport.
pub struct Transported {
    pub sender: Box<dyn Sender>,
    pub receiver: Box<dyn Receiver>,
    pub payloads: Payloads,
}

impl Link for Transported {
    fn send(&mut self, sequence: u64) {
        let sample = Sample {
            sequence,
            time: 0,
            payload: self.payloads.next(sequence),
        };
        // A sample that was not taken is missed by the other process.
        self.sender.push_within(sample, PATIENCE).unwrap();
    }

    fn receive(&mut self, sequence: u64) -> bool {
        match self.receiver.take(Duration::MAX) {
            Ok(Some(sample)) => {
                let size = sample.payload.len();
                assert_eq!(sum(&sample.payload), expected(size, sequence));
                true
            }
            Ok(None) | Err(_) => false,
        }
    }
}

impl Drop for Transported {
    fn drop(&mut self) {
        self.sender.close(Parting::GoodBye);
        self.receiver.close(Parting::GoodBye);
    }
}
