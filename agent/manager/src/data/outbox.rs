//! What waits at the out-port end of a connector, and which of it is sent when.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::{Condvar, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use rts_schemas::connector::{
    ConnectorSettings, Dataflow, EmptyPolicy, FullPolicy, PushPolicy, Subscription,
};
use rustix::event::{EventfdFlags, eventfd};

use super::budget;
use super::buffer::Buffer;
use super::sample::{Sample, Written};
use super::{Parting, QUEUE_BYTES};
use crate::sync::{lock, wait_until};

/// A buffer, who waits for it, and the rules by which it is emptied.
#[derive(Debug)]
pub struct Outbox {
    waiting: Mutex<Waiting>,
    /// For a writer that waits for room, and a reader in this process that waits for a sample.
    changed: Condvar,
    /// For the thread that sends.
    filled: OwnedFd,
    policy: PushPolicy,
    period: Option<Duration>,
}

#[derive(Debug)]
struct Waiting {
    buffer: Buffer<Sample>,
    closed: Option<Parting>,
    /// Who waits for `changed`.
    sleepers: usize,
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
            waiting: Mutex::new(Waiting {
                buffer: Buffer::new(settings.out_buffer, QUEUE_BYTES, &budget::PROCESS),
                closed: None,
                sleepers: 0,
                allowance: if period.is_some() { 0 } else { usize::MAX },
                skipped: 0,
                passed_over: 0,
            }),
            changed: Condvar::new(),
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
        lock(&self.waiting).buffer.is_empty()
    }

    /// Takes a sample in, or gives it back when there is no room for it; says how many older ones went for it.
    pub fn offer(&self, sample: Sample) -> (Result<(), Sample>, u64) {
        let mut waiting = lock(&self.waiting);
        self.put(&mut waiting, sample)
    }

    fn put(&self, waiting: &mut Waiting, sample: Sample) -> (Result<(), Sample>, u64) {
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
            self.notify(waiting);
        }
        (put, drops)
    }

    /// Waits for room, as long as the policy says since `began`. Ends with the connector.
    pub fn wait(&self, mut sample: Sample, began: Instant) -> Written {
        let mut waiting = lock(&self.waiting);
        let FullPolicy::Block(timeout) = waiting.buffer.settings().full else {
            return Written::BufferFull;
        };
        loop {
            match self.put(&mut waiting, sample).0 {
                Ok(()) => return Written::Taken,
                Err(back) => sample = back,
            }
            let left = timeout.saturating_sub(began.elapsed());
            if left.is_zero() {
                return Written::TimedOut;
            }
            waiting = self.sleep(waiting, left);
        }
    }

    fn sleep<'a>(
        &self,
        mut waiting: MutexGuard<'a, Waiting>,
        time: Duration,
    ) -> MutexGuard<'a, Waiting> {
        waiting.sleepers += 1;
        let mut waiting = wait_until(&self.changed, waiting, time);
        waiting.sleepers -= 1;
        waiting
    }

    fn notify(&self, waiting: &Waiting) {
        if waiting.sleepers > 0 {
            self.changed.notify_all();
        }
    }

    /// A tick of a periodic one: what waits now, or one of it, may leave.
    pub fn tick(&self) {
        let mut waiting = lock(&self.waiting);
        waiting.allowance = match self.policy {
            PushPolicy::All | PushPolicy::Skip(_) => waiting.buffer.len(),
            PushPolicy::Fifo | PushPolicy::New => 1,
        };
    }

    /// The next sample to send, by the policy. What is passed over is no gap to the reader.
    pub fn next(&self) -> Option<Sample> {
        let mut waiting = lock(&self.waiting);
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
        self.notify(&waiting);
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
        let mut waiting = lock(&self.waiting);
        self.fetch_from(&mut waiting, first)
    }

    fn fetch_from(&self, waiting: &mut Waiting, first: bool) -> Fetched {
        if let Some(sample) = waiting.buffer.read() {
            self.notify(waiting);
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
        let began = Instant::now();
        let mut waiting = lock(&self.waiting);
        loop {
            match self.fetch_from(&mut waiting, first) {
                Fetched::Sample(sample) => return Some(sample),
                Fetched::Nothing => return None,
                Fetched::Wait(time) => {
                    let left = time.min(longest).saturating_sub(began.elapsed());
                    if left.is_zero() {
                        return None;
                    }
                    waiting = self.sleep(waiting, left);
                }
            }
        }
    }

    /// True while a thread waits here.
    #[cfg(test)]
    pub fn has_sleepers(&self) -> bool {
        lock(&self.waiting).sleepers > 0
    }

    /// Ends it: who waits is let go, and nothing is taken in any more. The first reason stays.
    pub fn close(&self, parting: Parting) {
        let mut waiting = lock(&self.waiting);
        waiting.closed.get_or_insert(parting);
        self.changed.notify_all();
        drop(waiting);
        self.wake();
    }

    /// How it was ended, if it was.
    pub fn closed(&self) -> Option<Parting> {
        lock(&self.waiting).closed
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
