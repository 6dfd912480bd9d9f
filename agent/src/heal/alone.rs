//! What the agent did alone, and plans that know nothing of it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rts_agent_api::messages::Seen;
use rts_http::problem::Problem;

use crate::agent::Agent;

/// Revision of the inventory upon which the agent acted alone last; 0 when it never did.
#[derive(Debug, Default)]
pub(crate) struct Alone(AtomicU64);

impl Alone {
    /// The agent acts upon what it saw.
    pub fn acts(&self, revision: u64) {
        self.0.fetch_max(revision, Ordering::SeqCst);
    }

    fn last(&self) -> u64 {
        self.0.load(Ordering::SeqCst)
    }
}

impl Agent {
    /// Refuses what was planned from an inventory that is not so any more since this agent acted alone, or that an
    /// earlier agent of this node told: such a plan cuts and stops what has been mended since.
    pub(crate) async fn refuse_outdated(self: &Arc<Self>, seen: &Seen) -> Result<(), Problem> {
        let refused = |what: String| {
            let detail = format!("the batch was planned from {what}: plan again");
            Err(Problem::conflict("stale-inventory", detail))
        };
        if seen.session != self.session {
            return refused("what an earlier agent of this node told".to_owned());
        }
        if seen.revision > self.alone.last() {
            return Ok(());
        }
        // What it did may have come to nothing.
        let now = self.observe().await.revision;
        if now == seen.revision {
            return Ok(());
        }
        refused(format!(
            "inventory {}; the agent has acted alone since, and has inventory {now}",
            seen.revision
        ))
    }
}
