//! One connection of a connector to an in-port, as its reader sees it.

use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

use rustix::net::SendFlags;

use super::Parting;
use crate::sync::lock;

/// A connection. Its writer numbers samples from 1; its counters begin with it.
#[derive(Debug)]
pub struct Source {
    /// The socket that it comes from, until it is closed; a dead source must hold no file descriptor.
    stream: Mutex<Option<UnixStream>>,
    direct: bool,
    /// One of the three below.
    state: AtomicU8,
    next: AtomicU64,
    received: AtomicU64,
    drops: AtomicU64,
    gaps: AtomicU64,
}

const OPEN: u8 = 0;
/// Closed by an order.
const CLOSED: u8 = 1;
/// Closed by the loss of its other end.
const LOST: u8 = 2;

/// Counters of a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Samples that the component has read, each with a higher number than the one before.
    pub received: u64,
    /// Samples dropped from the queue.
    pub drops: u64,
    /// Jumps in the sequence that the reader saw.
    pub gaps: u64,
}

impl Source {
    /// A new connection; without a stream, one inside this process.
    pub fn new(stream: Option<UnixStream>) -> Self {
        Self {
            direct: stream.is_none(),
            stream: Mutex::new(stream),
            state: AtomicU8::new(OPEN),
            next: AtomicU64::new(1),
            received: AtomicU64::new(0),
            drops: AtomicU64::new(0),
            gaps: AtomicU64::new(0),
        }
    }

    /// False once it was closed.
    pub fn is_open(&self) -> bool {
        self.state.load(Ordering::Acquire) == OPEN
    }

    /// True once it was lost, and not closed by an order.
    pub fn is_lost(&self) -> bool {
        self.state.load(Ordering::Acquire) == LOST
    }

    /// True when both ends are in this process.
    pub fn is_direct(&self) -> bool {
        self.direct
    }

    /// Closes it; true when it was open. The first reason stays. For the in-port, which then lets its samples go.
    pub(super) fn close(&self, parting: Parting) -> bool {
        // First: the other end answers a good-bye by closing, which must not look like a loss here.
        let state = match parting {
            Parting::GoodBye => CLOSED,
            Parting::Loss => LOST,
        };
        let (done, or) = (Ordering::AcqRel, Ordering::Acquire);
        let was_open = self.state.compare_exchange(OPEN, state, done, or).is_ok();
        if let Some(stream) = lock(&self.stream).take() {
            if parting == Parting::GoodBye {
                // Nothing else is ever sent there, so there is room.
                let flags = SendFlags::DONTWAIT | SendFlags::NOSIGNAL;
                let _ = rustix::net::send(&stream, &[0], flags);
            }
            let _ = stream.shutdown(Shutdown::Both);
        }
        was_open
    }

    /// Counts a sample that was read.
    pub(super) fn count_read(&self, sequence: u64) {
        let expected = self
            .next
            .swap(sequence.saturating_add(1), Ordering::Relaxed);
        if sequence > expected {
            self.gaps.fetch_add(1, Ordering::Relaxed);
        }
        // One that comes twice, or late, is no sample that has arrived.
        if sequence >= expected {
            self.received.fetch_add(1, Ordering::Release);
        }
    }

    /// Counts a sample that had to go for another.
    pub(super) fn count_drop(&self) {
        self.drops.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a sample that its reader was not to see: no gap for it, as its reading starts afterwards.
    pub(super) fn count_skipped(&self, sequence: u64) {
        self.next
            .store(sequence.saturating_add(1), Ordering::Relaxed);
        self.count_drop();
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn only_rising_numbers_count_as_received() {
        let source = Source::new(None);
        for sequence in [1, 2, 2, 4] {
            source.count_read(sequence);
        }
        assert_eq!((source.counts().received, source.counts().gaps), (3, 1));
    }

    #[test]
    fn a_source_that_died_holds_no_file_descriptor() {
        let (ours, mut theirs) = UnixStream::pair().unwrap();
        let source = Source::new(Some(ours));
        assert!(source.close(Parting::Loss));
        assert!(!source.close(Parting::Loss));
        assert_eq!(theirs.read(&mut [0]).unwrap(), 0);
        assert!(lock(&source.stream).is_none());
        assert!(!source.is_direct());
        assert!(source.is_lost());
    }
}
