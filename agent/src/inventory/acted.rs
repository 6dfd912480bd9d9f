//! After steps that the agent has carried out itself, the managers are asked a little later: whoever ordered them looks at
//! once, and one look is enough.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use tokio::sync::Notify;
use tokio::time::sleep;

use crate::agent::Agent;

/// From a step to a look at what has become of it.
const SOON: Duration = Duration::from_millis(10);
/// The same while a batch runs, of whose steps whoever ordered them is told one by one. No more heartbeats are sent.
const WHILE_IT_RUNS: Duration = Duration::from_millis(50);

/// Rings when something was done that the inventory may not show yet.
#[derive(Debug, Default)]
pub(crate) struct Acted {
    bell: Notify,
    /// Rounds of questions that had begun when it rang last.
    begun: AtomicU64,
}

impl Acted {
    /// Waits until it rings.
    pub async fn rung(&self) {
        self.bell.notified().await;
    }
}

impl Agent {
    /// Something was done that the inventory may not show yet.
    pub fn has_acted(&self) {
        let begun = self.inventory.begun.load(Ordering::SeqCst);
        self.acted.begun.store(begun, Ordering::SeqCst);
        self.acted.bell.notify_one();
    }

    /// Waits for a moment after something was done, but not when something has changed of itself. True when nobody has
    /// looked since.
    pub async fn is_unseen_soon(&self) -> bool {
        let pause = match self.batches.is_running() {
            true => WHILE_IT_RUNS,
            false => SOON,
        };
        tokio::select! {
            biased;
            () = self.dirty.notified() => return true,
            () = sleep(pause) => {}
        }
        self.inventory.ended.load(Ordering::SeqCst) <= self.acted.begun.load(Ordering::SeqCst)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use tokio::time::Instant;

    use super::*;
    use crate::fixtures::agent;

    #[tokio::test(start_paused = true)]
    async fn who_looks_in_the_meantime_spares_a_look() {
        let home = tempfile::tempdir_in("/tmp").unwrap();
        let agent = agent(home.path()).await;
        agent.has_acted();
        agent.acted.rung().await;
        let begin = Instant::now();
        assert!(agent.is_unseen_soon().await);
        assert_eq!(begin.elapsed(), SOON);
        agent.has_acted();
        let looks = Arc::clone(&agent);
        let look = tokio::spawn(async move { looks.observe().await });
        assert!(!agent.is_unseen_soon().await);
        look.await.unwrap();
        // What was done after the look began is not in it for certain.
        agent.has_acted();
        assert!(agent.is_unseen_soon().await);
    }

    #[tokio::test(start_paused = true)]
    async fn what_changes_of_itself_is_looked_at_at_once() {
        let home = tempfile::tempdir_in("/tmp").unwrap();
        let agent = agent(home.path()).await;
        agent.has_acted();
        agent.dirty.notify_one();
        let begin = Instant::now();
        assert!(agent.is_unseen_soon().await);
        assert_eq!(begin.elapsed(), Duration::ZERO);
    }
}
