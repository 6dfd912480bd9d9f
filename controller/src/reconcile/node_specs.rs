//! Gives every node its whole NodeSpec before any step. An agent takes steps for it as soon as it counts there; only when
//! it is durable there, the node is told.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use futures_util::StreamExt;
use futures_util::stream;
use rts_agent_api::messages::NodeSpecEnvelope;
use rts_agent_api::{ClientError, Saving};
use rts_host::timing::TARGET;
use rts_plan::Placed;
use rts_plan::desired::{Desired, NodeSpec};
use tokio::task::JoinSet;
use tracing::{Instrument, info_span};

use crate::admit;
use crate::core::Core;
use crate::fault::{Fault, Faults};
use crate::fleet::{AT_ONCE, Agent};
use crate::ledger::fence;
use crate::ledger::settle::settled;
use crate::node_numbers::Number;
use crate::placement::Placement;
use crate::sessions::Lost;

/// Time for an agent to store a NodeSpec.
const DEADLINE: Duration = Duration::from_secs(5);

/// What each agent is known to have taken, and stored.
pub struct NodeSpecs {
    core: Arc<Core>,
    /// Node → session and generation for which its agent takes steps.
    taken: Taken,
    /// Node → session and generation that its agent has acknowledged as durable.
    acked: Taken,
    /// What is being made durable.
    saving: JoinSet<Saved>,
    /// Node → digest of the spec that it is to have by what is desired now. A node that was away when the others were told
    /// may be back with the spec of before.
    wanted: BTreeMap<String, String>,
    /// Nodes whose number is just being made durable: nothing can be done there before.
    unnumbered: BTreeSet<String>,
}

/// What is to be done about the spec of a node.
enum Prepared {
    /// It is to be sent.
    Send(Box<Sending>),
    /// Its number is being made durable, and the end of that wakes the loop.
    Unnumbered,
    /// Nothing.
    Nothing,
}

/// Node → session and generation.
type Taken = BTreeMap<String, (String, u64)>;

/// What came of an agent's making a spec durable.
struct Saved {
    node: String,
    session: String,
    generation: u64,
    answer: Result<(), Fault>,
}

struct Sending {
    node: String,
    session: String,
    agent: Arc<dyn Agent>,
    envelope: NodeSpecEnvelope,
}

impl NodeSpecs {
    /// Nothing is known yet.
    pub fn new(core: Arc<Core>) -> Self {
        Self {
            core,
            taken: BTreeMap::new(),
            acked: BTreeMap::new(),
            saving: JoinSet::new(),
            wanted: BTreeMap::new(),
            unnumbered: BTreeSet::new(),
        }
    }

    /// Nodes that nothing can be asked of until their number is durable.
    pub fn unnumbered(&self) -> &BTreeSet<String> {
        &self.unnumbered
    }

    /// The generation for which an agent takes steps, when that is the newest.
    pub fn taken(&self, node: &str, session: &str) -> Option<u64> {
        self.newest(&self.taken, node, session)
    }

    /// The generation that is durable in an agent's ledger, when that is the newest.
    pub fn acked(&self, node: &str, session: &str) -> Option<u64> {
        self.newest(&self.acked, node, session)
    }

    fn newest(&self, of: &Taken, node: &str, session: &str) -> Option<u64> {
        let (by, generation) = of.get(node)?;
        let registry = self.core.registry();
        let newest = registry.nodes.get(node)?;
        let wanted = self.wanted.get(node);
        let is_wanted = wanted.is_none_or(|wanted| *wanted == newest.digest);
        (by == session && *generation == newest.generation && is_wanted).then_some(*generation)
    }

    /// Systems, by uid, of which a node that can be told has not stored the newest spec.
    pub fn untold(&self, desired: &Desired, faults: &Faults) -> BTreeSet<String> {
        let sessions = self.core.sessions.all();
        let open = desired.nodes.iter().filter(|(node, _)| {
            let live = sessions.get(*node).filter(|entry| !entry.lost);
            let told = |id: &str| self.acked(node, id).is_some();
            !faults.contains_key(*node) && live.is_some_and(|entry| !told(&entry.session.id))
        });
        let parts = open.flat_map(|(_, spec)| &spec.systems);
        parts.map(|part| part.system.uid.clone()).collect()
    }

