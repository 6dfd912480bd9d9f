//! When a target that failed is tried again, by the law of [`rts_plan::backoff`].

use std::collections::BTreeMap;

use rts_plan::backoff::{RESET_AFTER, delay};
use rts_plan::plan::Blocked;
use tokio::time::Instant;

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

impl BackOff {
    /// A target failed. `chance` is a number in 0.0..1.0.
    pub fn failed(&mut self, target: String, reason: String, chance: f64) {
        let now = Instant::now();
        self.0.retain(|_, entry| entry.failed + RESET_AFTER > now);
        let tries = self.0.get(&target).map_or(1, |e| e.tries.saturating_add(1));
        let entry = Entry {
            tries,
            reason,
            failed: now,
            until: now + delay(tries, chance),
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
    use std::time::Duration;

    #[tokio::test(start_paused = true)]
    async fn a_target_is_blocked_for_its_delay_and_its_tries_count_on() {
        let mut back_off = BackOff::default();
        back_off.failed("local|manager/m".to_owned(), "died".to_owned(), 0.5);
        assert_eq!(back_off.blocked()["local|manager/m"], "died");
        tokio::time::advance(Duration::from_millis(700)).await;
        assert!(back_off.blocked().is_empty());
        back_off.failed("local|manager/m".to_owned(), "died".to_owned(), 0.5);
        tokio::time::advance(Duration::from_millis(700)).await;
        assert_eq!(back_off.blocked().len(), 1);
        tokio::time::advance(RESET_AFTER).await;
        back_off.failed("local|manager/m".to_owned(), "died".to_owned(), 0.5);
        tokio::time::advance(Duration::from_millis(700)).await;
        assert!(back_off.blocked().is_empty(), "forgotten meanwhile");
    }
}
