//! Gives every node its whole NodeSpec before any step: with a generation that is durable before it is sent.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use futures_util::future::join_all;
use rts_agent_api::messages::NodeSpecEnvelope;
use rts_host::timing::TARGET;
use rts_plan::Placed;
use rts_plan::desired::{Desired, NodeSpec};
use tracing::{Instrument, info_span};

use crate::admit;
use crate::core::Core;
use crate::fleet::Agent;
use crate::ledger::fence;
use crate::ledger::settle::settled;
use crate::sessions::Lost;

/// Time for an agent to store a NodeSpec.
const DEADLINE: Duration = Duration::from_secs(5);

/// What each agent is known to have stored.
pub struct NodeSpecs {
    core: Arc<Core>,
    /// Node → session and generation that its agent acknowledged.
    acked: BTreeMap<String, (String, u64)>,
    /// Node → digest of the spec that it is to have by what is desired now. A node that was away when the others were told
    /// may be back with the spec of before.
    wanted: BTreeMap<String, String>,
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
            acked: BTreeMap::new(),
            wanted: BTreeMap::new(),
        }
    }

    /// The generation that an agent's ledger holds, when that is the newest.
    pub fn acked(&self, node: &str, session: &str) -> Option<u64> {
        let (by, generation) = self.acked.get(node)?;
        let registry = self.core.registry();
        let newest = registry.nodes.get(node)?;
        let wanted = self.wanted.get(node);
        let is_wanted = wanted.is_none_or(|wanted| *wanted == newest.digest);
        (by == session && *generation == newest.generation && is_wanted).then_some(*generation)
    }

    /// Systems, by uid, of which a node that can be told has not stored the newest spec.
    pub fn untold(&self, desired: &Desired, faults: &BTreeMap<String, String>) -> BTreeSet<String> {
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
                    let mut record = record.clone();
                    record.nodes.extend(now.into_iter().cloned());
                    changed.push(record);
                }
            }
        }
        let old = self.core.registry().systems.clone();
        for record in old.values() {
            if let Some(places) = admit::places_of_old(&self.core, placed, record) {
                let mut record = record.clone();
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
            present.nodes.extend(record.nodes);
            if present.places.is_empty() && present.generation == record.generation {
                present.places = record.places;
            }
            if let Err(e) = self.core.store_system(present).await {
                tracing::error!(error = %crate::chain(&e), "a system's nodes cannot be stored");
            }
        }
    }

    /// Sends what is not acknowledged yet. Gives the nodes that did not take theirs, and why.
    /// Nothing is sent to nodes that are `fenced`.
    pub async fn send(
        &mut self,
        desired: &Desired,
        fenced: &BTreeMap<String, String>,
    ) -> BTreeMap<String, String> {
        let mut faults = BTreeMap::new();
        let mut sendings = Vec::new();
        for (node, spec) in &desired.nodes {
            if fenced.contains_key(node) {
                self.acked.remove(node);
                continue;
            }
            let digest = rts_plan::digest(spec);
            self.wanted.insert(node.clone(), digest.clone());
            match self.prepare(node, spec, digest).await {
                Ok(sending) => sendings.extend(sending),
                Err(reason) => drop(faults.insert(node.clone(), reason)),
            }
        }
        let core = Arc::clone(&self.core);
        let puts = sendings.into_iter().map(|sending| put(&core, sending));
        for (sending, answer) in join_all(puts).await {
            match answer {
                Ok(()) => {
                    let ledger = fence(&sending.envelope);
                    self.core
                        .sessions
                        .stored(&sending.node, &sending.session, ledger);
                    settled(&self.core, &sending.node).await;
                    // What it told before says nothing about the new spec.
                    self.core.sessions.doubt(&sending.node);
                    let acked = (sending.session, sending.envelope.generation);
                    self.acked.insert(sending.node, acked);
                }
                Err(reason) => {
                    tracing::warn!(node = sending.node, reason, "node spec not stored");
                    faults.insert(sending.node, reason);
                }
            }
        }
        faults
    }

    /// What is to be sent to a node; nothing when it has it, cannot be reached, or never ran anything.
    async fn prepare(
        &self,
        node: &str,
        spec: &NodeSpec,
        digest: String,
    ) -> Result<Option<Sending>, String> {
        let stored = self.core.registry().nodes.get(node).cloned();
        // Numbers are given out only where they are sent: a node that is away may come back with newer ones.
        let Some(entry) = self.core.sessions.get(node).filter(|entry| !entry.lost) else {
            return Ok(None);
        };
        let ledger = entry.session.ledger.as_ref();
        let own = ledger.filter(|ledger| ledger.cluster_uid == self.core.cluster_uid);
        let known = stored.is_some() || own.is_some() || entry.session.claim.is_some();
        if !known && spec.systems.is_empty() {
            return Ok(None);
        }
        let epoch = self.core.epoch();
        let mut given = stored.unwrap_or_default();
        if let Some(ledger) = own.filter(|ledger| ledger.generation > given.generation) {
            // The store wins over a newer ledger: its next number must be above what the agent has seen.
            given.generation = ledger.generation;
            given.digest.clear();
        }
        if given.digest != digest || given.epoch != epoch {
            given.generation += 1;
            given.epoch = epoch;
            given.digest.clone_from(&digest);
            let put = self.core.store.put_node(node.to_owned(), given.clone());
            let span = info_span!(target: TARGET, "store", of = format!("node/{node}"));
            put.instrument(span).await.map_err(|e| crate::chain(&e))?;
            let mut registry = self.core.registry();
            registry.nodes.insert(node.to_owned(), given.clone());
        }
        if self.acked(node, &entry.session.id).is_some() {
            return Ok(None);
        }
        Ok(Some(Sending {
            node: node.to_owned(),
            session: entry.session.id,
            agent: entry.session.agent,
            envelope: NodeSpecEnvelope {
                cluster_uid: self.core.cluster_uid.clone(),
                epoch,
                generation: given.generation,
                digest,
                take_over: entry.session.claim,
                spec: spec.clone(),
            },
        }))
    }
}

/// Sends one node's spec and waits until its agent has stored it, or is lost.
async fn put(core: &Core, sending: Sending) -> (Sending, Result<(), String>) {
    let stored = sending.agent.put_node_spec(&sending.envelope);
    let span = info_span!(target: TARGET, "send", of = format!("node/{}", sending.node));
    let stored = stored.instrument(span);
    let stored = tokio::time::timeout(DEADLINE, stored);
    let stored = core
        .sessions
        .while_live(&sending.node, &sending.session, stored);
    let answer = match stored.await {
        Ok(Ok(Ok(_))) => Ok(()),
        Ok(Ok(Err(e))) => Err(format!("its agent refused the node's spec: {e}")),
        Ok(Err(_)) => Err(format!(
            "its agent did not store the node's spec within {} s",
            DEADLINE.as_secs()
        )),
        Err(Lost) => Err("its agent was lost".to_owned()),
    };
    (sending, answer)
}