    /// Remembers, durably, on which nodes each system runs, before anything is sent there. A node that nobody knows runs
    /// nothing: a system's end does not need its word.
    pub async fn note_nodes(&self, placed: &Placed) {
        let mut changed = Vec::new();
        {
            let greeted = self.core.sessions.all();
            let registry = self.core.registry();
            for record in registry.systems.values() {
                let nodes = placed.desired.nodes.iter();
                let now: Vec<&String> = nodes
                    .filter(|(_, spec)| spec.systems.iter().any(|p| p.system.uid == record.uid))
                    .map(|(node, _)| node)
                    .filter(|node| {
                        greeted.contains_key(*node) || registry.nodes.contains_key(*node)
                    })
                    .collect();
                if now.iter().any(|node| !record.nodes.contains(*node)) {
                    let mut record = record.as_ref().clone();
                    record.nodes.extend(now.into_iter().cloned());
                    changed.push(record);
                }
            }
        }
        let old = self.core.registry().systems.clone();
        for record in old.values() {
            if let Some(places) = admit::places_of_old(&self.core, placed, record) {
                let mut record = record.as_ref().clone();
                record.places = places;
                changed.push(record);
            }
        }
        for record in changed {
            let _admission = self.core.admission.lock().await;
            let present = self.core.registry().systems.get(record.name()).cloned();
            // It may have been changed or removed meanwhile; then the next round sees it.
            let Some(mut present) = present.filter(|p| p.uid == record.uid) else {
                continue;
            };
            let now = Arc::make_mut(&mut present);
            now.nodes.extend(record.nodes);
            if now.places.is_empty() && now.generation == record.generation {
                now.places = record.places;
            }
            if let Err(e) = self.core.store_system(present).await {
                tracing::error!(error = %rts_host::error::chain(&e), "a system's nodes cannot be stored");
            }
        }
    }

    /// Sends what no agent has taken yet. Gives the nodes that did not take theirs, or did not make it durable, and why.
    /// Nothing is sent to nodes that are `fenced`.
    pub async fn send(&mut self, placed: &Placement, fenced: &BTreeMap<String, String>) -> Faults {
        let mut faults = self.collect();
        let mut sendings = Vec::new();
        self.unnumbered.clear();
        let digests = placed.digests();
        for (node, spec) in &placed.desired.nodes {
            if fenced.contains_key(node) {
                self.taken.remove(node);
                self.acked.remove(node);
                continue;
            }
            let Some(digest) = digests.get(node) else {
                continue;
            };
            if self.wanted.get(node) != Some(digest) {
                self.wanted.insert(node.clone(), digest.clone());
            }
            // It is sent anew the next time.
            if faults.contains_key(node) {
                continue;
            }
            match self.prepare(node, spec, digest).await {
                Ok(Prepared::Send(sending)) => sendings.push(*sending),
                Ok(Prepared::Unnumbered) => drop(self.unnumbered.insert(node.clone())),
                Ok(Prepared::Nothing) => {}
                Err(reason) => drop(faults.insert(node.clone(), Fault::refused(reason))),
            }
        }
        let core = Arc::clone(&self.core);
        let offers = sendings.into_iter().map(|sending| offer(&core, sending));
        let mut answers = stream::iter(offers).buffer_unordered(AT_ONCE);
        while let Some((sending, answer)) = answers.next().await {
            match answer {
                Ok(saving) => {
                    // What it told before says nothing about the new spec.
                    core.sessions.doubt(&sending.node);
                    let taken = (sending.session.clone(), sending.envelope.generation);
                    self.taken.insert(sending.node.clone(), taken);
                    self.saving.spawn(saved(Arc::clone(&core), sending, saving));
                }
                Err(fault) => {
                    tracing::warn!(
                        node = sending.node,
                        reason = fault.reason,
                        "node spec not taken"
                    );
                    faults.insert(sending.node, fault);
                }
            }
        }
        // Where nothing had to be waited for, it is told at once.
        faults.extend(self.collect());
        faults
    }

