//! Rebuilds records of systems from a node's spec, so that they are placed as they run. Pure.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use jiff::Timestamp;
use rts_plan::Placed;
use rts_plan::desired::{Elsewhere, NodeSpec, NodeSystem};
use rts_schemas::system::{Orders, SystemSpec};

use crate::store::{Records, SystemRecord, Write};

/// Records with a node's ledger taken in.
#[derive(Debug, Default)]
pub struct Import {
    /// All records.
    pub records: Records,
    /// Systems that the ledger brought or changed.
    pub adopted: BTreeSet<String>,
    /// Systems that are gone, or go, since the ledger no longer has them.
    pub dropped: BTreeSet<String>,
    /// Systems of which the ledger has an older part than what is here.
    pub older: BTreeSet<String>,
}

/// Why a ledger is not added.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refused {
    /// Other systems have these names here.
    Taken(BTreeSet<String>),
    /// It was being taken down there, and these systems live here.
    Ending(BTreeSet<String>),
}

impl Import {
    /// What leads from the stored records to these.
    pub fn writes(&self, stored: &Records) -> Vec<Write> {
        let new = self.records.values();
        let changed = new.filter(|record| stored.get(record.name()) != Some(*record));
        let gone = stored.keys().filter(|n| !self.records.contains_key(*n));
        let mut writes: Vec<Write> = gone.cloned().map(Write::RemoveSystem).collect();
        writes.extend(changed.map(|record| Write::PutSystem(Arc::clone(record))));
        writes
    }
}

/// Adds the systems of a ledger, where nothing that is here suffers by it.
pub fn add(stored: &Records, spec: &NodeSpec, now: Timestamp) -> Result<Import, Refused> {
    let names = |what: &dyn Fn(&NodeSystem, &SystemRecord) -> bool| -> BTreeSet<String> {
        let parts = spec.systems.iter().filter(|part| {
            let record = stored.get(&part.system.name);
            record.is_some_and(|record| what(part, record))
        });
        parts.map(|part| part.system.name.clone()).collect()
    };
    let taken = names(&|part, record| record.uid != part.system.uid);
    if !taken.is_empty() {
        return Err(Refused::Taken(taken));
    }
    let ending = names(&|part, record| part.components.is_empty() && record.deleted.is_none());
    if !ending.is_empty() {
        return Err(Refused::Ending(ending));
    }
    let mut import = Import {
        records: stored.clone(),
        ..Import::default()
    };
    for part in &spec.systems {
        take(&mut import, &spec.node, part, now);
    }
    Ok(import)
}

/// Makes the records say of a node what its ledger says: it is newer than they are, but for those that users have `said`
/// since. `placed` is how they are placed.
pub fn replace(
    stored: &Records,
    placed: &Placed,
    spec: &NodeSpec,
    said: &BTreeSet<String>,
    now: Timestamp,
) -> Import {
    let mut import = Import {
        records: stored.clone(),
        ..Import::default()
    };
    let old = placed.desired.nodes.get(&spec.node);
    let unsaid = |part: &&NodeSystem| !said.contains(&part.system.name);
    let old = old.into_iter().flat_map(|old| &old.systems);
    for part in old.filter(unsaid) {
        let new = spec.systems.iter().find(|new| new.system == part.system);
        leave(&mut import, part, new);
    }
    for part in spec.systems.iter().filter(|part| !unsaid(part)) {
        surpass(&mut import, &spec.node, part);
    }
    for part in spec.systems.iter().filter(unsaid) {
        let other = |record: &&Arc<SystemRecord>| record.uid != part.system.uid;
        let name = &part.system.name;
        if import.records.get(name).filter(other).is_some() {
            import.records.remove(name);
            import.dropped.insert(name.clone());
        }
        take(&mut import, &spec.node, part, now);
    }
    import
}

