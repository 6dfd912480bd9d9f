//! Records of the store.

use std::collections::{BTreeMap, BTreeSet};

use jiff::Timestamp;
use rts_schemas::system::SystemSpec;
use serde::{Deserialize, Serialize};

/// A stored system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SystemRecord {
    /// UUID; a system that is deleted and applied again gets a new one.
    pub uid: String,
    /// Raised by each change of the spec or of a module.
    pub generation: u64,
    /// What was applied.
    pub spec: SystemSpec,
    /// SHA-256 of each type's module file when it was applied, by type name.
    #[serde(default)]
    pub digests: BTreeMap<String, String>,
    /// Nodes that it ever ran on; a teardown needs the word of each.
    #[serde(default)]
    pub nodes: BTreeSet<String>,
    /// When it was first applied.
    pub created: Timestamp,
    /// When its end was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deleted: Option<Timestamp>,
}

impl SystemRecord {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.spec.name
    }
}

/// The number that guards a node's NodeSpec, and what it stands for.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct NodeGeneration {
    /// Monotone over all systems of the node.
    pub generation: u64,
    /// Digest of the spec that it was given to.
    pub digest: String,
}

/// The whole store.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct State {
    /// Made once with the store.
    pub cluster_uid: String,
    /// Raised each time a store is created or restored.
    pub epoch: u64,
    /// No revision above this one was ever given out.
    pub revisions: u64,
    /// Systems by name.
    pub systems: BTreeMap<String, SystemRecord>,
    /// Node generations by node.
    pub nodes: BTreeMap<String, NodeGeneration>,
}
