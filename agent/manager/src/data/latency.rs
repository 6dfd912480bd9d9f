//! How long samples take, in a histogram of powers of two.

use std::sync::atomic::{AtomicU64, Ordering};

use rts_manager_api::control::Latency;

/// Enough for 18 minutes; what takes longer is in the last one.
const CLASSES: usize = 41;

/// Durations in nanoseconds; a class holds those of one length in bits.
#[derive(Debug)]
pub struct Latencies {
    classes: [AtomicU64; CLASSES],
    least: AtomicU64,
    most: AtomicU64,
}

impl Latencies {
    /// Without any.
    pub fn new() -> Self {
        Self {
            classes: [const { AtomicU64::new(0) }; CLASSES],
            least: AtomicU64::new(u64::MAX),
            most: AtomicU64::new(0),
        }
    }

    /// Counts one.
    pub fn count(&self, nanoseconds: u64) {
        let class = (u64::BITS - nanoseconds.leading_zeros()) as usize;
        self.classes[class.min(CLASSES - 1)].fetch_add(1, Ordering::Relaxed);
        self.least.fetch_min(nanoseconds, Ordering::Relaxed);
        self.most.fetch_max(nanoseconds, Ordering::Relaxed);
    }

    /// What was counted; none without any.
    pub fn summary(&self) -> Option<Latency> {
        let classes = self.classes.each_ref().map(|c| c.load(Ordering::Relaxed));
        let count: u64 = classes.iter().sum();
        let most = self.most.load(Ordering::Relaxed);
        let least = self.least.load(Ordering::Relaxed).min(most);
        // The upper end of the class with the sample that so many hundredths are not above.
        let quantile = |hundredths: u64| {
            let mut left = (count * hundredths).div_ceil(100);
            let class = classes.iter().position(|in_class| {
                left = left.saturating_sub(*in_class);
                left == 0
            });
            let end = (1_u64 << class.unwrap_or(CLASSES - 1)) - 1;
            end.clamp(least, most)
        };
        (count > 0).then(|| Latency {
            count,
            min_ns: least,
            median_ns: quantile(50),
            p99_ns: quantile(99),
            max_ns: most,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn nothing_counted_is_no_latency() {
        assert_eq!(Latencies::new().summary(), None);
    }

    proptest! {
        #[test]
        fn a_quantile_is_less_than_twice_too_high_and_never_too_low(
            mut values in prop::collection::vec(0_u64..1 << 39, 1..200)
        ) {
            let latencies = Latencies::new();
            values.iter().for_each(|value| latencies.count(*value));
            let summary = latencies.summary().unwrap();
            values.sort_unstable();
            prop_assert_eq!(summary.count, values.len() as u64);
            prop_assert_eq!(summary.min_ns, values[0]);
            prop_assert_eq!(summary.max_ns, values[values.len() - 1]);
            for (hundredths, found) in [(50, summary.median_ns), (99, summary.p99_ns)] {
                let exact = values[(values.len() * hundredths).div_ceil(100) - 1];
                prop_assert!(exact <= found && found <= exact * 2, "{} {}", exact, found);
            }
        }

        #[test]
        fn any_duration_is_counted(value: u64) {
            let latencies = Latencies::new();
            latencies.count(value);
            let summary = latencies.summary().unwrap();
            prop_assert_eq!((summary.count, summary.median_ns), (1, value));
        }
    }
}
