//! Looking at all nodes: for the loop, and for readers who want counters as of now.

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};

use futures_util::FutureExt;
use rts_plan::observed::{NodeObserved, Observed};

use crate::core::Core;
use crate::observe::{self, Target};

impl Core {
    /// Asks all agents now, and shows what they say.
    pub async fn observe(&self) -> Observed {
        let observed = self.ask().await;
        self.saw(observed.clone());
        observed
    }

    /// Asks all agents now.
    pub(crate) async fn ask(&self) -> Observed {
        let sessions = self.sessions.all();
        let mut targets: BTreeMap<String, Target> = BTreeMap::new();
        {
            let registry = self.registry();
            let ran = registry.systems.values().flat_map(|record| &record.nodes);
            for node in ran.chain(registry.nodes.keys()) {
                let why = format!("the agent of node {node} has not greeted this controller yet");
                targets.insert(node.clone(), Target::Silent(why));
            }
        }
        for (node, entry) in sessions {
            let target = if entry.lost {
                let seen = entry.session.seen;
                Target::Silent(format!("node {node} has sent no heartbeat since {seen:.0}"))
            } else {
                Target::Agent(entry.session.agent)
            };
            targets.insert(node, target);
        }
        let observed = observe::observe(targets, observe::DEADLINE).await;
        for (node, answer) in &observed.nodes {
            match answer {
                NodeObserved::Known(inventory) => self.sessions.observed(node, Ok(inventory)),
                NodeObserved::Unknown { reason } => self.sessions.observed(node, Err(reason)),
            }
        }
        observed
    }

    /// Brings the view up to date. Callers at the same time share one observation.
    pub async fn refresh(self: &Arc<Self>) {
        let shared = {
            let mut slot = self.refresh.lock().unwrap_or_else(PoisonError::into_inner);
            match slot.as_ref().filter(|f| f.peek().is_none()) {
                Some(running) => running.clone(),
                None => {
                    let core = Arc::clone(self);
                    let work = async move {
                        core.observe().await;
                    };
                    let shared = work.boxed().shared();
                    *slot = Some(shared.clone());
                    shared
                }
            }
        };
        shared.await;
    }

    /// Keeps and shows an observation; wakes the loop when it brings more than counters.
    fn saw(&self, observed: Observed) {
        let news = {
            let mut world = self.world();
            let news = revisions(&world.observed) != revisions(&observed);
            world.observed = observed;
            world.stale |= news;
            news
        };
        self.publish();
        if news {
            self.wake.notify_one();
        }
    }
}

/// Inventory revision of each node that answered.
fn revisions(observed: &Observed) -> BTreeMap<&str, Option<u64>> {
    let nodes = observed.nodes.iter();
    nodes
        .map(|(node, answer)| match answer {
            NodeObserved::Known(inventory) => (node.as_str(), Some(inventory.revision)),
            NodeObserved::Unknown { .. } => (node.as_str(), None),
        })
        .collect()
}
