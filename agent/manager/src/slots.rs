//! A bound on how many of something there may be at once.

use std::sync::{Arc, Condvar, Mutex};
use std::time::Instant;

use crate::sync::lock;

/// A number of places.
#[derive(Clone)]
pub struct Slots {
    taken: Arc<Taken>,
    limit: usize,
}

#[derive(Default)]
struct Taken {
    count: Mutex<usize>,
    none: Condvar,
}

/// One place; given back on drop.
pub struct Slot(Arc<Taken>);

impl Slots {
    /// With `limit` places.
    pub fn new(limit: usize) -> Self {
        Self {
            taken: Arc::default(),
            limit,
        }
    }

    /// How many places there are.
    pub fn limit(&self) -> usize {
        self.limit
    }

    /// Takes a place when one is free.
    pub fn take(&self) -> Option<Slot> {
        let mut count = lock(&self.taken.count);
        if *count >= self.limit {
            return None;
        }
        *count += 1;
        Some(Slot(Arc::clone(&self.taken)))
    }

    /// Waits until none is taken, or the deadline.
    pub fn wait(&self, deadline: Instant) {
        let count = lock(&self.taken.count);
        let left = deadline.saturating_duration_since(Instant::now());
        let taken = |count: &mut usize| *count > 0;
        let _ = self.taken.none.wait_timeout_while(count, left, taken);
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        let mut count = lock(&self.0.count);
        *count -= 1;
        if *count == 0 {
            self.0.none.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_place_is_free_again_after_its_drop() {
        let slots = Slots::new(2);
        let first = slots.take().unwrap();
        let _second = slots.take().unwrap();
        assert!(slots.take().is_none());
        drop(first);
        assert!(slots.take().is_some());
    }

    #[test]
    fn who_waits_goes_on_when_the_last_one_is_given_back() {
        let slots = Slots::new(2);
        let places = (slots.take().unwrap(), slots.take().unwrap());
        let begin = Instant::now();
        slots.wait(begin + Duration::from_millis(1));
        assert!(begin.elapsed() >= Duration::from_millis(1));
        let giver = std::thread::spawn(move || drop(places));
        slots.wait(begin + Duration::from_secs(60));
        assert!(begin.elapsed() < Duration::from_secs(60));
        giver.join().unwrap();
        assert!(slots.take().is_some());
    }
}
