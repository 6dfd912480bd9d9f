//! What a manager makes a stand-in of.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::PortInfo;

/// A component without code of its own: what it has, and how it behaves.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct StandInShape {
    /// Its ports. One with a direction other than `in` and `out`, or without a type, is listed and not connectable.
    #[serde(default)]
    pub ports: Vec<PortInfo>,
    /// Its parameters with their defaults.
    #[serde(default)]
    pub parameters: BTreeMap<String, String>,
    /// Milliseconds that `on_initialize` takes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub startup_ms: Option<u64>,
    /// The callback that fails: `initialize`, `activate` or `execute`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fail: Option<String>,
    /// Milliseconds after its activation at which it ends its process.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crash_after_ms: Option<u64>,
    /// Port → values that it plays instead of numbers, each the texts of its elements.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub data: BTreeMap<String, Vec<Vec<String>>>,
}
