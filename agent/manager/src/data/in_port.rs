//! An in-port: a bounded buffer for each source, and one reader, the component, that takes what arrived first.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use rts_schemas::connector::{EmptyPolicy, FullPolicy};
use rts_transport::Question;

use super::Parting;
use super::lane::Lane;
use super::monitor::{Guard, Monitor, Seen, Watched};
use super::sample::{Read, Sample, Written};
use super::source::{Fetch, Source};

/// An in-port.
#[derive(Debug)]
pub struct InPort {
    /// Bare name.
    pub name: String,
    /// IDL repository id.
    pub data_type: String,
    /// A reader waits here for a sample, and writers wait for room.
    waiting: Monitor<Waiting>,
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
    /// Samples that the running callback has read.
    reads: u64,
    /// By address of the source, which its lane keeps alive.
    lanes: BTreeMap<usize, Lane>,
    /// Arrival number of the first sample of each lane that has one.
    firsts: BTreeSet<(u64, usize)>,
    /// The lane that was read last.
    last: Option<usize>,
}

impl InPort {
    /// An in-port with nothing to read.
    pub fn new(name: &str, data_type: &str) -> Self {
        Self {
            name: name.to_owned(),
            data_type: data_type.to_owned(),
            waiting: Monitor::default(),
            arrival: OnceLock::new(),
        }
    }

    /// Has this called after each arrival, by the thread that brought the sample. Once for each port.
    pub fn on_arrival(&self, hook: impl Fn() + Send + Sync + 'static) {
        let _ = self.arrival.set(Hook(Box::new(hook)));
    }

    fn tell_arrival(&self) {
        if let Some(Hook(hook)) = self.arrival.get() {
            hook();
        }
    }

    /// Lets a source come to it.
    pub fn open(&self, source: &Arc<Source>) {
        let lane = Lane::new(source);
        self.waiting.lock().lanes.insert(key(source), lane);
    }

    /// Takes a sample of an open source in, or gives it back when there is no room for it; one of a closed source is
    /// dropped.
    pub fn offer(&self, source: &Arc<Source>, sample: Sample) -> Result<(), Sample> {
        self.put(&mut self.waiting.lock(), source, sample)?;
        self.tell_arrival();
        Ok(())
    }

    fn put(
        &self,
        waiting: &mut Watched<Waiting>,
        source: &Arc<Source>,
        sample: Sample,
    ) -> Result<(), Sample> {
        waiting.write(key(source), sample)?;
        self.waiting.notify(waiting);
        Ok(())
    }

    /// Waits for room, as long as the policy says since `began`, and while `stays` holds; the sample is gone when there
    /// is none, which the caller counts. Ends with the source.
    pub fn wait(
        &self,
        source: &Arc<Source>,
        sample: Sample,
        began: Instant,
        stays: impl Fn() -> bool,
    ) -> Written {
        /// Between two looks whether the other end is still there.
        const LOOK: Duration = Duration::from_millis(50);
        let waiting = self.waiting.lock();
        let policy = waiting.lanes.get(&key(source)).map(Lane::full_policy);
        let (timeout, refused) = match policy {
            Some(FullPolicy::Block(timeout)) => (timeout, Written::TimedOut),
            _ => (Duration::ZERO, Written::BufferFull),
        };
        let mut held = Some(sample);
        let put = |waiting: &mut Watched<Waiting>| {
            held = held
                .take()
                .and_then(|sample| self.put(waiting, source, sample).err());
            match held {
                None => Seen::Done(true),
                Some(_) if stays() => Seen::Wait(timeout),
                Some(_) => Seen::Done(false),
            }
        };
        if self.waiting.wait(waiting, began, LOOK, put).1 != Some(true) {
            return refused;
        }
        self.tell_arrival();
        Written::Taken
    }

    /// Takes a sample in, waiting for room as the policy says, and while `stays` holds. One that finds none is counted.
    pub fn take_in(&self, source: &Arc<Source>, sample: Sample, stays: impl Fn() -> bool) {
        if let Err(sample) = self.offer(source, sample)
            && self.wait(source, sample, Instant::now(), stays) != Written::Taken
        {
            source.count_drop();
        }
    }

    /// A source that was asked for a sample has none.
    pub fn answered(&self, source: &Arc<Source>) {
        let mut waiting = self.waiting.lock();
        if let Some(lane) = waiting.lanes.get_mut(&key(source)) {
            lane.asked = false;
        }
        self.waiting.notify(&waiting);
    }

