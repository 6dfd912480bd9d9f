//! What changed between two inventories of one node, so that an agent need not send all of it each time.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::desired::ManagerKey;
use crate::observed::{Held, Inventory, ManagerObserved};

/// The way from one revision of an inventory to a later one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct InventoryDelta {
    /// Revision that it starts from.
    pub from: u64,
    /// Revision that it leads to.
    pub to: u64,
    /// Managers that are new or differ, whole.
    #[serde(default)]
    pub managers: Vec<ManagerObserved>,
    /// Managers that are gone.
    #[serde(default)]
    pub gone: Vec<ManagerKey>,
    /// All that is held, when that changed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held: Option<Vec<Held>>,
}

impl Inventory {
    /// What leads from an earlier inventory of the same node to this one.
    pub fn since(&self, earlier: &Inventory) -> InventoryDelta {
        let before = |key: &ManagerKey| earlier.managers.iter().find(|m| m.key == *key);
        let now = |key: &ManagerKey| self.managers.iter().any(|m| m.key == *key);
        let changed = |m: &&ManagerObserved| before(&m.key) != Some(*m);
        let keys = earlier.managers.iter().map(|m| &m.key);
        InventoryDelta {
            from: earlier.revision,
            to: self.revision,
            managers: self.managers.iter().filter(changed).cloned().collect(),
            gone: keys.filter(|key| !now(key)).cloned().collect(),
            held: (self.held != earlier.held).then(|| self.held.clone()),
        }
    }

    /// Goes the way of a delta. False, and unchanged, when it starts from another revision.
    pub fn advance(&mut self, delta: InventoryDelta) -> bool {
        if delta.from != self.revision {
            return false;
        }
        let replaced = |key: &ManagerKey| delta.managers.iter().any(|m| m.key == *key);
        self.managers
            .retain(|m| !replaced(&m.key) && !delta.gone.contains(&m.key));
        self.managers.extend(delta.managers);
        self.managers.sort_by(|a, b| a.key.cmp(&b.key));
        if let Some(held) = delta.held {
            self.held = held;
        }
        self.revision = delta.to;
        true
    }
}
