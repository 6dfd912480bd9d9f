//! When a target that failed is tried again: 0.5 s, doubling to 60 s, ±20 %; forgotten after ten minutes in peace.

use std::collections::BTreeMap;
use std::time::Duration;

use rts_plan::plan::Blocked;
use tokio::time::Instant;

/// Delay after the first failure.
const FIRST: Duration = Duration::from_millis(500);
/// Longest delay before jitter.
const LONGEST: Duration = Duration::from_secs(60);
/// Share of the delay by which it is changed at most, either way.
const JITTER: f64 = 0.2;
/// After this long without a failure a target's tries are forgotten.
const PEACE: Duration = Duration::from_secs(600);

/// Targets that failed, by [`rts_plan::target::on`].
#[derive(Debug, Default)]
pub(crate) struct BackOff(BTreeMap<String, Entry>);

#[derive(Debug)]
struct Entry {
    tries: u32,
    reason: String,
    failed: Instant,
    until: Instant,
}

/// Delay after the `tries`th failure; `chance` is in 0.0..1.0.
fn delay(tries: u32, chance: f64) -> Duration {
    // 2^7 × 0.5 s is above the cap already: a larger exponent would only overflow.
    let doublings = tries.saturating_sub(1).min(7);
    let plain = FIRST.saturating_mul(1 << doublings).min(LONGEST);
    plain.mul_f64(1.0 + JITTER * (2.0 * chance - 1.0))
}

impl BackOff {
    /// A target failed.
    pub fn failed(&mut self, target: String, reason: String) {
        let now = Instant::now();
        self.0.retain(|_, entry| entry.failed + PEACE > now);
        let tries = self.0.get(&target).map_or(1, |e| e.tries.saturating_add(1));
        let entry = Entry {
            tries,
            reason,
            failed: now,
            until: now + delay(tries, rand::random()),
        };
        self.0.insert(target, entry);
    }

    /// What must not be tried yet.
    pub fn blocked(&self) -> Blocked {
        let now = Instant::now();
        let blocked = self.0.iter().filter(|(_, entry)| entry.until > now);
        blocked
            .map(|(target, entry)| (target.clone(), entry.reason.clone()))
            .collect()
    }

    /// Forgets everything: somebody else decides now.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_double_to_a_minute_and_never_wrap() {
        let seconds = |tries| delay(tries, 0.5).as_secs_f64();
        assert_eq!([1, 2, 3, 7].map(seconds), [0.5, 1.0, 2.0, 32.0]);
        for tries in [8, 9, 64, u32::MAX] {
            assert_eq!(seconds(tries), 60.0, "{tries}");
        }
        assert!(
            delay(1, 0.0) >= FIRST.mul_f64(0.79) && delay(u32::MAX, 1.0) <= LONGEST.mul_f64(1.21)
        );
    }

    #[tokio::test(start_paused = true)]
    async fn a_target_is_blocked_for_its_delay_and_its_tries_count_on() {
        let mut back_off = BackOff::default();
        back_off.failed("local|manager/m".to_owned(), "died".to_owned());
        assert_eq!(back_off.blocked()["local|manager/m"], "died");
        tokio::time::advance(Duration::from_millis(700)).await;
        assert!(back_off.blocked().is_empty());
        back_off.failed("local|manager/m".to_owned(), "died".to_owned());
        tokio::time::advance(Duration::from_millis(700)).await;
        assert_eq!(back_off.blocked().len(), 1);
        tokio::time::advance(PEACE).await;
        back_off.failed("local|manager/m".to_owned(), "died".to_owned());
        tokio::time::advance(Duration::from_millis(700)).await;
        assert!(back_off.blocked().is_empty(), "forgotten meanwhile");
    }
}
