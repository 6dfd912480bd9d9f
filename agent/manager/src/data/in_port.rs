//! An in-port: one bounded queue that several sources fill and the component reads.

use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use super::queue::Queue;
use super::{Payload, QUEUE_BYTES, QUEUE_LENGTH};
use crate::sync::lock;

/// An in-port.
#[derive(Debug)]
pub struct InPort {
    /// Bare name.
    pub name: String,
    /// IDL repository id.
    pub data_type: String,
    queue: Mutex<Queue<Sample>>,
}

#[derive(Debug)]
struct Sample {
    source: Arc<Source>,
    sequence: u64,
    payload: Payload,
}

/// One connection of a connector to an in-port. Its writer numbers samples from 1; its counters begin with it.
#[derive(Debug)]
pub struct Source {
    /// The socket it comes from; none inside a process.
    stream: Option<UnixStream>,
    open: AtomicBool,
    next: AtomicU64,
    received: AtomicU64,
    drops: AtomicU64,
    gaps: AtomicU64,
}

/// Counters of a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Samples that the component has read.
    pub received: u64,
    /// Samples dropped from the queue.
    pub drops: u64,
    /// Jumps in the sequence that the reader saw.
    pub gaps: u64,
}

impl Source {
    /// A new connection.
    pub fn new(stream: Option<UnixStream>) -> Self {
        Self {
            stream,
            open: AtomicBool::new(true),
            next: AtomicU64::new(1),
            received: AtomicU64::new(0),
            drops: AtomicU64::new(0),
            gaps: AtomicU64::new(0),
        }
    }

    /// False once it was closed.
    pub fn is_open(&self) -> bool {
        self.open.load(Ordering::Acquire)
    }

    /// True when both ends are in this process.
    pub fn is_direct(&self) -> bool {
        self.stream.is_none()
    }

    /// Closes it; true when it was open.
    pub fn close(&self) -> bool {
        let was_open = self.open.swap(false, Ordering::AcqRel);
        if let (true, Some(stream)) = (was_open, &self.stream) {
            let _ = stream.shutdown(Shutdown::Both);
        }
        was_open
    }

    /// Its counters now.
    pub fn counts(&self) -> Counts {
        Counts {
            received: self.received.load(Ordering::Acquire),
            drops: self.drops.load(Ordering::Relaxed),
            gaps: self.gaps.load(Ordering::Relaxed),
        }
    }
}

impl InPort {
    /// An in-port with an empty queue.
    pub fn new(name: &str, data_type: &str) -> Self {
        Self {
            name: name.to_owned(),
            data_type: data_type.to_owned(),
            queue: Mutex::new(Queue::new(QUEUE_LENGTH, QUEUE_BYTES)),
        }
    }

    /// Appends a sample of an open source. `queued` runs before a reader can see the sample. False when the source
    /// is closed.
    pub fn push(
        &self,
        source: &Arc<Source>,
        sequence: u64,
        payload: Payload,
        queued: impl FnOnce(),
    ) -> bool {
        let size = payload.len();
        let sample = Sample {
            source: Arc::clone(source),
            sequence,
            payload,
        };
        let mut queue = lock(&self.queue);
        if !source.is_open() {
            return false;
        }
        queue.push(sample, size, |oldest| {
            oldest.source.drops.fetch_add(1, Ordering::Relaxed);
        });
        queued();
        true
    }

    /// Takes the oldest sample and counts it at its source.
    pub fn read(&self) -> Option<Payload> {
        let sample = lock(&self.queue).pop()?;
        let source = &sample.source;
        let expected = source
            .next
            .swap(sample.sequence.saturating_add(1), Ordering::Relaxed);
        if sample.sequence > expected {
            source.gaps.fetch_add(1, Ordering::Relaxed);
        }
        source.received.fetch_add(1, Ordering::Release);
        Some(sample.payload)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port() -> (InPort, Arc<Source>) {
        (InPort::new("in", "T"), Arc::new(Source::new(None)))
    }

    fn read_all(port: &InPort) -> usize {
        std::iter::from_fn(|| port.read()).count()
    }

    #[test]
    fn an_overflow_drops_the_oldest_and_is_seen_as_one_gap() {
        let (port, source) = port();
        for sequence in 1..=70 {
            assert!(port.push(&source, sequence, Payload::from_static(b"x"), || ()));
        }
        assert_eq!(read_all(&port), QUEUE_LENGTH);
        let counts = source.counts();
        assert_eq!((counts.received, counts.drops, counts.gaps), (64, 6, 1));
    }

    #[test]
    fn sources_are_counted_apart_and_a_new_one_starts_without_a_gap() {
        let (port, first) = port();
        let second = Arc::new(Source::new(None));
        for sequence in 1..=3 {
            port.push(&first, sequence, Payload::new(), || ());
            port.push(&second, sequence, Payload::new(), || ());
        }
        first.close();
        let again = Arc::new(Source::new(None));
        port.push(&again, 1, Payload::new(), || ());
        assert_eq!(read_all(&port), 7);
        assert_eq!(first.counts().received, 3);
        assert_eq!(second.counts().received, 3);
        assert_eq!((again.counts().received, again.counts().gaps), (1, 0));
    }

    #[test]
    fn a_closed_source_cannot_push() {
        let (port, source) = port();
        assert!(source.close());
        assert!(!source.close());
        assert!(!port.push(&source, 1, Payload::new(), || panic!("must not be counted")));
        assert!(port.read().is_none());
    }
}
