//! Taps of an out-port: who looks at what it writes, besides its connectors. A tap never makes the writer wait: what it
//! has no room for is missed, and counted.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{SystemTime, UNIX_EPOCH};

use rts_schemas::connector::{BufferSettings, EmptyPolicy, FullPolicy};
use rustix::event::{EventfdFlags, eventfd};

use super::Payload;
use super::budget::Budget;
use super::buffer::Buffer;
use crate::sync::lock;

/// Samples that wait for one reader; above that the oldest go.
const LENGTH: usize = 256;
/// Bytes that wait for one reader; one sample always fits.
const BYTES: usize = 32 * 1024 * 1024;
/// Bytes that all taps of the process may hold, apart from those of connectors.
static ALL: Budget = Budget::new(128 * 1024 * 1024);

/// The taps of one out-port. Without any, a write looks at one number.
#[derive(Debug, Default)]
pub struct Taps {
    count: AtomicUsize,
    /// A list of its own for each change, as that of connectors.
    list: Mutex<Arc<Vec<Arc<Tap>>>>,
}

impl Taps {
    /// Shows a sample to each of them.
    pub fn offer(&self, payload: &Payload) {
        if self.count.load(Ordering::Acquire) == 0 {
            return;
        }
        let taps = Arc::clone(&lock(&self.list));
        let time = now();
        for tap in taps.iter() {
            tap.offer(payload, time);
        }
    }

    /// Adds one; it leaves when what is given back is dropped.
    pub fn add(self: &Arc<Self>, tap: &Arc<Tap>) -> Tapped {
        let mut list = lock(&self.list);
        Arc::make_mut(&mut list).push(Arc::clone(tap));
        self.count.store(list.len(), Ordering::Release);
        Tapped {
            taps: Arc::clone(self),
            tap: Arc::clone(tap),
        }
    }
}

/// A tap among those of its port.
#[derive(Debug)]
pub struct Tapped {
    taps: Arc<Taps>,
    tap: Arc<Tap>,
}

impl Drop for Tapped {
    fn drop(&mut self) {
        let mut list = lock(&self.taps.list);
        Arc::make_mut(&mut list).retain(|tap| !Arc::ptr_eq(tap, &self.tap));
        self.taps.count.store(list.len(), Ordering::Release);
    }
}

/// What a reader has still to see.
#[derive(Debug)]
pub struct Tap {
    waiting: Mutex<Waiting>,
    filled: OwnedFd,
}

#[derive(Debug)]
struct Waiting {
    buffer: Buffer<Seen>,
    missed: u64,
}

/// A sample that was seen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seen {
    /// Time of writing, in nanoseconds since 1970.
    pub time: u64,
    /// Its bytes.
    pub payload: Payload,
}

impl Tap {
    /// Nothing was seen yet.
    pub fn new() -> io::Result<Self> {
        let settings = BufferSettings {
            length: LENGTH,
            full: FullPolicy::Overwrite,
            empty: EmptyPolicy::DoNothing,
            ..BufferSettings::default()
        };
        Ok(Self {
            waiting: Mutex::new(Waiting {
                buffer: Buffer::new(settings, BYTES, &ALL),
                missed: 0,
            }),
            filled: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
        })
    }

    fn offer(&self, payload: &Payload, time: u64) {
        let seen = Seen {
            time,
            payload: payload.clone(),
        };
        let mut waiting = lock(&self.waiting);
        let Waiting { buffer, missed } = &mut *waiting;
        let was_empty = buffer.is_empty();
        // One that overwrites gives nothing back.
        let _ = buffer.write(seen, payload.len(), |_| *missed += 1);
        if was_empty {
            // Fails only when it is signalled already.
            let _ = rustix::io::write(&self.filled, &1_u64.to_ne_bytes());
        }
    }

    /// The oldest sample, and how many were missed until now.
    pub fn take(&self) -> Option<(Seen, u64)> {
        let mut waiting = lock(&self.waiting);
        let seen = waiting.buffer.take()?;
        Some((seen, waiting.missed))
    }

    /// Readable when there may be a sample.
    pub fn filled(&self) -> BorrowedFd<'_> {
        self.filled.as_fd()
    }

    /// Takes the signs of until now.
    pub fn awake(&self) {
        let mut count = [0; 8];
        let _ = rustix::io::read(&self.filled, &mut count);
    }
}

fn now() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |since| {
        u64::try_from(since.as_nanos()).unwrap_or(u64::MAX)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(number: u64) -> Payload {
        Payload::copy_from_slice(&number.to_be_bytes())
    }

    fn number(seen: &Seen) -> u64 {
        u64::from_be_bytes(seen.payload[..].try_into().unwrap())
    }

    #[test]
    fn a_reader_that_is_slow_misses_the_oldest_and_is_told_how_many() {
        let taps = Arc::<Taps>::default();
        let tap = Arc::new(Tap::new().unwrap());
        let _tapped = taps.add(&tap);
        let all = LENGTH as u64 + 5;
        (0..all).for_each(|number| taps.offer(&sample(number)));
        let (first, missed) = tap.take().unwrap();
        assert_eq!((number(&first), missed), (5, 5));
        let rest: Vec<_> = std::iter::from_fn(|| tap.take())
            .map(|(seen, _)| number(&seen))
            .collect();
        assert_eq!(rest, (6..all).collect::<Vec<_>>());
    }

    #[test]
    fn nothing_is_left_of_a_tap_that_ended() {
        let taps = Arc::<Taps>::default();
        let (one, two) = (Arc::new(Tap::new().unwrap()), Arc::new(Tap::new().unwrap()));
        let first = taps.add(&one);
        let _second = taps.add(&two);
        drop(first);
        taps.offer(&sample(1));
        assert!(one.take().is_none() && two.take().is_some());
        assert_eq!(Arc::strong_count(&one), 1);
    }
}
