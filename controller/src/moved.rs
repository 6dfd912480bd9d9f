//! Components that were moved away from a node that cannot be asked: they may still run there, and are started nowhere
//! else before that node has been seen without them. Until then their new node's spec says so too
//! ([`NodeSystem::elsewhere`]), so that its agent waits when no controller is there.
//!
//! [`NodeSystem::elsewhere`]: rts_plan::desired::NodeSystem::elsewhere

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rts_plan::observed::{Inventory, ManagerObserved, NodeObserved, Observed};
use rts_plan::plan::{Blocked, Plan};
use rts_plan::target;

use crate::core::Core;
use crate::off_loop::off_loop;
use crate::placement::Placement;
use crate::reconcile::NodeSpecs;
use crate::store::{Records, SystemRecord};

/// What a plan leaves alone: what failed waits, and what may still run elsewhere is not started. As it is once what failed of
/// one system is `forgotten`.
pub fn blocked(
    core: &Core,
    records: &Records,
    observed: &Observed,
    forgotten: Option<&str>,
) -> Blocked {
    let mut blocked = core.backoff().blocked_but(forgotten);
    blocked.extend(waits(core, records, observed));
    blocked
}

/// Plans, off the event loop when there is much to plan.
pub async fn plan(placed: &Arc<Placement>, observed: &Observed, blocked: Blocked) -> Plan {
    let size = placed.size();
    let (placed, observed) = (Arc::clone(placed), observed.clone());
    off_loop(size, move || {
        rts_plan::plan(&placed.desired, &observed, &blocked)
    })
    .await
}

/// Components that wait for the word of a node that they have left.
fn waits(core: &Core, records: &Records, observed: &Observed) -> Blocked {
    let mut waits = Blocked::new();
    for record in records.values().filter(|r| r.deleted.is_none()) {
        let runs_on = |instance: &str, node: &str| {
            let inventory = seen_on(observed, node);
            inventory.is_some_and(|inventory| runs(inventory, &record.uid, instance))
        };
        for (instance, nodes) in &record.left {
            let Some(new) = record.places.get(instance) else {
                continue;
            };
            if runs_on(instance, new) {
                continue;
            }
            // The steps keep the order where it is seen; an agent that was not told makes it again when it is alone.
            let wait = nodes.iter().find_map(|old| match seen_on(observed, old) {
                None => Some(unknown(record.name(), new, old)),
                Some(_) if runs_on(instance, old) || is_told(core, old) => None,
                Some(_) => Some(untold(new, old)),
            });
            if let Some(reason) = wait {
                waits.insert(target::on(new, &target::component(instance)), reason);
            }
        }
    }
    waits
}

fn unknown(system: &str, new: &str, old: &str) -> String {
    format!(
        "node {old} is unknown and may still run it: it is created on node {new} once node {old} has said that it is \
         gone there; if that node does not come back, `rtsctl teardown {system} --forget-node {old}`, then apply again"
    )
}

fn untold(new: &str, old: &str) -> String {
    format!(
        "node {old} has not stored that it is to run there no longer: it is created on node {new} once that is done"
    )
}

/// True when an agent's ledger holds what its node was last told, or neither of them anything.
fn is_told(core: &Core, node: &str) -> bool {
    let Some(entry) = core.sessions.get(node) else {
        return false;
    };
    let registry = core.registry();
    match (&entry.session.ledger, registry.nodes.get(node)) {
        (Some(ledger), Some(given)) => {
            let held = (ledger.epoch, ledger.generation, &ledger.digest);
            ledger.cluster_uid == core.cluster_uid
                && held == (given.epoch, given.generation, &given.digest)
        }
        (None, None) => true,
        _ => false,
    }
}

/// Instance → nodes of one system that need not be asked about it any more.
type Gone = BTreeMap<String, BTreeSet<String>>;

/// Forgets, durably, that a component may run elsewhere: on a node that has taken its newest spec and was seen without it,
/// or that nobody knows, or anywhere, once it is seen where it belongs. What is being worked on changes meanwhile.
pub async fn seen(core: &Core, specs: &NodeSpecs, observed: &Observed, busy: &BTreeSet<String>) {
    let records = core.registry().systems.clone();
    for record in records.values().filter(|r| !busy.contains(&r.uid)) {
        let on = |instance: &str, node: &str| {
            let inventory = seen_on(observed, node)?;
            let runs = runs(inventory, &record.uid, instance);
            (runs || !is_unseen(inventory, &record.uid)).then_some(runs)
        };
        let mut gone = Gone::new();
        for (instance, nodes) in &record.left {
            let place = record.places.get(instance);
            let there = place.is_some_and(|place| on(instance, place) == Some(true));
            let free = |node: &&String| {
                let told = has_told(core, specs, node) && on(instance, node) == Some(false);
                there || told || is_nobody(core, record, node)
            };
            let nodes: BTreeSet<String> = nodes.iter().filter(free).cloned().collect();
            if !nodes.is_empty() {
                gone.insert(instance.clone(), nodes);
            }
        }
        forget(core, record, gone).await;
    }
}

