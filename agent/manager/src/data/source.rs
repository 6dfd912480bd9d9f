//! One connection of a connector to an in-port, as its reader sees it.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use rts_manager_api::control::Latency;
use rts_schemas::connector::{ConnectorSettings, Dataflow};
use rts_transport::{Handle, Question};

use super::Parting;
use super::latency::Latencies;
use super::outbox::Outbox;
use super::sample::{Sample, now};
use crate::sync::lock;

/// A connection. Its writer numbers samples from 1; its counters begin with it.
#[derive(Debug)]
pub struct Source {
    /// The transport that it comes by, until it is closed; a dead source must hold no file descriptor.
    transport: Mutex<Option<Handle>>,
    direct: bool,
    settings: ConnectorSettings,
    /// The other end, when it is in this process and a reader fetches from it.
    outbox: Option<Arc<Outbox>>,
    /// One of the three below.
    state: AtomicU8,
    next: AtomicU64,
    received: AtomicU64,
    drops: AtomicU64,
    gaps: AtomicU64,
    latencies: Latencies,
}

/// How a sample is fetched from a source.
#[derive(Debug)]
pub enum Fetch {
    /// It is not: they come by themselves.
    None,
    /// From this process.
    Here(Arc<Outbox>),
    /// From the other end of a transport, which is asked for it.
    There,
}

const OPEN: u8 = 0;
/// Closed by an order.
const CLOSED: u8 = 1;
/// Closed by the loss of its other end.
const LOST: u8 = 2;

/// Counters of a source.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Counts {
    /// Samples that the component has read, each with a higher number than the one before.
    pub received: u64,
    /// Samples dropped from the queue.
    pub drops: u64,
    /// Jumps in the sequence that the reader saw.
    pub gaps: u64,
    /// From the write to the read of those that were received, where both clocks are one.
    pub latency: Option<Latency>,
}

impl Source {
    /// A new connection; without a transport, one inside this process, which is fetched from when there is an outbox.
    pub fn new(
        transport: Option<Handle>,
        settings: ConnectorSettings,
        outbox: Option<Arc<Outbox>>,
    ) -> Self {
        Self {
            direct: transport.is_none(),
            transport: Mutex::new(transport),
            settings,
            outbox,
            state: AtomicU8::new(OPEN),
            next: AtomicU64::new(1),
            received: AtomicU64::new(0),
            drops: AtomicU64::new(0),
            gaps: AtomicU64::new(0),
            latencies: Latencies::new(),
        }
    }

    /// What the connector's properties say.
    pub fn settings(&self) -> &ConnectorSettings {
        &self.settings
    }

    /// How many samples one callback may fetch, so that a loop that reads all ends.
    pub fn fetches(&self) -> usize {
        match self.settings.dataflow {
            Dataflow::Push => 0,
            Dataflow::Pull => self.settings.out_buffer.length,
        }
    }

    /// How a sample is fetched from it.
    pub fn fetch(&self) -> Fetch {
        match (self.settings.dataflow, &self.outbox) {
            (Dataflow::Push, _) => Fetch::None,
            (Dataflow::Pull, Some(outbox)) => Fetch::Here(Arc::clone(outbox)),
            (Dataflow::Pull, None) => Fetch::There,
        }
    }

    /// Asks the other end for a sample; false when it cannot be asked. Never blocks.
    pub fn ask(&self, question: Question) -> bool {
        let transport = lock(&self.transport);
        let asked = transport.as_ref().map(|transport| transport.ask(question));
        asked.is_some_and(|asked| asked)
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
        if let Some(outbox) = &self.outbox {
            outbox.close(parting);
        }
        if let Some(transport) = lock(&self.transport).take() {
            transport.close(parting);
        }
        was_open
    }

    /// Counts a sample that was read.
    pub(super) fn count_read(&self, sample: &Sample) {
        let sequence = sample.sequence;
        let expected = self
            .next
            .swap(sequence.saturating_add(1), Ordering::Relaxed);
        if sequence > expected {
            self.gaps.fetch_add(1, Ordering::Relaxed);
        }
        // One that comes twice, or late, is no sample that has arrived.
        if sequence >= expected {
            if sample.time > 0 {
                self.latencies.count(now().saturating_sub(sample.time));
            }
            self.received.fetch_add(1, Ordering::Release);
        }
    }

    /// Counts a sample that had to go for another.
    pub(super) fn count_drop(&self) {
        self.drops.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a sample that its reader was not to see: no gap for it, as its reading starts afterwards.
    pub(super) fn count_skipped(&self, sample: &Sample) {
        self.next
            .store(sample.sequence.saturating_add(1), Ordering::Relaxed);
        self.count_drop();
    }

    /// Its counters now.
    pub fn counts(&self) -> Counts {
        Counts {
            received: self.received.load(Ordering::Acquire),
            drops: self.drops.load(Ordering::Relaxed),
            gaps: self.gaps.load(Ordering::Relaxed),
            latency: self.latencies.summary(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Ended, Payload};
    use rts_transport::{Receiver, Sender, unix};
    use std::os::unix::net::UnixStream;

    #[test]
    fn only_rising_numbers_count_as_received() {
        let source = Source::new(None, ConnectorSettings::default(), None);
        for sequence in [1, 2, 2, 4] {
            source.count_read(&Sample {
                sequence,
                time: now(),
                payload: Payload::new(),
            });
        }
        let counts = source.counts();
        assert_eq!((counts.received, counts.gaps), (3, 1));
        assert_eq!(counts.latency.unwrap().count, 3);
    }

    #[test]
    fn a_source_that_died_holds_no_file_descriptor() {
        let (ours, theirs) = UnixStream::pair().unwrap();
        let mut sender = unix::sender(theirs).unwrap();
        let receiver = unix::receiver(ours).unwrap();
        let settings = ConnectorSettings::default();
        let source = Source::new(Some(receiver.handle()), settings, None);
        assert!(source.close(Parting::Loss));
        assert!(!source.close(Parting::Loss));
        assert!(matches!(sender.ended(), Some(Ended::Lost(_))));
        assert!(lock(&source.transport).is_none());
        assert!(!source.is_direct());
        assert!(source.is_lost());
    }
}
