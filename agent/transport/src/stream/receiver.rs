//! The receiving end of frames.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::{Read, Source};
use crate::ends::End;
use crate::frame::{Decoder, Framing, Message};
use crate::socket::GOOD_BYE;
use crate::{Ended, Handle, Parting, Question, Receiver, Sample};

/// Receives samples as frames.
#[derive(Debug)]
pub struct StreamReceiver<S: Source> {
    shared: Arc<Shared<S>>,
    decoder: Decoder,
    ended: Option<Ended>,
}

#[derive(Debug)]
struct Shared<S> {
    source: S,
    closed: AtomicBool,
}

impl<S: Source> StreamReceiver<S> {
    /// Over a source whose other end has agreed.
    pub fn new(source: S, framing: Framing) -> Self {
        Self {
            shared: Arc::new(Shared {
                source,
                closed: AtomicBool::new(false),
            }),
            decoder: Decoder::new(framing),
            ended: None,
        }
    }

    fn next(&mut self, patience: Option<Duration>) -> Result<Option<Sample>, Ended> {
        if let Some(ended) = &self.ended {
            return Err(ended.clone());
        }
        let outcome = self.read(patience);
        if let Err(ended) = &outcome {
            self.ended = Some(ended.clone());
            self.shared.source.shut();
        }
        outcome
    }

    fn read(&mut self, patience: Option<Duration>) -> Result<Option<Sample>, Ended> {
        // A sample that is here already needs no clock.
        let mut begun = None;
        loop {
            // A close of this side wins over all that is still there.
            if self.shared.closed.load(Ordering::Acquire) {
                return Err(Ended::Here);
            }
            match self.decoder.message().map_err(Ended::lost)? {
                Some(Message::Sample(sample)) => return Ok(Some(sample)),
                Some(Message::GoodBye) => return Err(Ended::GoodBye),
                None => {}
            }
            // One that comes in parts is waited for no longer than one that does not come.
            let left = patience.map(|patience| {
                let begun = begun.get_or_insert_with(Instant::now);
                patience.saturating_sub(begun.elapsed())
            });
            let (space, limit) = self.decoder.space();
            match self.shared.source.read(space, limit, left) {
                Ok(Read::Some) => {}
                Ok(Read::Nothing) if left.is_none_or(|left| left.is_zero()) => return Ok(None),
                Ok(Read::Nothing) => {}
                Ok(Read::End) => return Err(self.judge_end()),
                Err(error) => return Err(self.judge(Ended::lost(error))),
            }
        }
    }

    fn judge_end(&self) -> Ended {
        self.judge(Ended::lost(if self.decoder.is_within() {
            "it closed the connection within a sample"
        } else {
            "it closed the connection without a good-bye"
        }))
    }

    fn judge(&self, ended: Ended) -> Ended {
        if self.shared.closed.load(Ordering::Acquire) {
            Ended::Here
        } else {
            ended
        }
    }
}

impl<S: Source> Receiver for StreamReceiver<S> {
    fn try_take(&mut self) -> Result<Option<Sample>, Ended> {
        self.next(None)
    }

    fn take(&mut self, patience: Duration) -> Result<Option<Sample>, Ended> {
        self.next(Some(patience))
    }

    fn handle(&self) -> Handle {
        Handle::new(Arc::clone(&self.shared) as Arc<dyn End>)
    }
}

impl<S: Source> End for Shared<S> {
    fn close(&self, parting: Parting) {
        if self.closed.swap(true, Ordering::AcqRel) {
            return;
        }
        if parting == Parting::GoodBye {
            self.source.say(GOOD_BYE);
        }
        self.source.shut();
    }

    fn has_gone(&self) -> bool {
        self.source.has_gone()
    }

    fn ask(&self, question: Question) -> bool {
        !self.closed.load(Ordering::Acquire) && self.source.say(question.byte())
    }
}

impl<S: Source> Drop for StreamReceiver<S> {
    fn drop(&mut self) {
        self.shared.close(Parting::Loss);
    }
}
