//! When a target that failed is tried again: 0.5 s, doubling to 60 s, ±20 %; forgotten after ten healthy minutes.

use std::collections::BTreeMap;
use std::time::Duration;

use jiff::{SignedDuration, Timestamp};
use rts_plan::backoff::{RESET_AFTER, delay};
use rts_plan::plan::Blocked;
use tokio::time::Instant;

use crate::clock::Chance;

/// The target in a key of [`rts_plan::target::on`].
pub fn target_of(key: &str) -> &str {
    key.split_once('|').map_or(key, |(_, target)| target)
}

/// Targets that failed, by node and target ([`rts_plan::target::on`]).
#[derive(Debug, Default)]
pub struct Backoff {
    targets: BTreeMap<String, Entry>,
    /// What was brought up and not taken down: the name of its system, and when.
    up: BTreeMap<Brought, (Option<String>, Instant)>,
}

/// Something that was brought up: a target of the system of this very uid, on a node.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Brought {
    node: String,
    uid: String,
    target: String,
}

impl Brought {
    /// Of a system's uid; empty for what belongs to none.
    pub fn new(node: &str, uid: &str, target: &str) -> Self {
        Self {
            node: node.to_owned(),
            uid: uid.to_owned(),
            target: target.to_owned(),
        }
    }
}

/// A target that failed.
#[derive(Debug, Clone)]
pub struct Entry {
    /// System that it belongs to.
    pub system: Option<String>,
    /// Failures so far.
    pub tries: u32,
    /// Of the last failure.
    pub reason: String,
    /// Not before this; none once it has succeeded since.
    until: Option<Instant>,
    /// The same on the wall, for display.
    pub next_try: Timestamp,
    healthy_since: Option<Instant>,
}

impl Entry {
    /// True while it must not be tried.
    pub fn blocks(&self, now: Instant) -> bool {
        self.until.is_some_and(|until| until > now)
    }

    /// True when its last try failed.
    pub fn failing(&self) -> bool {
        self.until.is_some()
    }
}

impl Backoff {
    /// A target failed; gives the delay until it may be tried again.
    pub fn failed(
        &mut self,
        target: &str,
        system: Option<&str>,
        reason: &str,
        rng: &dyn Chance,
        wall: Timestamp,
    ) -> Duration {
        let tries = self.targets.get(target).map_or(0, |entry| entry.tries);
        let tries = tries.saturating_add(1);
        let delay = delay(tries, rng.unit());
        let entry = Entry {
            system: system.map(str::to_owned),
            tries,
            reason: reason.to_owned(),
            until: Some(Instant::now() + delay),
            next_try: wall
                .checked_add(SignedDuration::try_from(delay).unwrap_or_default())
                .unwrap_or(wall),
            healthy_since: None,
        };
        self.targets.insert(target.to_owned(), entry);
        delay
    }

    /// A target's steps succeeded: it is free; its tries count on until it was healthy for a while.
    pub fn succeeded(&mut self, target: &str) {
        if let Some(entry) = self.targets.get_mut(target) {
            entry.until = None;
            entry.healthy_since = Some(Instant::now());
        }
    }

    /// A new generation of a system starts without memories.
    pub fn forget_system(&mut self, system: &str) {
        self.targets
            .retain(|_, entry| entry.system.as_deref() != Some(system));
        self.up
            .retain(|_, (owner, _)| owner.as_deref() != Some(system));
    }

    /// Something was brought up.
    pub fn came_up(&mut self, who: Brought, system: Option<String>, at: Instant) {
        self.up.insert(who, (system, at));
    }

    /// It is no longer up. True when it was brought up not long ago.
    pub fn went(&mut self, who: &Brought) -> bool {
        let up = self.up.remove(who);
        up.is_some_and(|(_, at)| at.elapsed() < RESET_AFTER)
    }

