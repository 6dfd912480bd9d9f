//! Samples of the last whole second.

use std::sync::atomic::{AtomicU64, Ordering};

/// A second, in nanoseconds.
const SECOND: u64 = 1_000_000_000;

/// Counts by seconds. One thread counts; any may look.
#[derive(Debug, Default)]
pub struct Rate {
    second: AtomicU64,
    count: AtomicU64,
    before: AtomicU64,
}

impl Rate {
    /// Counts one at this time, in nanoseconds.
    pub fn count(&self, now: u64) {
        let second = now / SECOND;
        let known = self.second.load(Ordering::Relaxed);
        if second != known {
            let full = self.count.swap(0, Ordering::Relaxed);
            let before = if second == known + 1 { full } else { 0 };
            self.before.store(before, Ordering::Relaxed);
            self.second.store(second, Ordering::Relaxed);
        }
        self.count.fetch_add(1, Ordering::Relaxed);
    }

    /// How many the second before this time had.
    pub fn at(&self, now: u64) -> u64 {
        match (now / SECOND).checked_sub(self.second.load(Ordering::Relaxed)) {
            Some(0) => self.before.load(Ordering::Relaxed),
            Some(1) => self.count.load(Ordering::Relaxed),
            _ => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_that_of_the_last_whole_second() {
        let rate = Rate::default();
        let at = |seconds: f64| (seconds * SECOND as f64) as u64;
        assert_eq!(rate.at(at(5.0)), 0);
        for time in [5.0, 5.2, 5.9] {
            rate.count(at(time));
        }
        assert_eq!(rate.at(at(5.95)), 0, "the second is not over");
        assert_eq!(rate.at(at(6.5)), 3);
        rate.count(at(6.6));
        assert_eq!(rate.at(at(6.9)), 3);
        assert_eq!(rate.at(at(7.5)), 1);
        assert_eq!(rate.at(at(8.5)), 0);
        rate.count(at(9.0));
        assert_eq!((rate.at(at(9.5)), rate.at(at(10.0))), (0, 1));
    }
}