/// What a user has said is newer than a ledger's part, whatever their numbers.
fn surpass(import: &mut Import, node: &str, part: &NodeSystem) {
    let name = &part.system.name;
    import.older.insert(name.clone());
    let own = import.records.get_mut(name);
    let Some(record) = own.filter(|record| record.uid == part.system.uid) else {
        return;
    };
    let record = Arc::make_mut(record);
    record.nodes.insert(node.to_owned());
    record.generation = record.generation.max(part.generation.saturating_add(1));
    // What was moved away since may still run there.
    for placed in &part.components {
        let instance = &placed.spec.instance;
        if record.places.get(instance).is_some_and(|at| at != node) {
            let left = record.left.entry(instance.clone()).or_default();
            left.insert(node.to_owned());
        }
    }
}

/// Takes out of a record what it has on a node and the node's newer part has not.
fn leave(import: &mut Import, old: &NodeSystem, new: Option<&NodeSystem>) {
    let name = &old.system.name;
    let Some(record) = import.records.get_mut(name) else {
        return;
    };
    // A system that is being taken down goes by itself.
    if record.uid != old.system.uid || record.deleted.is_some() {
        return;
    }
    if new.is_some_and(|new| is_older(new, record)) {
        return;
    }
    let kept: BTreeSet<&str> = new
        .into_iter()
        .flat_map(|new| &new.components)
        .map(|c| c.spec.instance.as_str())
        .collect();
    let was = |instance: &str| old.components.iter().any(|c| c.spec.instance == instance);
    let record = Arc::make_mut(record);
    let spec = Arc::make_mut(&mut record.spec);
    let before = spec.components.len();
    spec.components
        .retain(|c| !was(&c.instance) || kept.contains(c.instance.as_str()));
    record.places.retain(|instance, _| {
        let mut left = spec.components.iter();
        left.any(|c| c.instance == *instance)
    });
    let still = |connector: &str| {
        let connectors = new.into_iter().flat_map(|new| &new.connectors);
        connectors.into_iter().any(|c| c.spec.name == connector)
    };
    let here = |connector: &str| old.connectors.iter().any(|c| c.spec.name == connector);
    spec.connectors.retain(|c| !here(&c.name) || still(&c.name));
    if spec.components.is_empty() && before > 0 && new.is_none() {
        import.records.remove(name);
        import.dropped.insert(name.clone());
    } else if spec.components.len() != before && new.is_none_or(|new| new.generation == 0) {
        record.generation += 1;
    }
}

/// Takes one system's part in, unless it is older than what is there.
fn take(import: &mut Import, node: &str, part: &NodeSystem, now: Timestamp) {
    let name = &part.system.name;
    if part.components.is_empty() {
        return end(import, node, part, now);
    }
    let before = import.records.get(name).cloned();
    if before.as_ref().is_some_and(|before| is_older(part, before)) {
        import.older.insert(name.clone());
        return;
    }
    let mut record = before
        .as_deref()
        .cloned()
        .unwrap_or_else(|| fresh(part, now));
    let spec = Arc::make_mut(&mut record.spec);
    let mut places = record.places.clone();
    for placed in &part.components {
        let component = placed.spec.clone();
        places.insert(component.instance.clone(), node.to_owned());
        let all = &mut spec.components;
        match all.iter_mut().find(|c| c.instance == component.instance) {
            Some(old) => *old = component,
            None => all.push(component),
        }
        if let Some(shape) = &placed.stand_in {
            let instance = placed.spec.instance.clone();
            record.stand_ins.insert(instance, shape.clone());
            continue;
        }
        record.stand_ins.remove(&placed.spec.instance);
        let type_name = placed.spec.type_name.clone();
        match &placed.module_digest {
            Some(digest) => drop(record.digests.insert(type_name, digest.clone())),
            None => drop(record.digests.remove(&type_name)),
        }
    }
    for placed in &part.connectors {
        let connector = placed.spec.clone();
        let all = &mut spec.connectors;
        match all.iter_mut().find(|c| c.name == connector.name) {
            Some(old) => *old = connector,
            None => all.push(connector),
        }
    }
    spec.orders.clone_from(&part.orders);
    record.settle(places);
    for placed in &part.components {
        let instance = &placed.spec.instance;
        settle_left(&mut record, instance, part.elsewhere.get(instance));
    }
    record.nodes.insert(node.to_owned());
    if before.as_deref() != Some(&record) {
        grow(&mut record, part);
        import.adopted.insert(name.clone());
    }
    import.records.insert(name.clone(), Arc::new(record));
}

