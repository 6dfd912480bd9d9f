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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::desired::SystemRef;

    fn system(nr: u8) -> SystemRef {
        SystemRef {
            name: format!("s{nr}"),
            uid: format!("uid{nr}"),
        }
    }

    /// A few keys and few values, so that two inventories share some and differ in others.
    fn manager() -> impl Strategy<Value = ManagerObserved> {
        let choices = (0..3u8, 0..3u8, 0..3u32, any::<bool>(), any::<bool>());
        choices.prop_map(|(of, name, start, responsive, expired)| ManagerObserved {
            key: ManagerKey {
                system: (of > 0).then(|| system(of)),
                name: format!("m{name}"),
            },
            incarnation: start.to_string(),
            pid: start,
            started: String::new(),
            responsive,
            unseen: false,
            expired: expired.then(|| "hangs".to_owned()),
            modules: Default::default(),
            opened: Default::default(),
            components: Vec::new(),
            activity: Default::default(),
        })
    }

    fn held() -> impl Strategy<Value = Held> {
        (1..3u8, 0..3u8).prop_map(|(of, instance)| Held {
            part: None,
            system: system(of),
            instance: format!("C{instance}"),
            reason: "died".to_owned(),
        })
    }

    /// As agents keep it: sorted, each key once.
    fn inventory() -> impl Strategy<Value = Inventory> {
        let managers = prop::collection::vec(manager(), 0..8);
        let held = prop::collection::btree_set(held(), 0..4);
        (any::<u64>(), managers, held).prop_map(|(revision, mut managers, held)| {
            managers.sort_by(|a, b| a.key.cmp(&b.key));
            managers.dedup_by(|a, b| a.key == b.key);
            Inventory {
                node: "n".to_owned(),
                revision,
                managers,
                held: held.into_iter().collect(),
            }
        })
    }

    proptest! {
        #[test]
        fn the_way_leads_from_any_inventory_to_any_other(a in inventory(), b in inventory()) {
            let mut walked = a.clone();
            prop_assert!(walked.advance(b.since(&a)));
            prop_assert_eq!(walked, b);
        }

        #[test]
        fn a_way_from_elsewhere_changes_nothing(
            a in inventory(), b in inventory(), mut other in inventory(),
        ) {
            prop_assume!(other.revision != a.revision);
            let before = other.clone();
            prop_assert!(!other.advance(b.since(&a)));
            prop_assert_eq!(other, before);
        }

        #[test]
        fn a_way_travels_as_json(a in inventory(), b in inventory()) {
            let delta = b.since(&a);
            let json = serde_json::to_string(&delta).unwrap();
            prop_assert_eq!(serde_json::from_str::<InventoryDelta>(&json).unwrap(), delta);
        }
    }

    #[test]
    fn only_what_differs_is_sent() {
        let manager = |name: &str, pid| ManagerObserved {
            key: ManagerKey {
                system: Some(system(1)),
                name: name.to_owned(),
            },
            incarnation: String::new(),
            pid,
            started: String::new(),
            responsive: true,
            unseen: false,
            expired: None,
            modules: Default::default(),
            opened: Default::default(),
            components: Vec::new(),
            activity: Default::default(),
        };
        let inventory = |revision, managers| Inventory {
            node: "n".to_owned(),
            revision,
            managers,
            held: Vec::new(),
        };
        let before = inventory(4, vec![manager("a", 1), manager("b", 2), manager("c", 3)]);
        let now = inventory(5, vec![manager("a", 1), manager("c", 4), manager("d", 5)]);
        let delta = now.since(&before);
        assert_eq!((delta.from, delta.to), (4, 5));
        assert_eq!(delta.managers, [manager("c", 4), manager("d", 5)]);
        assert_eq!(delta.gone, [manager("b", 2).key]);
        assert_eq!(delta.held, None);
    }
}