    /// Forgets what has been healthy long enough, and what is due and no longer wanted.
    pub fn tidy(&mut self) {
        let now = Instant::now();
        self.up
            .retain(|_, (_, at)| now.duration_since(*at) < RESET_AFTER);
        self.targets.retain(|_, entry| {
            let healthy = entry
                .healthy_since
                .is_some_and(|since| now.duration_since(since) >= RESET_AFTER);
            let stale = entry.until.is_some_and(|until| until + RESET_AFTER <= now);
            !healthy && !stale
        });
    }

    /// What a plan must leave alone now, but for what is one system's.
    pub fn blocked_but(&self, system: Option<&str>) -> Blocked {
        let now = Instant::now();
        let others = |entry: &Entry| system.is_none() || entry.system.as_deref() != system;
        let targets = self.targets.iter();
        let blocking = targets.filter(|(_, entry)| entry.blocks(now) && others(entry));
        blocking
            .map(|(target, entry)| (target.clone(), entry.reason.clone()))
            .collect()
    }

    /// The first time after `planned` at which something may be tried again that could not be then. It may have passed.
    pub fn next(&self, planned: Instant) -> Option<Instant> {
        let entries = self.targets.values();
        let until = entries.filter_map(|e| e.until.filter(|u| *u > planned));
        until.min()
    }

    /// What is known of a target.
    pub fn get(&self, target: &str) -> Option<&Entry> {
        self.targets.get(target)
    }

    /// All targets that failed at their last try.
    pub fn failing(&self) -> impl Iterator<Item = (&String, &Entry)> {
        self.targets.iter().filter(|(_, entry)| entry.failing())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Half;

    impl Chance for Half {
        fn unit(&self) -> f64 {
            0.5
        }

        fn uuid(&self) -> String {
            String::new()
        }
    }

    #[tokio::test(start_paused = true)]
    async fn tries_count_on_after_a_success_and_are_forgotten_after_ten_minutes() {
        let mut backoff = Backoff::default();
        let wall = Timestamp::UNIX_EPOCH;
        backoff.failed("component/A0", Some("s"), "no", &Half, wall);
        assert_eq!(backoff.blocked_but(None)["component/A0"], "no");
        tokio::time::advance(Duration::from_millis(501)).await;
        assert!(backoff.blocked_but(None).is_empty());
        let again = backoff.failed("component/A0", Some("s"), "no", &Half, wall);
        assert_eq!(again, Duration::from_secs(1));
        backoff.succeeded("component/A0");
        assert!(backoff.blocked_but(None).is_empty());
        assert!(backoff.next(Instant::now()).is_none());
        tokio::time::advance(RESET_AFTER).await;
        backoff.tidy();
        assert!(backoff.get("component/A0").is_none());
    }

    /// A plan takes its time: what it was made without may be due before anybody rests.
    #[tokio::test(start_paused = true)]
    async fn what_becomes_due_after_a_plan_was_begun_is_not_slept_through() {
        let mut backoff = Backoff::default();
        let delay = backoff.failed("component/A0", None, "no", &Half, Timestamp::UNIX_EPOCH);
        let planned = Instant::now();
        tokio::time::advance(delay + Duration::from_millis(30)).await;
        assert_eq!(backoff.next(planned), Some(planned + delay));
        assert_eq!(backoff.next(Instant::now()), None);
    }

    #[tokio::test(start_paused = true)]
    async fn a_new_generation_frees_only_its_system() {
        let mut backoff = Backoff::default();
        for (target, system) in [("component/A0", "a"), ("component/B0", "b")] {
            backoff.failed(target, Some(system), "no", &Half, Timestamp::UNIX_EPOCH);
        }
        let as_then = backoff.blocked_but(Some("a"));
        backoff.forget_system("a");
        assert_eq!(backoff.blocked_but(None), as_then);
        assert_eq!(as_then.into_keys().collect::<Vec<_>>(), ["component/B0"]);
    }
}
