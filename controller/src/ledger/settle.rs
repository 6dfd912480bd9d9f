//! Brings the store and the ledgers of agents together, where the store was restored or rolled back: what is newer wins.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use rts_agent_api::messages::{LedgerFence, NodeSpecEnvelope};
use tokio::task::JoinSet;

use super::import::{self, Import};
use super::{Standing, fence};
use crate::core::Core;
use crate::sessions::NodeEntry;
use crate::store::{NodeGeneration, StoreError, Write};
use crate::view::Happening;

/// Time for an agent to say what its ledger holds.
const DEADLINE: Duration = Duration::from_secs(5);

/// Settles each node in a task of its own: an agent that does not answer holds up nobody but its node.
pub struct Settling {
    core: Arc<Core>,
    tasks: JoinSet<(String, Result<(), String>)>,
    /// Nodes with a task.
    busy: BTreeSet<String>,
    /// Why the last attempt failed, by node.
    failed: BTreeMap<String, String>,
}

impl Settling {
    /// Nothing is settled yet.
    pub fn new(core: Arc<Core>) -> Self {
        Self {
            core,
            tasks: JoinSet::new(),
            busy: BTreeSet::new(),
            failed: BTreeMap::new(),
        }
    }

    /// Begins to settle what can be settled. Gives the nodes to which nothing may be sent, and why.
    pub fn settle(&mut self) -> BTreeMap<String, String> {
        self.collect();
        let mut fenced = BTreeMap::new();
        for (node, standing) in Standing::all(&self.core) {
            let Some(message) = standing.message(&self.core, &node) else {
                self.failed.remove(&node);
                continue;
            };
            let reason = self.begin(&node, standing).unwrap_or(message);
            fenced.insert(node, reason);
        }
        for node in &self.busy {
            let doing = || "its ledger is being taken in".to_owned();
            fenced.entry(node.clone()).or_insert_with(doing);
        }
        fenced
    }

    fn collect(&mut self) {
        while let Some(joined) = self.tasks.try_join_next() {
            let Ok((node, result)) = joined else { continue };
            self.busy.remove(&node);
            match result {
                Ok(()) => drop(self.failed.remove(&node)),
                Err(reason) => {
                    tracing::warn!(
                        node,
                        reason,
                        "the node's ledger is newer and cannot be taken in"
                    );
                    self.failed.insert(node, reason);
                }
            }
        }
        if self.tasks.is_empty() {
            self.busy.clear();
        }
    }

    /// Begins to settle a node, where that can be done and is not being done. Gives why it failed the last time.
    fn begin(&mut self, node: &str, standing: Standing) -> Option<String> {
        let entry = self.core.sessions.get(node).filter(|entry| !entry.lost);
        let (Some(entry), Standing::Overtaken(_) | Standing::Ahead(_)) = (entry, &standing) else {
            self.failed.remove(node);
            return None;
        };
        let failed = self.failed.get(node).cloned();
        if !self.busy.insert(node.to_owned()) {
            return failed;
        }
        let (core, node) = (Arc::clone(&self.core), node.to_owned());
        self.tasks.spawn(async move {
            let result = match standing {
                Standing::Overtaken(ledger) => overtake(&core, &node, &entry, &ledger).await,
                Standing::Ahead(ledger) => adopt(&core, &node, &entry, &ledger).await,
                _ => Ok(()),
            };
            // A failure is tried again with the next tick.
            if result.is_ok() {
                core.wake.notify_one();
            }
            (node, result)
        });
        failed
    }
}

/// A restored store goes above every epoch that an agent has seen.
async fn overtake(
    core: &Core,
    node: &str,
    entry: &NodeEntry,
    ledger: &LedgerFence,
) -> Result<(), String> {
    let epoch = ledger.epoch.saturating_add(1);
    let raised = core.raise_epoch(epoch).await;
    raised.map_err(|e| rts_host::error::chain(&e))?;
    let message = format!(
        "epoch raised to {epoch}: node {node} had seen {}",
        ledger.epoch
    );
    core.record(Happening::normal(
        "EpochRaised",
        &format!("node/{node}"),
        message,
    ));
    match Standing::get(core, node) {
        Standing::Ahead(ledger) => adopt(core, node, entry, &ledger).await,
        _ => Ok(()),
    }
}

