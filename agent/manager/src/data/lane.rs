//! What waits at an in-port from one source.

use std::sync::Arc;

use rts_schemas::connector::{EmptyPolicy, FullPolicy};

use super::QUEUE_BYTES;
use super::budget;
use super::buffer::Buffer;
use super::sample::Sample;
use super::source::{Fetch, Source};

/// A source and its buffer.
#[derive(Debug)]
pub struct Lane {
    /// Where it comes from.
    pub source: Arc<Source>,
    buffer: Buffer<Arrived>,
    /// A sample was asked for over a socket, and no answer came yet.
    pub asked: bool,
    /// Samples that may still be fetched in the running callback.
    pub fetches: usize,
}

#[derive(Debug, Clone)]
struct Arrived {
    arrival: u64,
    sample: Sample,
}

impl Lane {
    /// With nothing waiting.
    pub fn new(source: &Arc<Source>) -> Self {
        let settings = source.settings().in_buffer;
        Self {
            source: Arc::clone(source),
            buffer: Buffer::new(settings, QUEUE_BYTES, &budget::PROCESS),
            asked: false,
            fetches: 0,
        }
    }

    /// Number of the first arrival that waits.
    pub fn first(&self) -> Option<u64> {
        self.buffer.first().map(|arrived| arrived.arrival)
    }

    /// Takes a sample in, or gives it back when there is no room.
    pub fn write(&mut self, arrival: u64, sample: Sample) -> Result<(), Sample> {
        let size = sample.payload.len();
        let source = &self.source;
        self.buffer
            .write(Arrived { arrival, sample }, size, |_| source.count_drop())
            .map_err(|arrived| arrived.sample)
    }

    /// Reads the oldest sample, and counts it.
    pub fn read(&mut self) -> Option<Sample> {
        let arrived = self.buffer.read()?;
        self.source.count_read(&arrived.sample);
        Some(arrived.sample)
    }

    /// The sample that was read last, if an empty one gives that again. No reading.
    pub fn read_back(&self) -> Option<Sample> {
        self.buffer.read_back().map(|arrived| arrived.sample)
    }

    /// Whether the running callback may fetch a sample.
    pub fn may_be_fetched(&self) -> bool {
        let there_is = match self.source.fetch() {
            Fetch::None => false,
            Fetch::Here(outbox) => !outbox.is_empty(),
            Fetch::There => true,
        };
        there_is && self.fetches > 0
    }

    /// Drops what waits, unseen by the reader.
    pub fn skip(&mut self) {
        while let Some(arrived) = self.buffer.take() {
            self.source.count_skipped(&arrived.sample);
        }
    }

    /// The policy of an empty one.
    pub fn empty_policy(&self) -> EmptyPolicy {
        self.buffer.settings().empty
    }

    /// The policy of a full one.
    pub fn full_policy(&self) -> FullPolicy {
        self.buffer.settings().full
    }
}
