//! What every transport gives: the two ends of a connection.

use std::fmt;
use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::time::Duration;

use crate::{Ended, Parting, Refused, Sample};

/// The end that samples are pushed into. Dropped without a close, it is lost to the other end.
pub trait Sender: Send + fmt::Debug {
    /// Hands a sample over. Never waits.
    fn push(&mut self, sample: Sample) -> Result<(), Refused>;

    /// Hands a sample over, and waits that long for room.
    fn push_within(&mut self, sample: Sample, patience: Duration) -> Result<(), Refused>;

    /// Why the connection has ended, if it has. Looks, and never waits.
    fn ended(&mut self) -> Option<Ended>;

    /// Becomes readable when [`Self::ended`] is worth a look; for one thread that watches many connections. None
    /// inside a process, where the other end cannot die alone.
    fn watched(&self) -> Option<BorrowedFd<'_>>;

    /// Ends the connection from any thread.
    fn closer(&self) -> Closer;

    /// Ends the connection.
    fn close(&mut self, parting: Parting) {
        self.closer().close(parting);
    }
}

/// The end that samples come out of. Dropped without a close, it is lost to the other end.
pub trait Receiver: Send + fmt::Debug {
    /// The next sample, if it is there. Never waits.
    fn try_take(&mut self) -> Result<Option<Sample>, Ended>;

    /// The next sample, waiting that long for it; [`Duration::MAX`] is for ever.
    fn take(&mut self, patience: Duration) -> Result<Option<Sample>, Ended>;

    /// Ends the connection from any thread.
    fn closer(&self) -> Closer;

    /// Ends the connection.
    fn close(&mut self, parting: Parting) {
        self.closer().close(parting);
    }

    /// Hands all samples on until the connection ends, or `sink` wants no more. For a thread of its own.
    fn hand_on(&mut self, sink: &mut dyn FnMut(Sample) -> bool) -> Ended {
        loop {
            match self.take(Duration::MAX) {
                Ok(Some(sample)) => {
                    if !sink(sample) {
                        return Ended::Here;
                    }
                }
                Ok(None) => {}
                Err(ended) => return ended,
            }
        }
    }
}

/// Ends a connection at one of its ends. The first close counts; none waits.
#[derive(Clone)]
pub struct Closer(Arc<dyn Close>);

impl Closer {
    pub(crate) fn new(end: Arc<dyn Close>) -> Self {
        Self(end)
    }

    /// Ends it: who waits at this end is woken, and the other end is told, or left to find out.
    pub fn close(&self, parting: Parting) {
        self.0.close(parting);
    }
}

impl fmt::Debug for Closer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Closer")
    }
}

/// What a [`Closer`] closes.
pub(crate) trait Close: Send + Sync {
    fn close(&self, parting: Parting);
}