/// The ledger is newer: its systems are taken in, and those that it no longer has are dropped.
async fn adopt(
    core: &Core,
    node: &str,
    entry: &NodeEntry,
    ledger: &LedgerFence,
) -> Result<(), String> {
    let envelope = fetch(core, node, entry).await?;
    if fence(&envelope) != *ledger {
        core.sessions
            .stored(node, &entry.session.id, fence(&envelope));
        return Err(format!(
            "the ledger of node {node} has changed; looking again"
        ));
    }
    let _admission = core.admission.lock().await;
    let stored = core.registry().systems.clone();
    let restored = core.registry().restored.clone();
    let said = restored.map_or_else(BTreeSet::new, |restored| restored.said);
    let (placed, now) = (core.place(None), core.clock.now());
    let import = import::replace(&stored, &placed, &envelope.spec, &said, now);
    let placed = core.place_all(&import.records);
    let disturbed = import::disturbed(&import, &placed, &envelope.spec);
    if !disturbed.is_empty() {
        return Err(format!(
            "the ledger of node {node} is newer than this store, and to take it in would restart {}: nothing is sent \
             there; tear down what is in its way, or restore with --take-over",
            disturbed.join(", ")
        ));
    }
    let generation = NodeGeneration {
        epoch: ledger.epoch,
        generation: ledger.generation,
        digest: ledger.digest.clone(),
    };
    let more = vec![Write::PutNode(node.to_owned(), generation)];
    let stored = commit(core, node, import, more).await;
    stored.map_err(|e| rts_host::error::chain(&e))
}

/// What an agent's ledger holds now.
pub async fn fetch(core: &Core, node: &str, entry: &NodeEntry) -> Result<NodeSpecEnvelope, String> {
    let asked = tokio::time::timeout(DEADLINE, entry.session.agent.node_spec());
    let asked = core.sessions.while_live(node, &entry.session.id, asked);
    let envelope = match asked.await {
        Ok(Ok(Ok(envelope))) => envelope,
        Ok(Ok(Err(e))) => return Err(format!("its agent does not tell its ledger: {e}")),
        Ok(Err(_)) => {
            let seconds = DEADLINE.as_secs();
            return Err(format!(
                "its agent did not tell its ledger within {seconds} s"
            ));
        }
        Err(_) => return Err("its agent was lost".to_owned()),
    };
    // Its digest is of the text that its agent checked: another version may write the same in other words.
    if envelope.spec.node != node {
        return Err("its agent tells the ledger of another node".to_owned());
    }
    Ok(envelope)
}

/// Stores what was taken in, all of it or nothing, and tells. The caller holds [`Core::admission`].
pub async fn commit(
    core: &Core,
    node: &str,
    mut import: Import,
    more: Vec<Write>,
) -> Result<(), StoreError> {
    let stored = core.registry().systems.clone();
    let mut writes = more;
    let records = import.records.values_mut();
    let changed = records.filter(|record| stored.get(record.name()) != Some(&**record));
    writes.extend(
        changed
            .map(|record| core.number(Arc::make_mut(record)))
            .last(),
    );
    writes.extend(import.writes(&stored));
    core.store.write(writes.clone()).await?;
    {
        let mut registry = core.registry();
        registry.systems.clone_from(&import.records);
        for write in writes {
            if let Write::PutNode(node, generation) = write {
                registry.nodes.insert(node, generation);
            }
        }
    }
    for name in &import.dropped {
        core.backoff().forget_system(name);
        let message = format!("it was taken down on node {node} after the store was backed up");
        let event = Happening::warning("TornDownSinceBackup", &format!("system/{name}"), message);
        core.record(event.of(Some(name)));
    }
    for name in &import.adopted {
        core.backoff().forget_system(name);
        let message = format!("taken in as it runs on node {node}");
        let event = Happening::normal("Adopted", &format!("system/{name}"), message);
        core.record(event.of(Some(name)));
    }
    core.desired_changed();
    Ok(())
}

/// A node's ledger was written in this store's name: nothing of before its restore is left there.
pub async fn settled(core: &Core, node: &str) {
    if core.registry().restored.is_none() {
        return;
    }
    let _admission = core.admission.lock().await;
    let restored = core.registry().restored.clone();
    let open = restored.filter(|restored| !restored.settled.contains(node));
    let Some(mut restored) = open else { return };
    restored.settled.insert(node.to_owned());
    let written = core
        .store
        .write(vec![Write::Restored(Some(restored.clone()))])
        .await;
    match written {
        Ok(()) => core.registry().restored = Some(restored),
        Err(e) => {
            tracing::error!(error = %rts_host::error::chain(&e), "a settled node cannot be stored");
        }
    }
}
