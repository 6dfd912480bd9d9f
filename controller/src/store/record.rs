//! Records of the store.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use jiff::Timestamp;
use rts_schemas::stand_in::Shape;
use rts_schemas::system::SystemSpec;
use serde::{Deserialize, Serialize};

/// Systems by name. Shared: they are large, and looked at all the time.
pub type Records = BTreeMap<String, Arc<SystemRecord>>;

/// A stored system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SystemRecord {
    /// UUID; a system that is deleted and applied again gets a new one.
    pub uid: String,
    /// Raised by each change of the spec or of a module.
    pub generation: u64,
    /// Number of its last change, over all systems of the store: no other change ever has it, of whatever system. 0 in
    /// what an older program wrote, until [`State::number`].
    #[serde(default)]
    pub index: u64,
    /// What was applied.
    pub spec: Arc<SystemSpec>,
    /// SHA-256 of each type's module file when it was applied, by type name.
    #[serde(default)]
    pub digests: BTreeMap<String, String>,
    /// Instance → what the stand-in is made of that takes its place, as it was decided when this spec was admitted, or
    /// taken in.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub stand_ins: BTreeMap<String, Shape>,
    /// Nodes that it ever ran on; a teardown needs the word of each.
    #[serde(default)]
    pub nodes: BTreeSet<String>,
    /// When it was first applied.
    pub created: Timestamp,
    /// When its end was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deleted: Option<Timestamp>,
    /// Nodes whose word its end does not need: somebody said that they will not come back.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub forgotten: BTreeSet<String>,
    /// Instance → node that was chosen for it when this spec was admitted, or taken in.
    #[serde(default)]
    pub places: BTreeMap<String, String>,
    /// Instance → nodes that it was moved away from, or may have been while this store did not know it, and that were not
    /// seen without it since.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub left: BTreeMap<String, BTreeSet<String>>,
}

impl SystemRecord {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.spec.name
    }

    /// Puts its components onto these nodes, and remembers where else they may still run.
    pub fn settle(&mut self, places: BTreeMap<String, String>) {
        for (instance, old) in &self.places {
            if places.get(instance) != Some(old) {
                let left = self.left.entry(instance.clone()).or_default();
                left.insert(old.clone());
            }
        }
        for (instance, node) in &places {
            if let Some(left) = self.left.get_mut(instance) {
                left.remove(node);
            }
        }
        self.left.retain(|_, nodes| !nodes.is_empty());
        self.places = places;
    }
}

/// The number that guards a node's NodeSpec, and what it stands for.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct NodeGeneration {
    /// Epoch in which the number was given out.
    pub epoch: u64,
    /// Monotone over all systems of the node.
    pub generation: u64,
    /// Digest of the spec that it was given to.
    pub digest: String,
}

/// The store came from a backup: what the ledgers of agents hold may be newer than it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Restored {
    /// When.
    pub at: Timestamp,
    /// The store wins over newer ledgers; otherwise they win.
    pub take_over: bool,
    /// Nodes whose ledgers have been compared since.
    #[serde(default)]
    pub settled: BTreeSet<String>,
    /// Systems that users have applied or torn down since: no ledger of before knows better.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub said: BTreeSet<String>,
}

/// The whole store.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct State {
    /// Made once with the store.
    pub cluster_uid: String,
    /// Raised each time a store is created or restored.
    pub epoch: u64,
    /// No revision above this one was ever given out.
    pub revisions: u64,
    /// No index above this one was ever given to a change of a system.
    #[serde(default)]
    pub indexes: u64,
    /// Systems by name.
    pub systems: Records,
    /// Node generations by node.
    pub nodes: BTreeMap<String, NodeGeneration>,
    /// Set by a restore.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restored: Option<Restored>,
}

/// One change of the store.
#[derive(Debug, Clone, PartialEq)]
pub enum Write {
    /// Writes a system.
    PutSystem(Arc<SystemRecord>),
    /// Forgets a system; no error when it is not there.
    RemoveSystem(String),
    /// Writes a node's generation.
    PutNode(String, NodeGeneration),
    /// Says that revisions up to this one may have been given out. Never lowers it.
    Revisions(u64),
    /// Says that changes of systems have the indexes up to this one. Never lowers it.
    Indexes(u64),
    /// Raises the epoch.
    Epoch(u64),
    /// Says whether and how it was restored.
    Restored(Option<Restored>),
    /// Gives it another identity: a restore, into a new store.
    ClusterUid(String),
}

impl State {
    /// It is of a backup. What it says of places is of yesterday: each component may run on any node that it knows, or
    /// that the store in whose place it comes has told something.
    pub fn restore(
        &mut self,
        at: Timestamp,
        take_over: bool,
        told: impl IntoIterator<Item = String>,
    ) {
        for node in told {
            self.nodes.entry(node).or_default();
        }
        self.restored = Some(Restored {
            at,
            take_over,
            settled: BTreeSet::new(),
            said: BTreeSet::new(),
        });
        let ran = self.systems.values().flat_map(|record| &record.nodes);
        let nodes: BTreeSet<String> = ran.chain(self.nodes.keys()).cloned().collect();
        let records = self.systems.values_mut();
        for record in records.filter(|record| record.deleted.is_none()) {
            let record = Arc::make_mut(record);
            for (instance, place) in &record.places {
                let left = record.left.entry(instance.clone()).or_default();
                left.extend(nodes.iter().filter(|node| *node != place).cloned());
            }
            record.left.retain(|_, nodes| !nodes.is_empty());
        }
    }

    /// The changes that make a new store hold this.
    pub fn writes(&self) -> Vec<Write> {
        let systems = self.systems.values();
        let nodes = self.nodes.iter();
        let mut writes = vec![
            Write::ClusterUid(self.cluster_uid.clone()),
            Write::Epoch(self.epoch),
            Write::Revisions(self.revisions),
            Write::Indexes(self.indexes),
            Write::Restored(self.restored.clone()),
        ];
        writes.extend(systems.map(|record| Write::PutSystem(Arc::clone(record))));
        writes.extend(nodes.map(|(node, g)| Write::PutNode(node.clone(), g.clone())));
        writes
    }

    /// Gives an index to what has none, and to the next change one above all that there are. What is to be written then.
    pub fn number(&mut self) -> Vec<Write> {
        let given = self.systems.values().map(|record| record.index);
        let mut last = given.fold(self.indexes, u64::max);
        let mut writes = Vec::new();
        for record in self.systems.values_mut().filter(|r| r.index == 0) {
            last += 1;
            Arc::make_mut(record).index = last;
            writes.push(Write::PutSystem(Arc::clone(record)));
        }
        if last != self.indexes {
            self.indexes = last;
            writes.push(Write::Indexes(last));
        }
        writes
    }

    /// Makes a change.
    pub fn change(&mut self, write: Write) {
        match write {
            Write::PutSystem(record) => {
                self.systems.insert(record.name().to_owned(), record);
            }
            Write::RemoveSystem(name) => drop(self.systems.remove(&name)),
            Write::PutNode(node, generation) => drop(self.nodes.insert(node, generation)),
            Write::Revisions(up_to) => self.revisions = self.revisions.max(up_to),
            Write::Indexes(up_to) => self.indexes = self.indexes.max(up_to),
            Write::Epoch(epoch) => self.epoch = epoch,
            Write::Restored(restored) => self.restored = restored,
            Write::ClusterUid(uid) => self.cluster_uid = uid,
        }
    }
}