/// What a ledger has, no other node may have made meanwhile: none is told to before that ledger has it no longer. Where the
/// component may still have been running when the ledger was written is in it.
fn settle_left(record: &mut SystemRecord, instance: &str, there: Option<&Elsewhere>) {
    let Some(there) = there else {
        record.left.remove(instance);
        return;
    };
    record.nodes.insert(there.node.clone());
    let left = record.left.entry(instance.to_owned()).or_default();
    left.insert(there.node.clone());
}

/// A part without components: its system was being taken down, and that goes on, in the order of its shutdown.
fn end(import: &mut Import, node: &str, part: &NodeSystem, now: Timestamp) {
    let name = &part.system.name;
    let record = import.records.entry(name.clone());
    let record = record.or_insert_with(|| {
        Arc::new(SystemRecord {
            deleted: Some(now),
            spec: Arc::new(SystemSpec {
                composites: Vec::new(),
                orders: part.orders.clone(),
                ..Arc::unwrap_or_clone(fresh(part, now).spec)
            }),
            ..fresh(part, now)
        })
    });
    let record = Arc::make_mut(record);
    record.nodes.insert(node.to_owned());
    if record.deleted.is_none() {
        record.deleted = Some(now);
        import.dropped.insert(name.clone());
    }
}

/// A part whose age is not known is taken for the newest.
fn is_older(part: &NodeSystem, record: &SystemRecord) -> bool {
    part.generation > 0 && part.generation < record.generation
}

/// A record holds what its newest part says: parts of one generation are of one text.
fn grow(record: &mut SystemRecord, part: &NodeSystem) {
    record.generation = match part.generation {
        0 => record.generation + 1,
        generation => record.generation.max(generation),
    };
}

fn fresh(part: &NodeSystem, now: Timestamp) -> SystemRecord {
    SystemRecord {
        uid: part.system.uid.clone(),
        generation: part.generation,
        index: 0,
        spec: Arc::new(SystemSpec {
            composites: Vec::new(),
            name: part.system.name.clone(),
            full_id: String::new(),
            components: Vec::new(),
            connectors: Vec::new(),
            orders: Orders::default(),
        }),
        digests: BTreeMap::new(),
        stand_ins: BTreeMap::new(),
        nodes: BTreeSet::new(),
        created: now,
        deleted: None,
        forgotten: BTreeSet::new(),
        places: BTreeMap::new(),
        left: BTreeMap::new(),
    }
}

/// Instances of a ledger that would be made anew, or end: another node, another manager, another hash. What an older part
/// has is another part's to say, and the end of a system whose deletion was asked for is no disturbance.
pub fn disturbed(import: &Import, placed: &Placed, spec: &NodeSpec) -> Vec<String> {
    let here = placed.desired.nodes.get(&spec.node);
    let mut found = Vec::new();
    let newest = |part: &&NodeSystem| !import.older.contains(&part.system.name);
    let stays = |part: &&NodeSystem| {
        let record = import.records.get(&part.system.name);
        record.is_none_or(|record| record.uid != part.system.uid || record.deleted.is_none())
    };
    for part in spec.systems.iter().filter(newest).filter(stays) {
        let now = here.and_then(|here| here.systems.iter().find(|s| s.system == part.system));
        for component in &part.components {
            let mut now = now.into_iter().flat_map(|now| &now.components);
            let same = now.any(|now| {
                let place = (&now.spec.instance, &now.manager, &now.recreate_hash);
                let old = &component.spec.instance;
                place == (old, &component.manager, &component.recreate_hash)
            });
            if !same {
                found.push(component.spec.instance.clone());
            }
        }
    }
    found
}
