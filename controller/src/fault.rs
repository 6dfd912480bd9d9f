//! Why a node did not take what it was given, and whether that may pass.

use std::collections::BTreeMap;
use std::time::Duration;

use tokio::time::Instant;

/// So long a node that was there a moment ago is waited for before anybody calls its silence the end of an apply: agents
/// on a busy machine miss heartbeats and come back, and one that is restarted greets within this time.
pub const PATIENCE: Duration = Duration::from_secs(10);

/// Why a node did not take its NodeSpec or its steps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// For people.
    pub reason: String,
    /// It did not say no: it was silent, or lost.
    silent: bool,
    /// Since when something is wrong with the node.
    since: Instant,
}

/// By node.
pub type Faults = BTreeMap<String, Fault>;

impl Fault {
    /// Its agent, or the controller, refuses: the next try ends alike.
    pub fn refused(reason: impl Into<String>) -> Self {
        Self {
            reason: reason.into(),
            silent: false,
            since: Instant::now(),
        }
    }

    /// Its agent did not answer, or was lost: the next try may well succeed.
    pub fn silent(reason: impl Into<String>) -> Self {
        Self {
            silent: true,
            ..Self::refused(reason)
        }
    }

    /// True while it is expected to pass by itself.
    pub fn may_pass(&self) -> bool {
        self.silent && self.since.elapsed() < PATIENCE
    }
}

/// The faults of now: one that follows another of its node is as old as that.
pub fn aged(mut now: Faults, before: &Faults) -> Faults {
    for (node, fault) in &mut now {
        if let Some(before) = before.get(node) {
            fault.since = before.since;
        }
    }
    now
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn silence_passes_for_a_while_and_a_refusal_does_not() {
        let node = |fault| Faults::from([("arm".to_owned(), fault)]);
        let first = node(Fault::silent("its agent was lost"));
        assert!(first["arm"].may_pass());
        assert!(!Fault::refused("the disk is full").may_pass());
        tokio::time::advance(PATIENCE / 2).await;
        let second = aged(node(Fault::silent("it did not answer")), &first);
        assert!(second["arm"].may_pass());
        tokio::time::advance(PATIENCE / 2).await;
        let third = aged(node(Fault::silent("it did not answer")), &second);
        assert!(!third["arm"].may_pass(), "it is one silence");
        assert!(Fault::silent("another one").may_pass());
    }
}
