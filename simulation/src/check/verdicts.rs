//! What was broken, when, and why it is wrong.

use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;

/// Most violations that are kept: those after the first mostly follow from it.
const MOST: usize = 100;

/// An invariant that did not hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// Time of the run.
    pub at: Duration,
    /// Name of the invariant.
    pub invariant: &'static str,
    /// What it is about (`component Sine0 of hello on node1`).
    pub subject: String,
    /// What happened, and why it must not.
    pub what: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            at,
            invariant,
            subject,
            what,
        } = self;
        let seconds = at.as_secs_f64();
        write!(f, "at {seconds:.3} s, {invariant}: {subject}: {what}")
    }
}

/// All violations of a run, the first one first. Clones are the same list.
#[derive(Clone, Default)]
pub struct Verdicts(Arc<Inner>);

#[derive(Default)]
struct Inner {
    list: Mutex<Vec<Violation>>,
    rings: Notify,
}

impl Verdicts {
    /// An invariant does not hold.
    pub fn add(&self, violation: Violation) {
        let mut list = self.list();
        if list.len() < MOST {
            list.push(violation);
        }
        drop(list);
        self.0.rings.notify_waiters();
    }

    /// The first violation.
    pub fn first(&self) -> Option<Violation> {
        self.list().first().cloned()
    }

    /// All of them.
    pub fn all(&self) -> Vec<Violation> {
        self.list().clone()
    }

    /// Waits for the first violation. It may never come.
    pub async fn broken(&self) -> Violation {
        loop {
            let rings = self.0.rings.notified();
            if let Some(first) = self.first() {
                return first;
            }
            rings.await;
        }
    }

    fn list(&self) -> MutexGuard<'_, Vec<Violation>> {
        self.0.list.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn the_first_violation_wakes_who_waits_and_says_all() {
        let verdicts = Verdicts::default();
        let other = verdicts.clone();
        let waits = tokio::spawn(async move { other.broken().await });
        tokio::task::yield_now().await;
        for subject in ["a", "b"] {
            verdicts.add(Violation {
                at: Duration::from_millis(1_500),
                invariant: "one-incarnation",
                subject: subject.to_owned(),
                what: "runs twice".to_owned(),
            });
        }
        let first = waits.await.unwrap();
        assert_eq!(
            first.to_string(),
            "at 1.500 s, one-incarnation: a: runs twice"
        );
        assert_eq!(verdicts.all().len(), 2);
        assert_eq!(verdicts.broken().await, first);
    }
}
