//! Looking again and again before sleeping: waking who sleeps costs more than most waits are long.

use std::sync::atomic::{AtomicU32, Ordering};

/// Looks at most, some 80 µs: the time in which the other side reads and answers a sample of a megabyte.
pub const MOST: u32 = 4000;
/// Looks at least.
const LEAST: u32 = 100;
/// After so many waits in a row for which even the most was too little, few looks are enough.
const PATIENT: u32 = 4;
/// Then one of so many waits tries again.
const TRIAL: u32 = 32;

/// How long it pays to look, as learned from the waits before: who is answered at once does not sleep at all, and who
/// waits for each millisecond sleeps soon, and costs next to nothing.
#[derive(Debug, Default)]
pub struct Spin {
    /// Waits in a row that ended in a sleep.
    slept: AtomicU32,
}

impl Spin {
    /// Looks until `ready`; false when a sleep is cheaper.
    pub fn until(&self, ready: impl Fn() -> bool) -> bool {
        let slept = self.slept.load(Ordering::Relaxed);
        let looks = match slept < PATIENT || slept.is_multiple_of(TRIAL) {
            true => MOST,
            false => LEAST,
        };
        for look in 0..looks {
            if ready() {
                // Fewer would have been too few.
                if look >= LEAST {
                    self.slept.store(0, Ordering::Relaxed);
                }
                return true;
            }
            // Not `yield_now`: who else wants to run would have the processor for milliseconds.
            std::hint::spin_loop();
        }
        self.slept.store(slept.wrapping_add(1), Ordering::Relaxed);
        false
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
    fn one_that_always_sleeps_looks_little_and_tries_now_and_then() {
        let spin = Spin::default();
        let tried: Vec<_> = (0..100).filter(|_| looks(&spin) == MOST).collect();
        assert_eq!(tried, [0, 1, 2, 3, 32, 64, 96]);
    }

    #[test]
    fn one_that_is_answered_in_time_goes_on_looking() {
        let spin = Spin::default();
        while looks(&spin) == MOST {}
        while looks(&spin) == LEAST {}
        let left = AtomicU32::new(MOST / 2);
        spin.slept.store(TRIAL, Ordering::Relaxed);
        assert!(spin.until(|| left.fetch_sub(1, Ordering::Relaxed) == 0));
        assert_eq!(looks(&spin), MOST);
    }
}