    /// A callback begins: it may read what has arrived by now. So a loop that reads all ends, however fast the
    /// producers are.
    pub fn begin(&self) {
        let mut waiting = self.waiting.lock();
        waiting.horizon = waiting.arrivals;
        waiting.reads = 0;
        for lane in waiting.lanes.values_mut() {
            lane.fetches = lane.source.fetches();
        }
    }

    /// Takes the oldest sample that the running callback may see, and counts it at its source; fetches one where none
    /// has arrived. The first read of a callback goes by the policy of an empty buffer: later ones find nothing, so that
    /// a loop that reads all ends.
    pub fn read(&self) -> Read {
        let began = Instant::now();
        let mut waiting = self.waiting.lock();
        let first = waiting.reads == 0;
        waiting.reads += 1;
        if let Some(sample) = waiting.read() {
            self.waiting.notify(&waiting);
            return Read::Sample(sample.payload);
        }
        let (waiting, fetched) = self.fetch(waiting, first, began);
        if let Some(sample) = fetched {
            return Read::Sample(sample.payload);
        }
        if !first {
            return Read::Empty;
        }
        let mut has_waited = false;
        let look = |waiting: &mut Watched<Waiting>| {
            if std::mem::replace(&mut has_waited, true) {
                waiting.horizon = waiting.arrivals;
                if let Some(sample) = waiting.read() {
                    self.waiting.notify(waiting);
                    return Seen::Done(Read::Sample(sample.payload));
                }
            }
            match waiting.patience() {
                Some(patience) => Seen::Wait(patience),
                None => {
                    let again = waiting.read_back();
                    Seen::Done(again.map_or(Read::Empty, |sample| Read::Sample(sample.payload)))
                }
            }
        };
        let read = self.waiting.wait(waiting, began, Duration::MAX, look).1;
        read.unwrap_or(Read::TimedOut)
    }

    /// Fetches a sample from one of the sources that wait to be asked.
    fn fetch<'a>(
        &'a self,
        mut waiting: Guard<'a, Waiting>,
        first: bool,
        began: Instant,
    ) -> (Guard<'a, Waiting>, Option<Sample>) {
        let pulled = waiting.lanes.iter().filter(|(_, lane)| lane.fetches > 0);
        let keys: Vec<usize> = pulled.map(|(key, _)| *key).collect();
        for key in keys {
            let Some(lane) = waiting.lanes.get_mut(&key) else {
                continue;
            };
            lane.fetches -= 1;
            let source = Arc::clone(&lane.source);
            let longest = source.settings().in_buffer.read_timeout;
            match source.fetch() {
                Fetch::None => {}
                Fetch::Here(outbox) => {
                    drop(waiting);
                    let sample = outbox.fetch_here(first, longest);
                    waiting = self.waiting.lock();
                    if let Some(sample) = sample {
                        // A closed one takes nothing.
                        let _ = waiting.write(key, sample);
                    }
                }
                Fetch::There => {
                    let question = match first {
                        true => Question::First,
                        false => Question::More,
                    };
                    // Over again, one that was late is still on its way.
                    if !lane.asked && source.ask(question) {
                        lane.asked = true;
                        waiting = self.wait_for_answer(waiting, key, longest, began);
                    }
                }
            }
            waiting.horizon = waiting.arrivals;
            if let Some(sample) = waiting.read() {
                return (waiting, Some(sample));
            }
        }
        (waiting, None)
    }

    fn wait_for_answer<'a>(
        &'a self,
        waiting: Guard<'a, Waiting>,
        key: usize,
        longest: Duration,
        began: Instant,
    ) -> Guard<'a, Waiting> {
        let look = |waiting: &mut Watched<Waiting>| {
            let asked = waiting.lanes.get(&key).is_some_and(|lane| lane.asked);
            match asked {
                true => Seen::Wait(longest),
                false => Seen::Done(()),
            }
        };
        self.waiting.wait(waiting, began, Duration::MAX, look).0
    }

    /// Samples that have arrived so far.
    #[cfg(test)]
    pub fn arrivals(&self) -> u64 {
        self.waiting.lock().arrivals
    }

    /// True while a thread waits here.
    #[cfg(test)]
    pub fn has_sleepers(&self) -> bool {
        self.waiting.has_sleepers()
    }

    /// Whether the running callback may read a sample. Of a source in another process that is fetched from, nobody knows
    /// without asking: there may be one.
    pub fn is_new(&self) -> bool {
        self.waiting.lock().is_new()
    }

    /// Drops what waits: it came before the reader was there to act on it.
    pub fn clear(&self) {
        let mut waiting = self.waiting.lock();
        waiting.firsts.clear();
        waiting.lanes.values_mut().for_each(Lane::skip);
        self.waiting.notify(&waiting);
    }

    /// Closes a source and drops what waits from it. True when it was open.
    pub fn close(&self, source: &Arc<Source>, parting: Parting) -> bool {
        // Under the lock, so that nothing is pushed afterwards.
        let mut waiting = self.waiting.lock();
        let was_open = source.close(parting);
        waiting.remove(key(source));
        self.waiting.notify(&waiting);
        was_open
    }
}

