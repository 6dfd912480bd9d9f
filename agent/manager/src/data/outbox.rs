//! What waits at the out-port end of a connector, and which of it is sent when.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::time::{Duration, Instant};

use rts_schemas::connector::{
    ConnectorSettings, Dataflow, EmptyPolicy, FullPolicy, PushPolicy, Subscription,
};
use rustix::event::{EventfdFlags, eventfd};

use super::budget;
use super::buffer::Buffer;
use super::monitor::{Monitor, Seen, Watched};
use super::sample::{Sample, Written};
use super::{Parting, QUEUE_BYTES};

/// A buffer, who waits for it, and the rules by which it is emptied.
#[derive(Debug)]
pub struct Outbox {
    /// A writer waits here for room, and a reader in this process for a sample.
    waiting: Monitor<Waiting>,
    /// For the thread that sends.
    filled: OwnedFd,
    policy: PushPolicy,
    period: Option<Duration>,
}

#[derive(Debug)]
struct Waiting {
    buffer: Buffer<Sample>,
    closed: Option<Parting>,
    /// Samples that may leave before the next tick.
    allowance: usize,
    /// Samples passed over since the last one that was sent, of those that `skip` counts.
    skipped: u32,
    /// Samples passed over by choice; they leave no gap.
    passed_over: u64,
}

impl Outbox {
    /// For a connector with these settings.
    pub fn new(settings: &ConnectorSettings) -> io::Result<Self> {
        let (policy, period) = match (settings.dataflow, settings.subscription) {
            (Dataflow::Pull, _) | (_, Subscription::Flush) => (PushPolicy::All, None),
            (Dataflow::Push, Subscription::New(policy)) => (policy, None),
            (Dataflow::Push, Subscription::Periodic { period, policy }) => (policy, Some(period)),
        };
        Ok(Self {
            waiting: Monitor::new(Waiting {
                buffer: Buffer::new(settings.out_buffer, QUEUE_BYTES, &budget::PROCESS),
                closed: None,
                allowance: if period.is_some() { 0 } else { usize::MAX },
                skipped: 0,
                passed_over: 0,
            }),
            filled: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
            policy,
            period,
        })
    }

    /// Time between two ticks, when only they let samples leave.
    pub fn period(&self) -> Option<Duration> {
        self.period
    }

    /// True when nothing waits.
    pub fn is_empty(&self) -> bool {
        self.waiting.lock().buffer.is_empty()
    }

    /// Takes a sample in, or gives it back when there is no room for it; says how many older ones went for it.
    pub fn offer(&self, sample: Sample) -> (Result<(), Sample>, u64) {
        let mut waiting = self.waiting.lock();
        self.put(&mut waiting, sample)
    }

    fn put(&self, waiting: &mut Watched<Waiting>, sample: Sample) -> (Result<(), Sample>, u64) {
        let mut drops = 0;
        if waiting.closed.is_some() {
            return (Ok(()), 0);
        }
        let was_empty = waiting.buffer.is_empty();
        let size = sample.payload.len();
        let put = waiting.buffer.write(sample, size, |_| drops += 1);
        if put.is_ok() {
            // At a tick the thread looks by itself.
            if was_empty && self.period.is_none() {
                self.wake();
            }
            self.waiting.notify(waiting);
        }
        (put, drops)
    }

    /// Waits for room, as long as the policy says since `began`. Ends with the connector.
    pub fn wait(&self, sample: Sample, began: Instant) -> Written {
        let waiting = self.waiting.lock();
        let FullPolicy::Block(timeout) = waiting.buffer.settings().full else {
            return Written::BufferFull;
        };
        let mut held = Some(sample);
        let put = |waiting: &mut Watched<Waiting>| {
            held = held
                .take()
                .and_then(|sample| self.put(waiting, sample).0.err());
            match held {
                None => Seen::Done(()),
                Some(_) => Seen::Wait(timeout),
            }
        };
        let taken = self.waiting.wait(waiting, began, Duration::MAX, put).1;
        taken.map_or(Written::TimedOut, |()| Written::Taken)
    }

    /// A tick of a periodic one: what waits now, or one of it, may leave.
    pub fn tick(&self) {
        let mut waiting = self.waiting.lock();
        waiting.allowance = match self.policy {
            PushPolicy::All | PushPolicy::Skip(_) => waiting.buffer.len(),
            PushPolicy::Fifo | PushPolicy::New => 1,
        };
    }

