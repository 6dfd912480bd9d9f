//! How an execution context keeps its time. One thread counts, any may look.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use rts_manager_api::control::{DurationInfo, TimingInfo};

use crate::data::rate::Rate;
use crate::data::sample::now;

/// Buckets of one doubling.
const PARTS: usize = 4;
/// Doublings of a nanosecond: the last one begins at 34 s.
const DOUBLINGS: usize = 36;

/// Figures of one execution context.
#[derive(Debug, Default)]
pub struct Timing {
    /// How long cycles took.
    execution: Histogram,
    /// How late periodic ones began.
    pub jitter: Histogram,
    overruns: AtomicU64,
    reached: Rate,
}

impl Timing {
    /// A cycle is over that took this long.
    pub fn ran(&self, took: Duration) {
        self.execution.add(took);
        self.reached.count(now());
    }

    /// A cycle was not over when the next one was due.
    pub fn count_overrun(&self) {
        self.overruns.fetch_add(1, Ordering::Relaxed);
    }

    /// What the inventory shows; none before the first cycle.
    pub fn info(&self) -> Option<TimingInfo> {
        Some(TimingInfo {
            overruns: self.overruns.load(Ordering::Relaxed),
            reached: Some(self.reached.at(now())),
            execution: self.execution.info()?,
            jitter: self.jitter.info(),
        })
    }
}

/// Durations in buckets, each at most a quarter above the one before.
#[derive(Debug)]
pub struct Histogram {
    counts: [AtomicU64; PARTS * DOUBLINGS],
    most: AtomicU64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self {
            counts: [const { AtomicU64::new(0) }; PARTS * DOUBLINGS],
            most: AtomicU64::new(0),
        }
    }
}

impl Histogram {
    /// Counts a duration.
    pub fn add(&self, duration: Duration) {
        let nanoseconds = u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
        self.counts[bucket(nanoseconds)].fetch_add(1, Ordering::Relaxed);
        self.most.fetch_max(nanoseconds, Ordering::Relaxed);
    }

    /// What the inventory shows; none without a duration.
    pub fn info(&self) -> Option<DurationInfo> {
        let counts: Vec<u64> = self
            .counts
            .iter()
            .map(|count| count.load(Ordering::Relaxed))
            .collect();
        let total: u64 = counts.iter().sum();
        let most = self.most.load(Ordering::Relaxed);
        let below = |share: f64| {
            let wanted = (total as f64 * share).ceil() as u64;
            let mut seen = 0;
            let found = counts.iter().position(|count| {
                seen += count;
                seen >= wanted
            });
            // The last doubling has all that is longer, too.
            let found = found.filter(|index| index / PARTS + 1 < DOUBLINGS);
            found.map_or(most, |index| end(index).min(most))
        };
        let doublings = counts.chunks(PARTS).map(|parts| parts.iter().sum::<u64>());
        let buckets = doublings
            .enumerate()
            .filter(|(_, count)| *count > 0)
            .map(|(index, count)| (1 << (index + 1), count));
        (total > 0).then(|| DurationInfo {
            count: total,
            median: below(0.5),
            p99: below(0.99),
            p999: below(0.999),
            max: most,
            buckets: buckets.collect(),
        })
    }
}

/// The bucket of a duration: its doubling, and the part of that by the two bits after the first.
fn bucket(nanoseconds: u64) -> usize {
    let doubling = nanoseconds.max(1).ilog2() as usize;
    let part = match doubling {
        0 | 1 => 0,
        _ => (nanoseconds >> (doubling - 2)) as usize % PARTS,
    };
    (doubling.min(DOUBLINGS - 1)) * PARTS + part
}

/// The duration that a bucket ends before.
fn end(index: usize) -> u64 {
    let (doubling, part) = (index / PARTS, index % PARTS);
    match doubling {
        0 | 1 => 2 << doubling,
        _ => (PARTS + part + 1) as u64 * (1 << (doubling - 2)),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_duration_is_below_the_end_of_its_bucket_and_not_far(ns in 4_u64..30_000_000_000) {
            let end = end(bucket(ns));
            prop_assert!(ns < end);
            prop_assert!(end <= ns + ns / 4 + 1, "{end}");
        }
    }

    #[test]
    fn figures_of_durations() {
        let timing = Timing::default();
        assert_eq!(timing.info(), None);
        for us in 1..=100 {
            timing.ran(Duration::from_micros(us));
        }
        timing.ran(Duration::from_secs(1000));
        timing.count_overrun();
        let info = timing.info().unwrap();
        assert_eq!((info.overruns, info.jitter), (1, None));
        let shown = info.execution;
        assert_eq!((shown.count, shown.max), (101, 1_000_000_000_000));
        assert!(
            (50_000..=64_000).contains(&shown.median),
            "{}",
            shown.median
        );
        assert!((99_000..=125_000).contains(&shown.p99), "{}", shown.p99);
        assert_eq!(shown.p999, shown.max);
        assert_eq!(shown.buckets.first(), Some(&(1024, 1)));
        assert_eq!(
            shown.buckets.iter().map(|(_, count)| count).sum::<u64>(),
            101
        );
    }
}
