//! Data that several threads wait for: room for a sample, a sample, an answer.

use std::ops::{Deref, DerefMut};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::sync::lock;

/// Data behind a lock, and those who wait for it to change.
#[derive(Debug, Default)]
pub struct Monitor<T> {
    watched: Mutex<Watched<T>>,
    changed: Condvar,
}

/// The data, while it is locked.
#[derive(Debug, Default)]
pub struct Watched<T> {
    data: T,
    sleepers: usize,
}

/// The lock.
pub type Guard<'a, T> = MutexGuard<'a, Watched<T>>;

/// What a look at the data has shown.
pub enum Seen<R> {
    /// This was waited for.
    Done(R),
    /// Nothing yet: it is waited for so long in all.
    Wait(Duration),
}

impl<T> Monitor<T> {
    /// Over this.
    pub fn new(data: T) -> Self {
        Self {
            watched: Mutex::new(Watched { data, sleepers: 0 }),
            changed: Condvar::new(),
        }
    }

    /// Locks the data.
    pub fn lock(&self) -> Guard<'_, T> {
        lock(&self.watched)
    }

    /// Tells those who wait that something has changed; next to nothing when nobody does.
    pub fn notify(&self, watched: &Watched<T>) {
        if watched.sleepers > 0 {
            self.changed.notify_all();
        }
    }

    /// Looks now, and after each change, until something is seen; none when the time since `began` is over before. No
    /// nap between two looks is longer than `nap`.
    pub fn wait<'a, R>(
        &'a self,
        mut guard: Guard<'a, T>,
        began: Instant,
        nap: Duration,
        mut look: impl FnMut(&mut Watched<T>) -> Seen<R>,
    ) -> (Guard<'a, T>, Option<R>) {
        loop {
            let longest = match look(&mut guard) {
                Seen::Done(seen) => return (guard, Some(seen)),
                Seen::Wait(longest) => longest,
            };
            let left = longest.saturating_sub(began.elapsed());
            if left.is_zero() {
                return (guard, None);
            }
            guard.sleepers += 1;
            let woken = self.changed.wait_timeout(guard, left.min(nap));
            guard = woken.unwrap_or_else(PoisonError::into_inner).0;
            guard.sleepers -= 1;
        }
    }

    /// True while a thread waits.
    #[cfg(test)]
    pub fn has_sleepers(&self) -> bool {
        self.lock().sleepers > 0
    }
}

impl<T> Deref for Watched<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.data
    }
}

impl<T> DerefMut for Watched<T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.data
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    #[test]
    fn who_waits_sees_a_change_or_the_end_of_its_time() {
        let monitor = Monitor::new(0);
        let look = |limit: Duration| {
            let began = Instant::now();
            let seen = |data: &mut Watched<i32>| match **data {
                0 => Seen::Wait(limit),
                number => Seen::Done(number),
            };
            monitor.wait(monitor.lock(), began, Duration::MAX, seen).1
        };
        assert_eq!(look(Duration::ZERO), None);
        assert_eq!(look(Duration::from_millis(10)), None);
        thread::scope(|scope| {
            let waiting = scope.spawn(|| look(Duration::from_secs(60)));
            while !monitor.has_sleepers() {
                thread::yield_now();
            }
            let mut data = monitor.lock();
            **data = 7;
            monitor.notify(&data);
            drop(data);
            assert_eq!(waiting.join().unwrap(), Some(7));
        });
    }
}
