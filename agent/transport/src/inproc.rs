//! Inside a process: a ring of samples. Payloads are shared, not copied, and no lock is taken.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::time::Duration;

use crate::ends::{Asked, End};
use crate::signal::Signal;
use crate::{Ended, Handle, MAX_SAMPLE, Parting, Question, Refused, Sample};

/// A connection that holds so many samples.
pub fn pair(capacity: NonZeroUsize) -> (Sender, Receiver) {
    let (producer, consumer) = rtrb::RingBuffer::new(capacity.get());
    let link = Arc::new(Link::default());
    let sender = Sender {
        producer,
        link: Arc::clone(&link),
    };
    (sender, Receiver { consumer, link })
}

/// What both ends share besides the ring.
#[derive(Debug, Default)]
struct Link {
    /// `OPEN`, or who closed it, and how.
    state: AtomicU8,
    filled: Signal,
    emptied: Signal,
    asked: Asked,
}

const OPEN: u8 = 0;
const SENDER: u8 = 1;
const RECEIVER: u8 = 2;
const GOOD_BYE: u8 = 4;

impl Link {
    fn close(&self, side: u8, parting: Parting) {
        let state = match parting {
            Parting::GoodBye => side | GOOD_BYE,
            Parting::Loss => side,
        };
        let (done, or) = (Ordering::AcqRel, Ordering::Acquire);
        if self.state.compare_exchange(OPEN, state, done, or).is_ok() {
            self.filled.notify();
            self.emptied.notify();
        }
    }

    fn is_open(&self) -> bool {
        self.state.load(Ordering::Acquire) == OPEN
    }

    /// What the end means to one side.
    fn ended(&self, side: u8) -> Option<Ended> {
        match self.state.load(Ordering::Acquire) {
            OPEN => None,
            state if state & side != 0 => Some(Ended::Here),
            state if state & GOOD_BYE != 0 => Some(Ended::GoodBye),
            _ => Some(Ended::lost("it was dropped without a good-bye")),
        }
    }
}

struct Side(Arc<Link>, u8);

impl End for Side {
    fn close(&self, parting: Parting) {
        self.0.close(self.1, parting);
    }

    fn has_gone(&self) -> bool {
        !self.0.is_open()
    }

    fn ask(&self, question: Question) -> bool {
        let asks = self.1 == RECEIVER && self.0.is_open();
        if asks {
            self.0.asked.put(question);
        }
        asks
    }
}

/// The sending end.
#[derive(Debug)]
pub struct Sender {
    producer: rtrb::Producer<Sample>,
    link: Arc<Link>,
}

impl crate::Sender for Sender {
    fn push(&mut self, sample: Sample) -> Result<(), Refused> {
        if !self.link.is_open()
            && let Some(ended) = self.link.ended(SENDER)
        {
            return Err(Refused::Ended(ended));
        }
        if sample.payload.len() > MAX_SAMPLE {
            return Err(Refused::TooLarge(sample.payload.len()));
        }
        match self.producer.push(sample) {
            Ok(()) => {
                self.link.filled.notify();
                Ok(())
            }
            Err(rtrb::PushError::Full(sample)) => Err(Refused::Full(sample)),
        }
    }

    fn push_within(&mut self, sample: Sample, patience: Duration) -> Result<(), Refused> {
        let sample = match self.push(sample) {
            Err(Refused::Full(sample)) => sample,
            done => return done,
        };
        let Self { producer, link } = self;
        let room = || !producer.is_full() || !link.is_open();
        link.emptied.wait(patience, room);
        self.push(sample)
    }

    fn ended(&mut self) -> Option<Ended> {
        self.link.ended(SENDER)
    }

    fn asked(&mut self) -> Option<Question> {
        self.link.asked.take()
    }

    fn linger(&mut self) {}

    fn handle(&self) -> Handle {
        Handle::new(Arc::new(Side(Arc::clone(&self.link), SENDER)))
    }
}

impl Drop for Sender {
    fn drop(&mut self) {
        self.link.close(SENDER, Parting::Loss);
    }
}

/// The receiving end.
#[derive(Debug)]
pub struct Receiver {
    consumer: rtrb::Consumer<Sample>,
    link: Arc<Link>,
}

impl Receiver {
    fn pop(&mut self) -> Option<Sample> {
        let sample = self.consumer.pop().ok()?;
        self.link.emptied.notify();
        Some(sample)
    }
}

impl crate::Receiver for Receiver {
    fn try_take(&mut self) -> Result<Option<Sample>, Ended> {
        // Before the ring: what was pushed before the close is there once the close is seen.
        let ended = match self.link.is_open() {
            true => None,
            false => self.link.ended(RECEIVER),
        };
        match ended {
            Some(Ended::Here) => Err(Ended::Here),
            Some(ended) => self.pop().map(Some).ok_or(ended),
            None => Ok(self.pop()),
        }
    }

    fn take(&mut self, patience: Duration) -> Result<Option<Sample>, Ended> {
        if let Some(sample) = self.try_take()? {
            return Ok(Some(sample));
        }
        let Self { consumer, link } = self;
        let filled = || !consumer.is_empty() || !link.is_open();
        link.filled.wait(patience, filled);
        self.try_take()
    }

    fn handle(&self) -> Handle {
        Handle::new(Arc::new(Side(Arc::clone(&self.link), RECEIVER)))
    }
}

impl Drop for Receiver {
    fn drop(&mut self) {
        self.link.close(RECEIVER, Parting::Loss);
    }
}
