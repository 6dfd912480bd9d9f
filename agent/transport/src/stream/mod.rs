//! Frames over anything that carries bytes from one process to another.

mod pending;
mod receiver;
mod sender;

use std::fmt::Debug;
use std::io;
use std::os::fd::BorrowedFd;
use std::time::Duration;

use bytes::BytesMut;

pub use receiver::StreamReceiver;
pub use sender::StreamSender;

use crate::{Ended, Question};

/// No wait of an end is longer than this without a look at what else has happened.
pub(crate) const LOOK: Duration = Duration::from_millis(50);

/// Where a sender's bytes go.
pub trait Sink: Debug + Send + Sync + 'static {
    /// Takes what there is room for, of one and then the other; 0 when there is none now.
    fn write(&self, first: &[u8], then: &[u8]) -> io::Result<usize>;

    /// Waits for room, or for anything from the other end, that long.
    fn wait(&self, patience: Duration) -> io::Result<()>;

    /// What is known of the other end: none while it is there.
    fn look(&self) -> Option<Ended>;

    /// What the other end had asked for at the last look, once.
    fn asked(&self) -> Option<Question>;

    /// Ends it; the other end still gets what was written.
    fn shut(&self);

    /// Becomes readable when there is something to look at.
    fn fd(&self) -> BorrowedFd<'_>;
}

/// Where a receiver's bytes come from.
pub trait Source: Debug + Send + Sync + 'static {
    /// Appends at most `limit` bytes, for which there is room. Waits for them that long, or not at all.
    fn read(
        &self,
        into: &mut BytesMut,
        limit: usize,
        patience: Option<Duration>,
    ) -> io::Result<Read>;

    /// Says one byte to the other end; false when that cannot be done.
    fn say(&self, byte: u8) -> bool;

    /// True when the other end has closed it, whatever is still to be read.
    fn has_gone(&self) -> bool;

    /// Ends it.
    fn shut(&self);
}

/// What a read gave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Read {
    /// Some bytes.
    Some,
    /// None yet.
    Nothing,
    /// None any more.
    End,
}