    /// The next sample to send, by the policy. What is passed over is no gap to the reader.
    pub fn next(&self) -> Option<Sample> {
        let mut waiting = self.waiting.lock();
        let mut sample = None;
        while waiting.allowance > 0 && sample.is_none() {
            let Some(first) = waiting.buffer.take() else {
                break;
            };
            if self.period.is_some() {
                waiting.allowance -= 1;
            }
            sample = self.choose(&mut waiting, first);
        }
        self.waiting.notify(&waiting);
        sample
    }

    fn choose(&self, waiting: &mut Waiting, first: Sample) -> Option<Sample> {
        let mut sample = first;
        match self.policy {
            PushPolicy::All | PushPolicy::Fifo => {}
            PushPolicy::Skip(count) if waiting.skipped < count => {
                waiting.skipped += 1;
                waiting.passed_over += 1;
                return None;
            }
            PushPolicy::Skip(_) => waiting.skipped = 0,
            PushPolicy::New => {
                while let Some(newer) = waiting.buffer.take() {
                    waiting.passed_over += 1;
                    sample = newer;
                }
            }
        }
        sample.sequence -= waiting.passed_over;
        Some(sample)
    }

    /// For a reader that fetches. The first read of a callback goes by the policy of an empty buffer, but does not wait
    /// here: the answer says for how long it may.
    pub fn fetch(&self, first: bool) -> Fetched {
        let mut waiting = self.waiting.lock();
        self.fetch_from(&mut waiting, first)
    }

    fn fetch_from(&self, waiting: &mut Watched<Waiting>, first: bool) -> Fetched {
        if let Some(sample) = waiting.buffer.read() {
            self.waiting.notify(waiting);
            return Fetched::Sample(sample);
        }
        match waiting.buffer.settings().empty {
            EmptyPolicy::Readback if first => waiting
                .buffer
                .read_back()
                .map_or(Fetched::Nothing, Fetched::Sample),
            EmptyPolicy::Block(time) if first && waiting.closed.is_none() => Fetched::Wait(time),
            _ => Fetched::Nothing,
        }
    }

    /// The same for a reader in this process; waits for a sample when the policy says so, at most so long.
    pub fn fetch_here(&self, first: bool, longest: Duration) -> Option<Sample> {
        let look = |waiting: &mut Watched<Waiting>| match self.fetch_from(waiting, first) {
            Fetched::Sample(sample) => Seen::Done(Some(sample)),
            Fetched::Nothing => Seen::Done(None),
            Fetched::Wait(time) => Seen::Wait(time.min(longest)),
        };
        let (waiting, began) = (self.waiting.lock(), Instant::now());
        let fetched = self.waiting.wait(waiting, began, Duration::MAX, look).1;
        fetched.flatten()
    }

    /// True while a thread waits here.
    #[cfg(test)]
    pub fn has_sleepers(&self) -> bool {
        self.waiting.has_sleepers()
    }

    /// Ends it: who waits is let go, and nothing is taken in any more. The first reason stays.
    pub fn close(&self, parting: Parting) {
        let mut waiting = self.waiting.lock();
        waiting.closed.get_or_insert(parting);
        self.waiting.notify(&waiting);
        drop(waiting);
        self.wake();
    }

    /// How it was ended, if it was.
    pub fn closed(&self) -> Option<Parting> {
        self.waiting.lock().closed
    }

    /// Readable when there is something to do; for the thread that sends.
    pub fn filled(&self) -> BorrowedFd<'_> {
        self.filled.as_fd()
    }

    /// Takes the wake-ups of until now.
    pub fn awake(&self) {
        let mut count = [0; 8];
        let _ = rustix::io::read(&self.filled, &mut count);
    }

    /// Wakes the thread that sends.
    pub fn wake(&self) {
        // Fails only when it is signalled already.
        let _ = rustix::io::write(&self.filled, &1_u64.to_ne_bytes());
    }
}

