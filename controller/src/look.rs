//! Looking at all nodes: for the loop, and for readers who want counters as of now.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use futures_util::FutureExt;
use rts_plan::observed::{NodeObserved, Observed};

use crate::core::Core;
use crate::ledger::Standing;
use crate::observe::{self, Target};

impl Core {
    /// Asks all agents now, and shows what they say.
    pub async fn observe(self: &Arc<Self>) -> Observed {
        let observed = self.look(Duration::ZERO).await;
        self.saw(observed.clone());
        observed
    }

    /// What is there: as agents have told it, when all of it was told within `age`; the others are asked now.
    pub(crate) async fn look(self: &Arc<Self>, age: Duration) -> Observed {
        let mut targets: BTreeMap<String, Target> = BTreeMap::new();
        let mut questions = BTreeMap::new();
        for node in self.nodes_of_old() {
            let why = format!("the agent of node {node} has not greeted this controller yet");
            targets.insert(node, Target::Silent(why));
        }
        let standings = Standing::all(self);
        for (node, entry) in self.sessions.all() {
            let standing = standings.get(&node);
            let fenced = standing.and_then(|standing| standing.message(self, &node));
            let target = if entry.lost {
                let seen = entry.session.seen;
                Target::Silent(format!("node {node} has sent no heartbeat since {seen:.0}"))
            } else if let Some(why) = fenced {
                Target::Silent(why)
            } else if let Some(inventory) = entry.current(age) {
                Target::Told(Arc::clone(inventory))
            } else {
                questions.insert(node.clone(), entry.question());
                let (core, name, session) = (Arc::clone(self), node.clone(), entry.session.id);
                let lost = async move { core.sessions.ended(&name, &session).await };
                Target::Agent(entry.session.agent, lost.boxed())
            };
            targets.insert(node, target);
        }
        let mut observed = observe::observe(targets, observe::DEADLINE).await;
        for (node, question) in &questions {
            match observed.nodes.get_mut(node) {
                Some(NodeObserved::Known(inventory)) => {
                    self.sessions.observed(node, question, Ok(inventory));
                }
                Some(NodeObserved::Unknown { reason }) => {
                    self.sessions.observed(node, question, Err(reason));
                }
                None => {}
            }
        }
        observed
    }

    /// Nodes that stored systems ran on, or that were told something.
    fn nodes_of_old(&self) -> BTreeSet<String> {
        let registry = self.registry();
        let ran = registry.systems.values().flat_map(|record| &record.nodes);
        ran.chain(registry.nodes.keys()).cloned().collect()
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
            world.silence.seen(&observed);
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
