//! Component objects: what is desired and what was observed, joined by node and instance name.

use std::collections::BTreeMap;

use rts_controller_api::objects::{Component, ComponentStatus, ComponentView, Kind, Metadata};
use rts_plan::desired::{PlacedComponent, SystemRef};
use rts_plan::observed::{ComponentObserved, LifeCycleState, ManagerObserved};
use rts_plan::target;

use super::{Scene, object};
use crate::view::key;

#[derive(Default)]
struct Both<'a> {
    desired: Option<(&'a SystemRef, &'a PlacedComponent)>,
    observed: Option<(&'a ManagerObserved, &'a ComponentObserved, bool)>,
}

/// The components of a node.
///
/// `before` gives what was published last: of an absent component, the count of its restarts stays.
pub fn of_node(
    scene: &Scene<'_>,
    node: &str,
    before: impl Fn(&str) -> Option<Component>,
) -> Vec<Component> {
    let mut all: BTreeMap<&str, Both<'_>> = BTreeMap::new();
    let spec = scene.world.placed.desired.nodes.get(node);
    for part in spec.into_iter().flat_map(|spec| &spec.systems) {
        for placed in &part.components {
            let both = all.entry(&placed.spec.instance).or_default();
            both.desired = Some((&part.system, placed));
        }
    }
    if let Some((inventory, known)) = scene.inventories.get(node) {
        for manager in &inventory.managers {
            for component in &manager.components {
                let both = all.entry(&component.instance).or_default();
                both.observed = Some((manager, component, *known));
            }
        }
    }
    all.iter()
        .map(|(instance, both)| {
            let mut now = component(scene, node, instance, both);
            let before = match both.observed {
                None => before(&key(instance, node)),
                Some(_) => None,
            };
            if let Some(before) = before.filter(|b| b.metadata.uid == now.metadata.uid) {
                now.status.restarts = before.status.restarts;
                now.status.incarnation = before.status.incarnation;
            }
            now
        })
        .collect()
}

/// Name of a state, as in JSON.
pub fn state_name(state: LifeCycleState) -> &'static str {
    match state {
        LifeCycleState::Created => "Created",
        LifeCycleState::Inactive => "Inactive",
        LifeCycleState::Active => "Active",
        LifeCycleState::Error => "Error",
    }
}

fn component(scene: &Scene<'_>, node: &str, instance: &str, both: &Both<'_>) -> Component {
    let mut status = match &both.observed {
        Some((manager, found, known)) => as_observed(manager, found, *known),
        None => ComponentStatus {
            state: "Unknown".to_owned(),
            ..ComponentStatus::default()
        },
    };
    node.clone_into(&mut status.node);
    if let Some((_, placed)) = both.desired {
        if both.observed.is_none() {
            status.stand_in = placed.stand_in.is_some();
        }
        if status.manager.is_empty() {
            status.manager.clone_from(&placed.manager);
        }
        status.waiting_on = waits_for(scene, node, instance, both, &status);
    }
    let (system, target) = (system_of(both), target::component(instance));
    let by_hand = scene.drifts.get(&(system, target.as_str()));
    status.drift = drift(both) || by_hand.is_some();
    status.drift_fields = by_hand.map_or_else(Vec::new, |drift| super::drift::fields(drift));
    object(
        Kind::Component,
        metadata(scene, instance, both, &status),
        view(both),
        status,
    )
}

fn as_observed(
    manager: &ManagerObserved,
    found: &ComponentObserved,
    known: bool,
) -> ComponentStatus {
    let known = known && manager.responsive;
    let state = state_name(found.state);
    ComponentStatus {
        state: if known { state } else { "Unknown" }.to_owned(),
        last_known_state: (!known).then(|| state.to_owned()),
        manager: manager.key.name.clone(),
        pid: Some(manager.pid),
        restarts: found.restarts,
        stand_in: found.stand_in,
        incarnation: found.incarnation.clone(),
        message: found.message.clone(),
        configuration: found.configuration.clone(),
        rate: Some(found.rate),
        execution_context: found.execution_context.clone(),
        runs_with: found.runs_with.clone(),
        executions: found.executions,
        timing: found.timing.clone(),
        realtime: found.realtime.clone(),
        ports: found.ports.clone(),
        created: found.created.parse().ok(),
        ..ComponentStatus::default()
    }
}

/// Why a desired component is not Active.
fn waits_for(
    scene: &Scene<'_>,
    node: &str,
    instance: &str,
    both: &Both<'_>,
    status: &ComponentStatus,
) -> Option<String> {
    let hangs = both.observed.and_then(|(_, found, _)| found.hangs.clone());
    if hangs.is_some() || status.state == "Active" {
        return hangs;
    }
    let known = scene.inventories.get(node).is_some_and(|(_, known)| *known);
    let reason = scene.reasons.get(&target::component(instance));
    let reason = reason.map(|reason| reason.text.clone());
    let reason = reason.or_else(|| (!known).then(|| format!("node {node} is unknown")));
    match (both.observed, reason) {
        (None, Some(reason)) => Some(format!("not created yet: {reason}")),
        (None, None) => Some("not created yet: its steps have not been carried out".to_owned()),
        (Some(_), reason) => reason,
    }
}

/// Name of its system; empty when it has none.
fn system_of<'a>(both: &Both<'a>) -> &'a str {
    let desired = both.desired.map(|(system, _)| system);
    let found = || {
        both.observed
            .and_then(|(_, found, _)| found.system.as_ref())
    };
    desired.or_else(found).map_or("", |system| &system.name)
}

fn drift(both: &Both<'_>) -> bool {
    match (&both.desired, &both.observed) {
        (None, Some((_, found, _))) => found.system.is_none(),
        (Some((system, _)), Some((_, found, _))) => found.system.as_ref() != Some(*system),
        _ => false,
    }
}

fn metadata(
    scene: &Scene<'_>,
    instance: &str,
    both: &Both<'_>,
    status: &ComponentStatus,
) -> Metadata {
    let record = both
        .desired
        .and_then(|(system, _)| scene.systems.get(&system.name));
    let uid = match &both.desired {
        Some((system, _)) => format!("{}/{instance}", system.uid),
        None => status.incarnation.clone(),
    };
    Metadata {
        name: instance.to_owned(),
        uid,
        generation: record.map_or(0, |record| record.generation),
        creation_timestamp: status.created,
        ..Metadata::default()
    }
}

fn view(both: &Both<'_>) -> ComponentView {
    match (&both.desired, &both.observed) {
        (Some((_, placed)), _) => ComponentView {
            system: system_of(both).to_owned(),
            type_name: placed.spec.type_name.clone(),
            required: placed.spec.required,
            configuration: placed.spec.configuration.clone(),
            composite: None,
        },
        (None, Some((_, found, _))) => ComponentView {
            system: system_of(both).to_owned(),
            type_name: found.type_name.clone(),
            ..ComponentView::default()
        },
        (None, None) => ComponentView::default(),
    }
}