/// Names a source as long as it lives.
fn key(source: &Arc<Source>) -> usize {
    Arc::as_ptr(source).addr()
}

impl Waiting {
    fn write(&mut self, key: usize, sample: Sample) -> Result<(), Sample> {
        // Without a lane it is closed.
        let Some(lane) = self.lanes.get_mut(&key) else {
            return Ok(());
        };
        lane.asked = false;
        let before = lane.first();
        lane.write(self.arrivals, sample)?;
        self.arrivals += 1;
        let after = lane.first();
        if before != after {
            self.firsts.extend(after.map(|arrival| (arrival, key)));
            if let Some(arrival) = before {
                self.firsts.remove(&(arrival, key));
            }
        }
        Ok(())
    }

    fn is_new(&self) -> bool {
        let first = self.firsts.first();
        first.is_some_and(|(arrival, _)| *arrival < self.horizon)
            || self.lanes.values().any(Lane::may_be_fetched)
    }

    fn read(&mut self) -> Option<Sample> {
        let &(arrival, key) = self.firsts.first()?;
        if arrival >= self.horizon {
            return None;
        }
        self.firsts.remove(&(arrival, key));
        let lane = self.lanes.get_mut(&key)?;
        let sample = lane.read();
        self.firsts.extend(lane.first().map(|first| (first, key)));
        self.last = Some(key);
        sample
    }

    fn read_back(&self) -> Option<Sample> {
        self.lanes.get(&self.last?)?.read_back()
    }

    /// How long a reader of nothing waits: as long as the most patient of its sources says that sends by itself.
    fn patience(&self) -> Option<Duration> {
        let pushed = self
            .lanes
            .values()
            .filter(|lane| lane.source.fetches() == 0);
        let policies = pushed.map(Lane::empty_policy);
        let times = policies.filter_map(|policy| match policy {
            EmptyPolicy::Block(time) => Some(time),
            EmptyPolicy::Readback | EmptyPolicy::DoNothing => None,
        });
        times.max()
    }

    fn remove(&mut self, key: usize) {
        let Some(mut lane) = self.lanes.remove(&key) else {
            return;
        };
        if let Some(arrival) = lane.first() {
            self.firsts.remove(&(arrival, key));
        }
        self.last = self.last.filter(|last| *last != key);
        lane.skip();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Payload;
    use rts_schemas::connector::ConnectorSettings;

    fn source(port: &InPort) -> Arc<Source> {
        let source = Arc::new(Source::new(None, ConnectorSettings::default(), None));
        port.open(&source);
        source
    }

    fn port() -> (InPort, Arc<Source>) {
        let port = InPort::new("in", "T");
        let source = source(&port);
        (port, source)
    }

    fn sample(sequence: u64) -> Sample {
        Sample {
            sequence,
            time: 0,
            payload: Payload::copy_from_slice(&sequence.to_be_bytes()),
        }
    }

    fn send(port: &InPort, source: &Arc<Source>, sequences: std::ops::RangeInclusive<u64>) {
        for sequence in sequences {
            port.offer(source, sample(sequence)).unwrap();
        }
    }

    fn read_all(port: &InPort) -> Vec<u64> {
        port.begin();
        let number = |payload: Payload| u64::from_be_bytes(payload[..].try_into().unwrap());
        std::iter::from_fn(|| port.read().sample())
            .map(number)
            .collect()
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
        let fast = source(&port);
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
        assert_eq!(port.read(), Read::Empty, "no callback has begun");
        assert!(!port.is_new());
        port.begin();
        assert!(port.is_new());
        assert!(port.read().sample().is_some());
        send(&port, &source, 3..=3);
        assert!(port.read().sample().is_some());
        assert!(!port.is_new());
        assert_eq!(port.read(), Read::Empty);
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
        let second = source(&port);
        send(&port, &first, 1..=3);
        send(&port, &second, 11..=13);
        assert!(port.close(&first, Parting::Loss));
        assert!(!port.close(&first, Parting::Loss));
        send(&port, &first, 4..=4);
        assert_eq!(read_all(&port), [11, 12, 13]);
        assert_eq!((first.counts().received, first.counts().drops), (0, 3));
        assert_eq!(second.counts().drops, 0);
    }
}
