//! The network between hosts: the controller, the nodes, the user. Messages take their time, are lost, come twice, and
//! overtake each other.
//!
//! A request is handled at its receiver until it is done, even if nobody waits for the answer any more; but where the
//! caller gives up and his goodbye arrives, the handling is dropped, as a server does when a connection is closed.

mod ask;
mod line;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;
use tokio::time::sleep;

use crate::seed::{Seed, Stream};

pub use self::ask::{Asked, Reset};
pub use self::line::{Line, Teller, line};

/// Usual time of a message, in microseconds.
const USUAL: (u64, u64) = (200, 3000);

/// What can happen to any message between the controller and agents.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Weather {
    /// Parts of a thousand that are lost.
    pub lost: u32,
    /// Parts of a thousand that come twice.
    pub doubled: u32,
    /// Longest additional delay.
    pub delay: Duration,
}

/// The network. Clones are the same.
#[derive(Clone)]
pub struct Net(Arc<Inner>);

struct Inner {
    seed: Seed,
    state: Mutex<State>,
    /// Told of each change of what is cut or dark.
    changed: Notify,
}

#[derive(Default)]
struct State {
    /// Direction → how often it is cut.
    cut: BTreeMap<(String, String), u32>,
    /// Hosts without power.
    dark: BTreeSet<String>,
    weather: Vec<(u64, Weather)>,
    next: u64,
    streams: BTreeMap<(String, String), Arc<Stream>>,
    counts: Counts,
}

/// What happened on the network.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Messages that were sent.
    pub sent: u64,
    /// Of those, the lost ones.
    pub lost: u64,
    /// Of those, the ones that came twice.
    pub doubled: u64,
}

/// How a message fares.
struct Fate {
    lost: bool,
    after: Duration,
    again: Option<Duration>,
}

impl Net {
    /// A network in good order.
    pub fn new(seed: Seed) -> Self {
        Self(Arc::new(Inner {
            seed,
            state: Mutex::default(),
            changed: Notify::new(),
        }))
    }

    /// Nothing that `from` says reaches `to`, until it is mended as often as it was cut.
    pub fn cut(&self, from: &str, to: &str) {
        *self.state().cut.entry(key(from, to)).or_default() += 1;
        self.tell();
    }

    /// Undoes one cut.
    pub fn mend(&self, from: &str, to: &str) {
        let mut state = self.state();
        if let Some(times) = state.cut.get_mut(&key(from, to)) {
            *times -= 1;
            if *times == 0 {
                state.cut.remove(&key(from, to));
            }
        }
        drop(state);
        self.tell();
    }

    /// A host loses its power, or has it again.
    pub fn dark(&self, host: &str, dark: bool) {
        let mut state = self.state();
        if dark {
            state.dark.insert(host.to_owned());
        } else {
            state.dark.remove(host);
        }
        drop(state);
        self.tell();
    }

    /// Weather begins; gives its number.
    pub fn weather(&self, weather: Weather) -> u64 {
        let mut state = self.state();
        state.next += 1;
        let number = state.next;
        state.weather.push((number, weather));
        number
    }

    /// Weather ends.
    pub fn clear(&self, number: u64) {
        self.state().weather.retain(|(n, _)| *n != number);
    }

    /// True when messages of this direction arrive now.
    pub fn is_open(&self, from: &str, to: &str) -> bool {
        let state = self.state();
        !state.cut.contains_key(&key(from, to))
            && !state.dark.contains(from)
            && !state.dark.contains(to)
    }

    /// What happened so far.
    pub fn counts(&self) -> Counts {
        self.state().counts
    }

    /// Waits until messages of this direction arrive.
    async fn until_open(&self, from: &str, to: &str) {
        loop {
            let changed = self.0.changed.notified();
            if self.is_open(from, to) {
                return;
            }
            changed.await;
        }
    }

    /// One message on its way. False when it does not arrive.
    async fn travel(&self, from: &str, to: &str, fate: &Fate) -> bool {
        if fate.lost || !self.is_open(from, to) {
            return false;
        }
        sleep(fate.after).await;
        self.is_open(from, to)
    }

    /// Draws the same number of times for every message, so that weather moves no draw of those that come later.
    fn fate(&self, from: &str, to: &str) -> Fate {
        let mut state = self.state();
        let weather = if from == "user" || to == "user" {
            Weather::default()
        } else {
            worst(&state.weather)
        };
        let seed = self.0.seed;
        let stream = state.streams.entry(key(from, to)).or_insert_with(|| {
            let name = format!("net/{from}/{to}");
            Arc::new(seed.stream(&name))
        });
        let stream = Arc::clone(stream);
        let delay = || {
            let usual = stream.between(USUAL.0, USUAL.1);
            let more = stream.between(0, 1000) * micros(weather.delay) / 1000;
            Duration::from_micros(usual + more)
        };
        let (after, again) = (delay(), delay());
        let (lost, doubled) = (stream.between(0, 999), stream.between(0, 999));
        let lost = lost < weather.lost.into();
        let doubled = !lost && doubled < weather.doubled.into();
        state.counts.sent += 1;
        state.counts.lost += u64::from(lost);
        state.counts.doubled += u64::from(doubled);
        Fate {
            lost,
            after,
            again: doubled.then_some(again),
        }
    }

    /// A choice about a connection of this direction.
    fn chance(&self, from: &str, to: &str) -> bool {
        let name = format!("connection/{from}/{to}");
        let seed = self.0.seed;
        let mut state = self.state();
        let stream = state.streams.entry((name.clone(), String::new()));
        stream
            .or_insert_with(|| Arc::new(seed.stream(&name)))
            .chance(0.5)
    }

    fn tell(&self) {
        self.0.changed.notify_waiters();
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn key(from: &str, to: &str) -> (String, String) {
    (from.to_owned(), to.to_owned())
}

fn micros(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX / 1000)
}

fn worst(all: &[(u64, Weather)]) -> Weather {
    let mut worst = Weather::default();
    for (_, weather) in all {
        worst.lost = worst.lost.max(weather.lost);
        worst.doubled = worst.doubled.max(weather.doubled);
        worst.delay = worst.delay.max(weather.delay);
    }
    worst
}

#[cfg(test)]
mod tests;
