//! A sample on its way, and what becomes of it: its number is from 1 with each connection, rising; a jump is a sample
//! that was lost. Its time is that of its writing, as [`now`] has it; 0 when that is not known.

pub use rts_transport::Sample;
use rustix::time::{ClockId, clock_gettime};

use super::Payload;

/// What became of a write, or of the worst of several.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Written {
    /// It is on its way, or there is nobody to send it to.
    Taken,
    /// There was no room, and it was dropped.
    BufferFull,
    /// There was no room in time, and it was dropped.
    TimedOut,
    /// The other end is lost, and not connected again yet.
    Lost,
}

/// What became of a read.
#[derive(Debug, PartialEq, Eq)]
pub enum Read {
    /// A sample.
    Sample(Payload),
    /// There is none.
    Empty,
    /// There was none in time.
    TimedOut,
}

impl Read {
    /// The sample, if there is one.
    pub fn sample(self) -> Option<Payload> {
        match self {
            Self::Sample(payload) => Some(payload),
            Self::Empty | Self::TimedOut => None,
        }
    }
}

/// Nanoseconds of the monotonic clock, which all processes of a machine share.
pub fn now() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    let seconds = u64::try_from(time.tv_sec).unwrap_or_default();
    let nanoseconds = u64::try_from(time.tv_nsec).unwrap_or_default();
    seconds.saturating_mul(1_000_000_000) + nanoseconds
}
