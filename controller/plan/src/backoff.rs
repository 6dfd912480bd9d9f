//! The one law of delays: when that which failed may be tried again.
//!
//! 0.5 s after the first failure, doubling to 60 s, changed by at most 20 % so that many do not try at once. Whoever
//! counts the tries forgets them after [`RESET_AFTER`] without a failure.

use std::time::Duration;

/// Delay after the first failure, before jitter.
pub const FIRST: Duration = Duration::from_millis(500);

/// Longest delay, before jitter.
pub const LONGEST: Duration = Duration::from_secs(60);

/// Share of the delay by which it is changed at most, either way.
pub const JITTER: f64 = 0.2;

/// After this long without a failure the tries are forgotten.
pub const RESET_AFTER: Duration = Duration::from_secs(600);

/// Delay after the `tries`th failure; `chance` is in 0.0..=1.0, and 0.5 gives the delay without jitter.
pub fn delay(tries: u32, chance: f64) -> Duration {
    // 2^7 × 0.5 s is above the cap already: a larger exponent would only overflow.
    let doublings = tries.saturating_sub(1).min(7);
    let plain = FIRST.saturating_mul(1 << doublings).min(LONGEST);
    let chance = if chance.is_finite() { chance } else { 0.5 };
    plain.mul_f64(1.0 + JITTER * (2.0 * chance.clamp(0.0, 1.0) - 1.0))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Tries near both ends are as likely as all others together.
    fn tries() -> impl Strategy<Value = u32> {
        prop_oneof![0..80u32, any::<u32>(), Just(u32::MAX)]
    }

    proptest! {
        #[test]
        fn jitter_stays_in_its_bounds(tries in tries(), chance in any::<f64>()) {
            let (plain, delay) = (delay(tries, 0.5), delay(tries, chance));
            prop_assert!(delay >= plain.mul_f64(1.0 - JITTER));
            prop_assert!(delay <= plain.mul_f64(1.0 + JITTER));
            prop_assert!(!delay.is_zero());
        }

        #[test]
        fn the_plain_delay_is_between_the_first_and_the_longest(tries in tries()) {
            prop_assert!((FIRST..=LONGEST).contains(&delay(tries, 0.5)));
        }

        #[test]
        fn a_later_try_waits_at_least_as_long(tries in tries(), chance in 0.0..=1.0f64) {
            prop_assert!(delay(tries.saturating_add(1), chance) >= delay(tries, chance));
        }
    }

    #[test]
    fn delays_double_to_a_minute_and_never_wrap() {
        let plain = [0, 1, 2, 3, 7, 8, 64, u32::MAX].map(|tries| delay(tries, 0.5).as_millis());
        assert_eq!(plain, [500, 500, 1000, 2000, 32000, 60000, 60000, 60000]);
    }
}
