//! Where everything goes, with what is made of that. It is asked for again and again while nothing it rests on changes, and
//! is as large as all systems together: it is made once and shared for as long as somebody holds it.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Deref;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

use rts_plan::desired::SystemRef;
use rts_plan::{NodeFacts, Placed, Settled, StoredSystem};

use crate::store::{Records, SystemRecord};

/// Placements that are remembered: of what is stored, and of what somebody is about to store.
const REMEMBERED: usize = 4;

/// All systems, placed.
#[derive(Debug, Default)]
pub struct Placement {
    placed: Placed,
    records: Records,
    facts: Vec<NodeFacts>,
    digests: OnceLock<BTreeMap<String, String>>,
    feeders: OnceLock<BTreeMap<String, BTreeSet<String>>>,
}

impl Deref for Placement {
    type Target = Placed;

    fn deref(&self) -> &Placed {
        &self.placed
    }
}

impl Placement {
    /// Node → digest of its spec; made when it is first asked for.
    pub fn digests(&self) -> &BTreeMap<String, String> {
        self.digests.get_or_init(|| {
            let nodes = self.placed.desired.nodes.iter();
            nodes
                .map(|(node, spec)| (node.clone(), rts_plan::digest(spec)))
                .collect()
        })
    }

    /// Node → other nodes with connectors that lead to it.
    pub fn feeders(&self) -> &BTreeMap<String, BTreeSet<String>> {
        self.feeders.get_or_init(|| {
            let mut feeders: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
            let parts = self.placed.desired.nodes.values().flat_map(|n| &n.systems);
            let all = parts.flat_map(|part| &part.connectors);
            for end in all.filter(|c| c.source.node != c.target.node) {
                let of = feeders.entry(end.target.node.clone()).or_default();
                of.insert(end.source.node.clone());
            }
            feeders
        })
    }

    /// Components of all systems: what work on it takes grows with them.
    pub fn size(&self) -> usize {
        let systems = self.records.values();
        systems.map(|record| record.spec.components.len()).sum()
    }

    /// True when it would be made of these in the same way.
    fn is_of(&self, records: &Records, facts: &[NodeFacts]) -> bool {
        let pairs = self.records.values().zip(records.values());
        self.facts == facts
            && self.records.len() == records.len()
            && pairs.into_iter().all(|(a, b)| is_alike(a, b))
    }
}

/// Placements that somebody holds.
#[derive(Debug, Default)]
pub struct Placements(Mutex<Vec<Weak<Placement>>>);

impl Placements {
    /// Places these systems, or finds that it was done.
    pub fn place(&self, records: &Records, facts: Vec<NodeFacts>, local: &str) -> Arc<Placement> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut held = known.iter().filter_map(Weak::upgrade);
        if let Some(found) = held.find(|placement| placement.is_of(records, &facts)) {
            return found;
        }
        let systems: Vec<StoredSystem> = records.values().map(|record| stored(record)).collect();
        let settled = records.values().map(|r| (r.uid.clone(), settled(r)));
        let placed = rts_plan::place_settled(&systems, &facts, local, &settled.collect());
        let made = Arc::new(Placement {
            placed,
            records: records.clone(),
            facts,
            digests: OnceLock::new(),
            feeders: OnceLock::new(),
        });
        known.retain(|weak| weak.strong_count() > 0);
        if known.len() >= REMEMBERED {
            known.remove(0);
        }
        known.push(Arc::downgrade(&made));
        made
    }
}

/// True for records that are placed alike, whatever else is remembered of them.
fn is_alike(a: &Arc<SystemRecord>, b: &Arc<SystemRecord>) -> bool {
    if Arc::ptr_eq(a, b) {
        return true;
    }
    let small = |r: &SystemRecord| (r.generation, r.deleted.is_some());
    small(a) == small(b)
        && a.uid == b.uid
        && (Arc::ptr_eq(&a.spec, &b.spec) || a.spec == b.spec)
        && (&a.digests, &a.stand_ins, &a.places, &a.left)
            == (&b.digests, &b.stand_ins, &b.places, &b.left)
        && (&a.nodes, &a.forgotten) == (&b.nodes, &b.forgotten)
}

/// Name and identity of a stored system.
pub fn reference(record: &SystemRecord) -> SystemRef {
    SystemRef {
        name: record.name().to_owned(),
        uid: record.uid.clone(),
    }
}

fn stored(record: &SystemRecord) -> StoredSystem {
    StoredSystem {
        reference: reference(record),
        spec: record.spec.as_ref().clone(),
        module_digests: record.digests.clone(),
        stand_ins: record.stand_ins.clone(),
        deleting: record.deleted.is_some(),
    }
}

fn settled(record: &SystemRecord) -> Settled {
    let nodes = record.nodes.difference(&record.forgotten);
    Settled {
        generation: record.generation,
        places: record.places.clone(),
        nodes: nodes.cloned().collect(),
        left: record.left.clone(),
    }
}
