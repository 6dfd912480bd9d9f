//! Components that were moved away from a node that cannot be asked: they may still run there, and are started nowhere
//! else before that node has been seen without them.

use std::collections::{BTreeMap, BTreeSet};

use rts_plan::desired::Desired;
use rts_plan::observed::{Inventory, NodeObserved, Observed};
use rts_plan::plan::{Blocked, Plan};
use rts_plan::target;

use crate::core::Core;
use crate::reconcile::NodeSpecs;
use crate::store::SystemRecord;

type Records = BTreeMap<String, SystemRecord>;

/// Plans: what failed waits, and what may still run elsewhere is not started.
pub fn plan(core: &Core, records: &Records, desired: &Desired, observed: &Observed) -> Plan {
    plan_but(core, records, desired, observed, None)
}

/// The same as it is once what failed of one system is `forgotten`.
pub fn plan_but(
    core: &Core,
    records: &Records,
    desired: &Desired,
    observed: &Observed,
    forgotten: Option<&str>,
) -> Plan {
    let mut blocked = core.backoff().blocked_but(forgotten);
    blocked.extend(waits(records, observed));
    rts_plan::plan(desired, observed, &blocked)
}

/// Components that wait for the word of a node that they have left.
fn waits(records: &Records, observed: &Observed) -> Blocked {
    let mut waits = Blocked::new();
    for record in records.values().filter(|r| r.deleted.is_none()) {
        for (instance, nodes) in &record.left {
            let Some(new) = record.places.get(instance) else {
                continue;
            };
            if let Some(old) = nodes.iter().find(|node| seen_on(observed, node).is_none()) {
                let key = target::on(new, &target::component(instance));
                waits.insert(key, reason(record.name(), new, old));
            }
        }
    }
    waits
}

fn reason(system: &str, new: &str, old: &str) -> String {
    format!(
        "node {old} is unknown and may still run it: it is created on node {new} once node {old} has said that it is \
         gone there; if that node does not come back, `rtsctl teardown {system} --forget-node {old}`, then apply again"
    )
}

/// Forgets, durably, that a component may run on a node that has taken its newest spec and was seen without it.
pub async fn seen(core: &Core, specs: &NodeSpecs, observed: &Observed) {
    let free = |record: &SystemRecord, instance: &str, node: &String| {
        let session = core.sessions.get(node).map(|entry| entry.session.id);
        let told = session.is_some_and(|id| specs.acked(node, &id).is_some());
        told && seen_on(observed, node).is_some_and(|i| !runs(i, &record.uid, instance))
    };
    let mut gone: Vec<(String, String, BTreeSet<String>)> = Vec::new();
    let records = core.registry().systems.clone();
    for record in records.values() {
        for (instance, nodes) in &record.left {
            let nodes = nodes.iter().filter(|node| free(record, instance, node));
            let nodes: BTreeSet<String> = nodes.cloned().collect();
            if !nodes.is_empty() {
                gone.push((record.name().to_owned(), instance.clone(), nodes));
            }
        }
    }
    for (name, instance, nodes) in gone {
        let _admission = core.admission.lock().await;
        let present = core.registry().systems.get(&name).cloned();
        // What was changed meanwhile is looked at again in the next round.
        let same = |now: &SystemRecord| {
            let then = records.get(&name);
            then.is_some_and(|then| (&then.uid, then.generation) == (&now.uid, now.generation))
        };
        let Some(mut present) = present.filter(same) else {
            continue;
        };
        if let Some(left) = present.left.get_mut(&instance) {
            left.retain(|node| !nodes.contains(node));
        }
        present.left.retain(|_, nodes| !nodes.is_empty());
        if let Err(e) = core.store_system(present).await {
            tracing::error!(error = %crate::chain(&e), "what a node no longer runs cannot be stored");
        }
    }
}

fn seen_on<'a>(observed: &'a Observed, node: &str) -> Option<&'a Inventory> {
    match observed.nodes.get(node) {
        Some(NodeObserved::Known(inventory)) => Some(inventory),
        _ => None,
    }
}

fn runs(inventory: &Inventory, uid: &str, instance: &str) -> bool {
    let components = inventory.managers.iter().flat_map(|m| &m.components);
    let mut own = components.filter(|c| c.system.as_ref().is_some_and(|s| s.uid == uid));
    own.any(|component| component.instance == instance)
}
