//! Looking again and again before sleeping: waking who sleeps costs more than most waits are long.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// Looks at most, some 50 µs: about what it takes to wake a processor that sleeps.
pub const MOST: u32 = 2000;
/// Looks at least.
const LEAST: u32 = 50;
/// A sleep that is shorter might have been none.
const SHORT: Duration = Duration::from_micros(100);
/// Of so many short sleeps, one is tried without.
const TRIAL: u32 = 32;

/// How long it pays to look, as learned from the waits before: one that waits for each millisecond sleeps at once, and
/// costs nothing; one that gets its answer at once does not sleep at all.
#[derive(Debug)]
pub struct Spin {
    budget: AtomicU32,
    short_sleeps: AtomicU32,
}

impl Default for Spin {
    fn default() -> Self {
        Self {
            budget: AtomicU32::new(MOST),
            short_sleeps: AtomicU32::new(0),
        }
    }
}

impl Spin {
    /// Looks until `ready`; false when it does not pay any more.
    pub fn until(&self, ready: impl Fn() -> bool) -> bool {
        let budget = self.budget.load(Ordering::Relaxed);
        for look in 1..=budget {
            if ready() {
                if look > budget / 2 {
                    self.budget.store((budget * 2).min(MOST), Ordering::Relaxed);
                }
                return true;
            }
            // Not `yield_now`: who else wants to run would have the processor for milliseconds.
            std::hint::spin_loop();
        }
        false
    }

    /// It was of no use: so long was slept afterwards.
    pub fn slept(&self, slept: Duration) {
        let trials = match slept < SHORT {
            true => self.short_sleeps.fetch_add(1, Ordering::Relaxed),
            false => 1,
        };
        let budget = match trials.is_multiple_of(TRIAL) {
            true => MOST,
            false => (self.budget.load(Ordering::Relaxed) / 2).max(LEAST),
        };
        self.budget.store(budget, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn looks(spin: &Spin) -> u32 {
        let looks = AtomicU32::new(0);
        assert!(!spin.until(|| {
            looks.fetch_add(1, Ordering::Relaxed);
            false
        }));
        looks.into_inner()
    }

    #[test]
    fn one_that_sleeps_long_looks_little() {
        let spin = Spin::default();
        assert_eq!(looks(&spin), MOST);
        for _ in 0..20 {
            spin.slept(Duration::from_millis(1));
        }
        assert_eq!(looks(&spin), LEAST);
    }

    #[test]
    fn one_that_sleeps_briefly_tries_now_and_then_and_goes_on_when_it_pays() {
        let spin = Spin::default();
        let briefly = Duration::from_micros(5);
        let tried: Vec<_> = (0..80)
            .map(|_| {
                spin.slept(briefly);
                looks(&spin) == MOST
            })
            .collect();
        assert_eq!(tried.iter().filter(|tried| **tried).count(), 3);
        while looks(&spin) < MOST {
            spin.slept(briefly);
        }
        assert!(spin.until(|| true));
        assert_eq!(looks(&spin), MOST);
    }
}