/// True when a node's agent has stored its newest spec, or there is none for it.
fn has_told(core: &Core, specs: &NodeSpecs, node: &str) -> bool {
    let Some(entry) = core.sessions.get(node) else {
        return false;
    };
    let nothing = entry.session.ledger.is_none() && !core.registry().nodes.contains_key(node);
    nothing || specs.acked(node, &entry.session.id).is_some()
}

/// True for a node that nobody knows: it was never told to run anything.
fn is_nobody(core: &Core, record: &SystemRecord, node: &str) -> bool {
    let known = record.nodes.contains(node) || core.registry().nodes.contains_key(node);
    !known && core.sessions.get(node).is_none()
}

/// After a restore, what a node's ledger has as this store would write it runs there and nowhere else: no other node may
/// have been told to make it before that ledger was changed.
pub async fn trust(core: &Core) {
    let fresh = fresh(core);
    let mut records = core.registry().systems.clone();
    if fresh.is_empty() || records.values().all(|record| record.left.is_empty()) {
        return;
    }
    for record in records.values_mut().filter(|r| !r.left.is_empty()) {
        Arc::make_mut(record).left.clear();
    }
    let placed = core.place_all(&records);
    let mut gone: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (node, digest) in fresh {
        let spec = placed.desired.nodes.get(&node);
        let same = spec.filter(|spec| rts_plan::digest(spec) == digest);
        for part in same.into_iter().flat_map(|spec| &spec.systems) {
            let own = part.components.iter().map(|c| c.spec.instance.clone());
            gone.entry(part.system.uid.clone()).or_default().extend(own);
        }
    }
    let records = core.registry().systems.clone();
    for record in records.values() {
        let settled = gone.get(&record.uid).into_iter().flatten();
        let settled = settled.filter_map(|instance| record.left.get_key_value(instance));
        let settled = settled.map(|(instance, nodes)| (instance.clone(), nodes.clone()));
        forget(core, record, settled.collect()).await;
    }
}

/// Nodes whose ledgers are what this restored store gave out last, before it has told them anything, with its digest.
fn fresh(core: &Core) -> Vec<(String, String)> {
    let restored = core.registry().restored.clone();
    let Some(restored) = restored else {
        return Vec::new();
    };
    let entries = core.sessions.all().into_iter();
    entries
        .filter(|(node, _)| !restored.settled.contains(node) && is_told(core, node))
        .filter_map(|(node, entry)| Some((node, entry.session.ledger?.digest)))
        .collect()
}

async fn forget(core: &Core, then: &SystemRecord, gone: Gone) {
    if gone.is_empty() {
        return;
    }
    let _admission = core.admission.lock().await;
    let present = core.registry().systems.get(then.name()).cloned();
    // What was changed meanwhile is looked at again in the next round.
    let same = |now: &Arc<SystemRecord>| (&then.uid, then.generation) == (&now.uid, now.generation);
    let Some(mut present) = present.filter(same) else {
        return;
    };
    let record = Arc::make_mut(&mut present);
    for (instance, nodes) in &gone {
        if let Some(left) = record.left.get_mut(instance) {
            left.retain(|node| !nodes.contains(node));
        }
    }
    record.left.retain(|_, nodes| !nodes.is_empty());
    if let Err(e) = core.store_system(present).await {
        tracing::error!(error = %rts_host::error::chain(&e), "what a node no longer runs cannot be stored");
    }
}

fn seen_on<'a>(observed: &'a Observed, node: &str) -> Option<&'a Inventory> {
    match observed.nodes.get(node) {
        Some(NodeObserved::Known(inventory)) => Some(inventory),
        _ => None,
    }
}

/// True when a process of a system may hold more than was seen.
fn is_unseen(inventory: &Inventory, uid: &str) -> bool {
    let of = |m: &&ManagerObserved| m.key.system.as_ref().is_some_and(|s| s.uid == uid);
    let mut own = inventory.managers.iter().filter(of);
    own.any(|manager| manager.unseen && !manager.responsive)
}

fn runs(inventory: &Inventory, uid: &str, instance: &str) -> bool {
    let components = inventory.managers.iter().flat_map(|m| &m.components);
    let mut own = components.filter(|c| c.system.as_ref().is_some_and(|s| s.uid == uid));
    own.any(|component| component.instance == instance)
}
