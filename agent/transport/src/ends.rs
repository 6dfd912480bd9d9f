//! What every transport gives: the two ends of a connection.

use std::fmt;
use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
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

    /// What the other end has asked for, if it has since this was called last. Looks, and never waits. Of several
    /// questions the last counts: who fetches waits for an answer before it asks again.
    fn asked(&mut self) -> Option<Question>;

    /// After a close with a good-bye: waits until that has left, and what was pushed before, which takes half a second
    /// at most.
    fn linger(&mut self);

    /// What other threads may do.
    fn handle(&self) -> Handle;

    /// Ends the connection.
    fn close(&mut self, parting: Parting) {
        self.handle().close(parting);
    }
}

/// The end that samples come out of. Dropped without a close, it is lost to the other end.
pub trait Receiver: Send + fmt::Debug {
    /// The next sample, if it is there. Never waits.
    fn try_take(&mut self) -> Result<Option<Sample>, Ended>;

    /// The next sample, waiting that long for it; [`Duration::MAX`] is for ever.
    fn take(&mut self, patience: Duration) -> Result<Option<Sample>, Ended>;

    /// What other threads may do.
    fn handle(&self) -> Handle;

    /// Ends the connection.
    fn close(&mut self, parting: Parting) {
        self.handle().close(parting);
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

/// What a reader that fetches asks its sender for. The answer is a sample, by a rule that both ends have agreed on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// A sample, which may be waited for.
    First,
    /// A sample, if there is one.
    More,
}

/// An end of a connection, for any thread. Nothing here waits.
#[derive(Clone)]
pub struct Handle(Arc<dyn End>);

impl Handle {
    pub(crate) fn new(end: Arc<dyn End>) -> Self {
        Self(end)
    }

    /// Ends the connection: who waits at this end is woken, and the other end is told, or left to find out. The first
    /// close counts.
    pub fn close(&self, parting: Parting) {
        self.0.close(parting);
    }

    /// Of a sending end: becomes readable when [`Sender::ended`] or [`Sender::asked`] is worth a look; for one thread
    /// that watches many connections. None inside a process, where the other end cannot die alone.
    pub fn watched(&self) -> Option<BorrowedFd<'_>> {
        self.0.watched()
    }

    /// True when the other end has closed the connection, whatever is still to be read.
    pub fn has_gone(&self) -> bool {
        self.0.has_gone()
    }

    /// Of a receiving end: asks the other end for a sample. False when it cannot be asked.
    pub fn ask(&self, question: Question) -> bool {
        self.0.ask(question)
    }
}

impl fmt::Debug for Handle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Handle")
    }
}

/// What a [`Handle`] is of.
pub(crate) trait End: Send + Sync {
    fn close(&self, parting: Parting);

    fn watched(&self) -> Option<BorrowedFd<'_>> {
        None
    }

    fn has_gone(&self) -> bool;

    fn ask(&self, _question: Question) -> bool {
        false
    }
}

/// The last question of the other end.
#[derive(Debug, Default)]
pub(crate) struct Asked(AtomicU8);

impl Asked {
    pub fn put(&self, question: Question) {
        self.0.store(question.byte(), Ordering::Release);
    }

    pub fn take(&self) -> Option<Question> {
        match self.0.load(Ordering::Relaxed) {
            0 => None,
            _ => Question::of(self.0.swap(0, Ordering::Acquire)),
        }
    }
}

impl Question {
    /// As it travels.
    pub(crate) fn byte(self) -> u8 {
        match self {
            Self::First => 1,
            Self::More => 2,
        }
    }

    pub(crate) fn of(byte: u8) -> Option<Self> {
        match byte {
            1 => Some(Self::First),
            2 => Some(Self::More),
            _ => None,
        }
    }
}
