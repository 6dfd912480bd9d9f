//! What does not go on, and why: the planner's word, failed targets in back-off, and nodes that refuse.

use std::collections::BTreeMap;

use rts_controller_api::objects::Waiting;
use rts_plan::target;

use crate::core::World;
use crate::reconcile::Backoff;
use crate::store::SystemRecord;

/// Target → reason, over all systems.
pub fn reasons(world: &World, backoff: &Backoff) -> BTreeMap<String, String> {
    let planned = world.plan.waiting_on.iter();
    let mut reasons: BTreeMap<_, _> = planned
        .map(|waiting| (waiting.target.clone(), waiting.reason.clone()))
        .collect();
    for (target, entry) in backoff.failing() {
        reasons.insert(target.clone(), entry.reason.clone());
    }
    for (node, reason) in &world.faults {
        reasons.insert(target::node(node), reason.clone());
    }
    reasons
}

/// What of one system does not go on.
pub fn of_system(
    reasons: &BTreeMap<String, String>,
    backoff: &Backoff,
    record: &SystemRecord,
) -> Vec<Waiting> {
    reasons
        .iter()
        .filter(|(target, _)| concerns(record, backoff, target))
        .map(|(target, reason)| {
            let entry = backoff.get(target).filter(|entry| entry.failing());
            Waiting {
                target: target.clone(),
                reason: reason.clone(),
                required: required(record, target),
                tries: entry.map_or(0, |entry| entry.tries),
                next_try: entry.map(|entry| entry.next_try),
            }
        })
        .collect()
}

/// True when a target belongs to a system.
fn concerns(record: &SystemRecord, backoff: &Backoff, target: &str) -> bool {
    let name = record.name();
    let owner = backoff.get(target).and_then(|e| e.system.as_deref());
    if let Some(owner) = owner {
        return owner == name;
    }
    let (kind, rest) = target.split_once('/').unwrap_or((target, ""));
    let of_manager = |manager: &str| {
        let prefix = manager.strip_prefix(name);
        prefix.is_some_and(|rest| rest.starts_with('.'))
    };
    match kind {
        "component" => record.spec.components.iter().any(|c| c.instance == rest),
        "connector" => record.spec.connectors.iter().any(|c| c.name == rest),
        "manager" => of_manager(rest),
        "module" => rest.rsplit_once('@').is_some_and(|(_, m)| of_manager(m)),
        "package" => rest.rsplit_once('@').is_some_and(|(type_name, node)| {
            let components = &record.spec.components;
            record.nodes.contains(node) && components.iter().any(|c| c.type_name == type_name)
        }),
        "node" => record.nodes.contains(rest),
        _ => false,
    }
}

/// True when the system cannot be healthy without a target.
fn required(record: &SystemRecord, target: &str) -> bool {
    let components = &record.spec.components;
    let (kind, rest) = target.split_once('/').unwrap_or((target, ""));
    match kind {
        "component" => components.iter().any(|c| c.instance == rest && c.required),
        "module" | "package" => rest.rsplit_once('@').is_none_or(|(type_name, _)| {
            components
                .iter()
                .any(|c| c.type_name == type_name && c.required)
        }),
        "connector" => record
            .spec
            .connectors
            .iter()
            .filter(|c| c.name == rest)
            .flat_map(|c| [&c.source.instance, &c.target.instance])
            .all(|end| components.iter().any(|c| c.instance == *end && c.required)),
        _ => true,
    }
}