    /// Takes in what was made durable. Gives the nodes whose agents could not, and why.
    fn collect(&mut self) -> Faults {
        let mut faults = Faults::new();
        while let Some(joined) = self.saving.try_join_next() {
            let Ok(saved) = joined else { continue };
            let (node, taken) = (saved.node, (saved.session, saved.generation));
            match saved.answer {
                Ok(()) => drop(self.acked.insert(node, taken)),
                Err(fault) if self.taken.get(&node) == Some(&taken) => {
                    tracing::warn!(node, reason = fault.reason, "node spec not stored");
                    self.taken.remove(&node);
                    faults.insert(node, fault);
                }
                // It was replaced meanwhile.
                Err(_) => {}
            }
        }
        faults
    }

    /// What is to be sent to a node; nothing when it has it, cannot be reached, or never ran anything.
    async fn prepare(&self, node: &str, spec: &NodeSpec, digest: &str) -> Result<Prepared, String> {
        let Some(number) = self.core.number_of(node, spec, digest) else {
            return Ok(Prepared::Nothing);
        };
        let given = match number {
            Number::Given(given) => given,
            Number::New(given) => {
                let span = info_span!(target: TARGET, "store", of = format!("node/{node}"));
                let given = self.core.give_number(node, given).instrument(span).await;
                given.map_err(|e| rts_host::error::chain(&e))?
            }
            Number::Pending => return Ok(Prepared::Unnumbered),
        };
        let Some(entry) = self.core.sessions.get(node).filter(|entry| !entry.lost) else {
            return Ok(Prepared::Nothing);
        };
        if self.taken(node, &entry.session.id).is_some() {
            return Ok(Prepared::Nothing);
        }
        Ok(Prepared::Send(Box::new(Sending {
            node: node.to_owned(),
            session: entry.session.id,
            agent: entry.session.agent,
            envelope: NodeSpecEnvelope {
                cluster_uid: self.core.cluster_uid.clone(),
                epoch: given.epoch,
                generation: given.generation,
                digest: digest.to_owned(),
                take_over: entry.session.claim,
                spec: spec.clone(),
            },
        })))
    }
}

/// Sends one node's spec and waits until it counts there, or its agent is lost.
async fn offer(core: &Core, sending: Sending) -> (Sending, Result<Saving, Fault>) {
    let offered = sending.agent.offer_node_spec(&sending.envelope);
    let span = info_span!(target: TARGET, "send", of = format!("node/{}", sending.node));
    let answer = within(core, &sending, offered.instrument(span)).await;
    (sending, answer)
}

/// Waits until a spec is durable on its node, and then says so.
async fn saved(core: Arc<Core>, sending: Sending, saving: Saving) -> Saved {
    let answer = within(&core, &sending, saving).await.map(drop);
    if answer.is_ok() {
        let ledger = fence(&sending.envelope);
        core.sessions
            .stored(&sending.node, &sending.session, ledger);
        settled(&core, &sending.node).await;
    }
    core.wake.notify_one();
    Saved {
        node: sending.node,
        session: sending.session,
        generation: sending.envelope.generation,
        answer,
    }
}

async fn within<T>(
    core: &Core,
    sending: &Sending,
    work: impl Future<Output = Result<T, ClientError>>,
) -> Result<T, Fault> {
    let work = tokio::time::timeout(DEADLINE, work);
    let work = core
        .sessions
        .while_live(&sending.node, &sending.session, work);
    match work.await {
        Ok(Ok(Ok(done))) => Ok(done),
        Ok(Ok(Err(e @ ClientError::Problem(_)))) => Err(Fault::refused(format!(
            "its agent refused the node's spec: {e}"
        ))),
        Ok(Ok(Err(e))) => Err(Fault::silent(format!(
            "its agent did not take the node's spec: {e}"
        ))),
        Ok(Err(_)) => Err(Fault::silent(format!(
            "its agent did not store the node's spec within {} s",
            DEADLINE.as_secs()
        ))),
        Err(Lost) => Err(Fault::silent("its agent was lost")),
    }
}
