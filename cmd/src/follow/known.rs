//! What was shown of the objects of a kind: a list that comes again is told as what differs.

use std::collections::{BTreeMap, VecDeque};

use rts_controller_api::objects::Kind;
use rts_controller_api::watch::WatchType;
use serde_json::Value;

/// Events that are remembered; the controller keeps fewer.
const EVENTS: usize = 4096;
/// What changes without being a change, below `metadata` and `status`.
const COUNTERS: [(&str, &str); 12] = [
    ("metadata", "resourceVersion"),
    ("status", "executions"),
    ("status", "timing"),
    ("status", "lastSeen"),
    ("status", "samplesSent"),
    ("status", "samplesReceived"),
    ("status", "bytes"),
    ("status", "drops"),
    ("status", "gaps"),
    ("status", "latency"),
    ("status", "taps"),
    ("status", "usage"),
];

/// A change of an object.
pub type Change = (WatchType, Value);

/// What was shown of a kind.
#[derive(Debug)]
pub enum Memory {
    /// Objects that come, change and go.
    Objects(Known),
    /// Events.
    Events(Seen),
}

impl Memory {
    /// Nothing was shown yet.
    pub fn of(kind: Kind) -> Self {
        match kind {
            Kind::Event => Self::Events(Seen::default()),
            _ => Self::Objects(Known::default()),
        }
    }

    /// What a list tells that was not shown yet, and whether more may have happened meanwhile that nobody can tell.
    pub fn list(&mut self, items: Vec<Value>) -> (Vec<Change>, bool) {
        match self {
            Self::Objects(known) => (known.list(items), false),
            Self::Events(seen) => {
                let (new, gap) = seen.list(items);
                let new = new.into_iter().map(|event| (WatchType::Added, event));
                (new.collect(), gap)
            }
        }
    }

    /// Takes a change in; true when it was not shown yet.
    pub fn change(&mut self, kind: WatchType, object: &Value) -> bool {
        match self {
            Self::Objects(known) => {
                known.change(kind, object);
                true
            }
            Self::Events(seen) => seen.is_new(object),
        }
    }
}

/// Objects by their identity.
#[derive(Debug, Default)]
pub struct Known(BTreeMap<[String; 4], Value>);

impl Known {
    /// What differs between what is known and a list.
    pub fn list(&mut self, items: Vec<Value>) -> Vec<Change> {
        let mut old = std::mem::take(&mut self.0);
        let mut changes = Vec::new();
        for item in items {
            let key = identity(&item);
            match old.remove(&key) {
                None => changes.push((WatchType::Added, item.clone())),
                Some(before) if bare(&before) != bare(&item) => {
                    changes.push((WatchType::Modified, item.clone()));
                }
                Some(_) => {}
            }
            self.0.insert(key, item);
        }
        let gone = old.into_values().map(|item| (WatchType::Deleted, item));
        // What is gone makes room for what is new.
        gone.chain(changes).collect()
    }

    /// Takes a change in.
    pub fn change(&mut self, kind: WatchType, object: &Value) {
        if kind == WatchType::Deleted {
            self.0.remove(&identity(object));
        } else {
            self.0.insert(identity(object), object.clone());
        }
    }
}

fn identity(object: &Value) -> [String; 4] {
    let text = |part: &str, key: &str| object[part][key].as_str().unwrap_or_default().to_owned();
    [
        text("metadata", "name"),
        text("spec", "system"),
        text("status", "node"),
        text("metadata", "uid"),
    ]
}

fn bare(object: &Value) -> Value {
    let mut object = object.clone();
    for (part, key) in COUNTERS {
        if let Some(part) = object.get_mut(part).and_then(Value::as_object_mut) {
            part.remove(key);
        }
    }
    object
}

/// Events that were seen. They are never changed, and the controller forgets old ones.
#[derive(Debug, Default)]
pub struct Seen(VecDeque<String>);

impl Seen {
    /// The events of a list that were not seen, and whether some between may be missing.
    pub fn list(&mut self, items: Vec<Value>) -> (Vec<Value>, bool) {
        let names = |last: &String| items.iter().any(|item| *last == identity(item)[3]);
        let gap = !self.0.back().is_some_and(names);
        let new = items.into_iter().filter(|item| self.is_new(item));
        (new.collect::<Vec<_>>(), gap)
    }

    /// True when it was not seen before.
    pub fn is_new(&mut self, event: &Value) -> bool {
        let [.., uid] = identity(event);
        if self.0.contains(&uid) {
            return false;
        }
        self.0.push_back(uid);
        if self.0.len() > EVENTS {
            self.0.pop_front();
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use serde_json::json;

    fn object(name: &str, state: u8, version: u8) -> Value {
        json!({
            "metadata": {"name": name, "uid": name, "resourceVersion": version.to_string()},
            "status": {"state": state, "executions": version},
        })
    }

    #[test]
    fn a_list_that_comes_again_tells_only_what_differs() {
        let mut known = Known::default();
        known.list(vec![
            object("a", 1, 1),
            object("b", 1, 1),
            object("c", 1, 1),
        ]);
        // As after a restart of the controller: all versions are new.
        let again = known.list(vec![
            object("a", 1, 7),
            object("b", 2, 7),
            object("d", 1, 7),
        ]);
        let told: Vec<_> = again
            .iter()
            .map(|(kind, o)| (*kind, o["metadata"]["name"].as_str().unwrap()))
            .collect();
        assert_eq!(
            told,
            [
                (WatchType::Deleted, "c"),
                (WatchType::Modified, "b"),
                (WatchType::Added, "d"),
            ]
        );
        known.change(WatchType::Deleted, &object("a", 1, 8));
        known.change(WatchType::Modified, &object("b", 3, 8));
        assert!(
            known
                .list(vec![object("b", 3, 9), object("d", 1, 9)])
                .is_empty()
        );
    }

    #[test]
    fn events_come_once_and_a_gap_is_told() {
        let mut seen = Seen::default();
        let events = |numbers: std::ops::Range<u8>| -> Vec<Value> {
            numbers.map(|n| object(&format!("e{n}"), 0, n)).collect()
        };
        assert_eq!(seen.list(events(0..3)).0, events(0..3));
        assert!(!seen.is_new(&events(2..3)[0]) && seen.is_new(&events(3..4)[0]));
        assert_eq!(seen.list(events(1..6)), (events(4..6), false));
        assert_eq!(seen.list(events(6..8)), (events(6..8), true));
        assert_eq!(seen.list(Vec::new()), (Vec::new(), true));
    }

    proptest! {
        #[test]
        fn what_is_told_makes_of_the_old_objects_the_new_ones(
            old in proptest::collection::btree_map("[a-e]", 0u8..3, 0..5),
            new in proptest::collection::btree_map("[a-e]", 0u8..3, 0..5),
        ) {
            let objects = |states: &BTreeMap<String, u8>, version| -> Vec<Value> {
                states.iter().map(|(name, state)| object(name, *state, version)).collect()
            };
            let mut known = Known::default();
            known.list(objects(&old, 1));
            let mut shown = old.clone();
            for (kind, object) in known.list(objects(&new, 2)) {
                let name = object["metadata"]["name"].as_str().unwrap().to_owned();
                let state = object["status"]["state"].as_u64().unwrap() as u8;
                match kind {
                    WatchType::Deleted => prop_assert!(shown.remove(&name).is_some()),
                    WatchType::Added => prop_assert_eq!(shown.insert(name, state), None),
                    _ => prop_assert_ne!(shown.insert(name, state), Some(state)),
                }
            }
            prop_assert_eq!(shown, new);
        }
    }
}