/// What a fetch got.
#[derive(Debug, PartialEq, Eq)]
pub enum Fetched {
    /// A sample.
    Sample(Sample),
    /// Nothing yet: the reader may wait so long.
    Wait(Duration),
    /// Nothing.
    Nothing,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outbox(properties: &[(&str, &str)]) -> Outbox {
        let own = |(name, value): &(&str, &str)| (format!("dataport.{name}"), (*value).to_owned());
        let properties = properties.iter().map(own).collect();
        Outbox::new(&rts_schemas::connector::read(&properties).unwrap()).unwrap()
    }

    fn fill(outbox: &Outbox, numbers: std::ops::RangeInclusive<u64>) {
        for number in numbers {
            let payload = number.to_be_bytes().to_vec().into();
            let (taken, drops) = outbox.offer(Sample {
                sequence: number,
                time: 0,
                payload,
            });
            assert_eq!((taken, drops), (Ok(()), 0));
        }
    }

    /// What leaves until nothing does.
    fn leaves(outbox: &Outbox) -> Vec<u64> {
        let all = std::iter::from_fn(|| outbox.next());
        let number = |sample: Sample| u64::from_be_bytes(sample.payload[..].try_into().unwrap());
        all.map(number).collect()
    }

    #[test]
    fn each_policy_sends_its_samples_at_each_tick_and_none_between() {
        for (policy, ticks) in [
            ("all", [&[1, 2, 3, 4, 5, 6, 7][..], &[8, 9], &[]]),
            ("fifo", [&[1], &[2], &[3]]),
            ("skip", [&[3, 6], &[9], &[]]),
            ("new", [&[7], &[9], &[]]),
        ] {
            let outbox = outbox(&[
                ("subscription_type", "periodic"),
                ("publisher.push_rate", "1"),
                ("publisher.push_policy", policy),
                ("publisher.skip_count", "2"),
            ]);
            fill(&outbox, 1..=7);
            assert!(leaves(&outbox).is_empty(), "{policy}: there was no tick");
            for (tick, expected) in ticks.into_iter().enumerate() {
                outbox.tick();
                if tick == 0 {
                    assert_eq!(leaves(&outbox), expected, "{policy}");
                    fill(&outbox, 8..=9);
                    assert!(leaves(&outbox).is_empty(), "{policy}: that tick is over");
                } else {
                    assert_eq!(leaves(&outbox), expected, "{policy}, tick {tick}");
                }
            }
        }
    }

    #[test]
    fn without_a_rate_all_that_the_policy_lets_through_leaves_at_once() {
        for (policy, expected) in [
            ("all", &[1, 2, 3, 4, 5, 6, 7][..]),
            ("fifo", &[1, 2, 3, 4, 5, 6, 7]),
            ("skip", &[3, 6]),
            ("new", &[7]),
        ] {
            let outbox = outbox(&[
                ("subscription_type", "new"),
                ("publisher.push_policy", policy),
                ("publisher.skip_count", "2"),
            ]);
            fill(&outbox, 1..=7);
            assert_eq!(leaves(&outbox), expected, "{policy}");
        }
    }

    #[test]
    fn a_reader_that_finds_nothing_waits_as_long_as_the_policy_says() {
        let blocking = outbox(&[
            ("dataflow_type", "pull"),
            ("outport.buffer.read.empty_policy", "block"),
            ("outport.buffer.read.timeout", "0.03"),
        ]);
        let begin = Instant::now();
        assert_eq!(blocking.fetch_here(true, Duration::MAX), None);
        assert!(begin.elapsed() >= Duration::from_millis(30));
        let begin = Instant::now();
        assert_eq!(blocking.fetch_here(true, Duration::from_millis(1)), None);
        assert!(begin.elapsed() < Duration::from_secs(60), "not for ever");
    }

    #[test]
    fn a_writer_that_finds_no_room_waits_as_long_as_the_policy_says() {
        let full = outbox(&[
            ("subscription_type", "new"),
            ("outport.buffer.length", "1"),
            ("outport.buffer.write.full_policy", "block"),
            ("outport.buffer.write.timeout", "0.03"),
        ]);
        fill(&full, 1..=1);
        let second = Sample {
            sequence: 2,
            time: 0,
            payload: Vec::new().into(),
        };
        let begin = Instant::now();
        assert_eq!(full.wait(second, begin), Written::TimedOut);
        assert!(begin.elapsed() >= Duration::from_millis(30));
    }
}
