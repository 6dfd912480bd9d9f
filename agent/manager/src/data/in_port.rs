//! An in-port: a bounded queue for each source, and one reader, the component, that takes what arrived first.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock};

use super::budget::{self, Budget};
use super::queue::Queue;
use super::source::Source;
use super::{Parting, Payload, QUEUE_BYTES, QUEUE_LENGTH};
use crate::sync::lock;

/// An in-port.
#[derive(Debug)]
pub struct InPort {
    /// Bare name.
    pub name: String,
    /// IDL repository id.
    pub data_type: String,
    waiting: Mutex<Waiting>,
    arrival: OnceLock<Hook>,
}

/// What is called when a sample has arrived.
struct Hook(Box<dyn Fn() + Send + Sync>);

impl fmt::Debug for Hook {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Hook")
    }
}

/// Samples that wait to be read.
#[derive(Debug, Default)]
struct Waiting {
    /// Number of the next arrival.
    arrivals: u64,
    /// The running callback sees arrivals before this one.
    horizon: u64,
    /// By address of the source, which its lane keeps alive.
    lanes: BTreeMap<usize, Lane>,
    /// Arrival number of the first sample of each lane that has one.
    firsts: BTreeSet<(u64, usize)>,
}

#[derive(Debug)]
struct Lane {
    source: Arc<Source>,
    queue: Queue<Sample>,
}

#[derive(Debug)]
struct Sample {
    arrival: u64,
    sequence: u64,
    payload: Payload,
}

impl InPort {
    /// An in-port with nothing to read.
    pub fn new(name: &str, data_type: &str) -> Self {
        Self {
            name: name.to_owned(),
            data_type: data_type.to_owned(),
            waiting: Mutex::default(),
            arrival: OnceLock::new(),
        }
    }

    /// Has this called after each arrival, by the thread that brought the sample. Once for each port.
    pub fn on_arrival(&self, hook: impl Fn() + Send + Sync + 'static) {
        let _ = self.arrival.set(Hook(Box::new(hook)));
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
        let mut waiting = lock(&self.waiting);
        if !source.is_open() {
            return false;
        }
        waiting.push(source, sequence, payload);
        queued();
        drop(waiting);
        if let Some(Hook(hook)) = self.arrival.get() {
            hook();
        }
        true
    }

    /// A callback begins: it may read what has arrived by now. So a loop that reads all ends, however fast the
    /// producers are.
    pub fn begin(&self) {
        let mut waiting = lock(&self.waiting);
        waiting.horizon = waiting.arrivals;
    }

    /// Takes the oldest sample that the running callback may see, and counts it at its source.
    pub fn read(&self) -> Option<Payload> {
        lock(&self.waiting).read()
    }

    /// Whether the running callback may read a sample.
    pub fn is_new(&self) -> bool {
        lock(&self.waiting).is_new()
    }

    /// Drops what waits: it came before the reader was there to act on it.
    pub fn clear(&self) {
        for lane in lock(&self.waiting).take_lanes() {
            lane.skip();
        }
    }

    /// Closes a source and drops what waits from it. True when it was open.
    pub fn close(&self, source: &Arc<Source>, parting: Parting) -> bool {
        // Under the lock, so that nothing is pushed afterwards.
        let mut waiting = lock(&self.waiting);
        let was_open = source.close(parting);
        if let Some(lane) = waiting.take_lane(key(source)) {
            lane.skip();
        }
        was_open
    }
}

/// Names a source as long as it lives.
fn key(source: &Arc<Source>) -> usize {
    Arc::as_ptr(source).addr()
}

impl Waiting {
    fn push(&mut self, source: &Arc<Source>, sequence: u64, payload: Payload) {
        let key = key(source);
        let lane = self.lanes.entry(key).or_insert_with(|| Lane {
            source: Arc::clone(source),
            queue: Queue::new(QUEUE_LENGTH, QUEUE_BYTES, BUDGET),
        });
        let size = payload.len();
        let sample = Sample {
            arrival: self.arrivals,
            sequence,
            payload,
        };
        self.arrivals += 1;
        let before = lane.first();
        lane.queue.push(sample, size, |_| source.count_drop());
        let after = lane.first();
        if before != after {
            self.firsts.extend(after.map(|arrival| (arrival, key)));
            if let Some(arrival) = before {
                self.firsts.remove(&(arrival, key));
            }
        }
    }

    fn is_new(&self) -> bool {
        self.firsts
            .first()
            .is_some_and(|(arrival, _)| *arrival < self.horizon)
    }

    fn read(&mut self) -> Option<Payload> {
        let &(arrival, key) = self.firsts.first()?;
        if arrival >= self.horizon {
            return None;
        }
        self.firsts.remove(&(arrival, key));
        let lane = self.lanes.get_mut(&key)?;
        let sample = lane.queue.pop()?;
        self.firsts.extend(lane.first().map(|first| (first, key)));
        lane.source.count_read(sample.sequence);
        Some(sample.payload)
    }

    fn take_lane(&mut self, key: usize) -> Option<Lane> {
        let lane = self.lanes.remove(&key)?;
        if let Some(arrival) = lane.first() {
            self.firsts.remove(&(arrival, key));
        }
        Some(lane)
    }

    fn take_lanes(&mut self) -> impl Iterator<Item = Lane> + use<> {
        self.firsts.clear();
        std::mem::take(&mut self.lanes).into_values()
    }
}

impl Lane {
    fn first(&self) -> Option<u64> {
        self.queue.first().map(|sample| sample.arrival)
    }

    fn skip(mut self) {
        while let Some(sample) = self.queue.pop() {
            self.source.count_skipped(sample.sequence);
        }
    }
}

const BUDGET: &Budget = &budget::PROCESS;

#[cfg(test)]
mod tests {
    use super::*;

    fn port() -> (InPort, Arc<Source>) {
        (InPort::new("in", "T"), Arc::new(Source::new(None)))
    }

    fn send(port: &InPort, source: &Arc<Source>, sequences: std::ops::RangeInclusive<u64>) {
        for sequence in sequences {
            let payload = Payload::copy_from_slice(&sequence.to_be_bytes());
            assert!(port.push(source, sequence, payload, || ()));
        }
    }

    fn read_all(port: &InPort) -> Vec<u64> {
        port.begin();
        let number = |payload: Payload| u64::from_be_bytes(payload[..].try_into().unwrap());
        std::iter::from_fn(|| port.read()).map(number).collect()
    }

    #[test]
    fn an_overflow_drops_the_oldest_and_is_seen_as_one_gap() {
        let (port, source) = port();
        send(&port, &source, 1..=70);
        assert_eq!(read_all(&port), (7..=70).collect::<Vec<_>>());
        let counts = source.counts();
        assert_eq!((counts.received, counts.drops, counts.gaps), (64, 6, 1));
    }

    #[test]
    fn a_fast_source_takes_no_room_from_a_slow_one_and_the_oldest_is_read_first() {
        let (port, slow) = port();
        let fast = Arc::new(Source::new(None));
        send(&port, &slow, 1000..=1000);
        send(&port, &fast, 1..=100);
        send(&port, &slow, 1001..=1001);
        let expected: Vec<_> = [1000].into_iter().chain(37..=100).chain([1001]).collect();
        assert_eq!(read_all(&port), expected);
        assert_eq!((slow.counts().drops, fast.counts().drops), (0, 36));
    }

    #[test]
    fn what_arrives_during_a_callback_is_for_the_next_one() {
        let (port, source) = port();
        send(&port, &source, 1..=2);
        assert!(port.read().is_none(), "no callback has begun");
        assert!(!port.is_new());
        port.begin();
        assert!(port.is_new());
        assert!(port.read().is_some());
        send(&port, &source, 3..=3);
        assert!(port.read().is_some());
        assert!(!port.is_new());
        assert!(port.read().is_none());
        assert_eq!(read_all(&port), [3]);
    }

    #[test]
    fn what_waited_is_cleared_as_drops_without_a_gap() {
        let (port, source) = port();
        send(&port, &source, 1..=5);
        port.clear();
        assert!(read_all(&port).is_empty());
        send(&port, &source, 6..=7);
        assert_eq!(read_all(&port), [6, 7]);
        let counts = source.counts();
        assert_eq!((counts.received, counts.drops, counts.gaps), (2, 5, 0));
    }

    #[test]
    fn a_closed_source_takes_its_samples_with_it_and_cannot_push() {
        let (port, first) = port();
        let second = Arc::new(Source::new(None));
        send(&port, &first, 1..=3);
        send(&port, &second, 11..=13);
        assert!(port.close(&first, Parting::Loss));
        assert!(!port.close(&first, Parting::Loss));
        assert!(!port.push(&first, 4, Payload::new(), || panic!("must not be counted")));
        assert_eq!(read_all(&port), [11, 12, 13]);
        assert_eq!((first.counts().received, first.counts().drops), (0, 3));
        assert_eq!(second.counts().drops, 0);
    }
}
