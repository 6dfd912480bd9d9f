//! Delays the restart of what ends by itself: a process that was started not long ago and is gone, a component that
//! is in Error again soon after it was activated.

use std::collections::BTreeSet;

use rts_plan::desired::{Desired, ManagerKey, SystemRef};
use rts_plan::observed::{ManagerObserved, NodeObserved, Observed};
use rts_plan::plan::{Step, Work};
use rts_plan::target;
use tokio::time::Instant;

use super::backoff::Brought;
use super::by_system::{Plans, key};
use crate::core::Core;
use crate::view::Happening;

/// A step succeeded: remembers when its target was brought up, while nobody took it down.
pub fn succeeded(core: &Core, step: &Step) {
    let who = Brought::new(&step.node, key(step), &step.target);
    match step.work {
        Work::StartManager { .. } | Work::Activate { .. } => {
            let system = step.system.as_ref().map(|s| s.name.clone());
            core.backoff().came_up(who, system, Instant::now());
        }
        Work::StopManager { .. } | Work::Deactivate { .. } | Work::Delete { .. } => {
            core.backoff().went(&who);
        }
        _ => {}
    }
}

/// Counts what these steps would bring up again although it was brought up not long ago. True when there is any.
/// They touch nothing that a run has done or has to do: what was seen of that may be older.
pub fn count(
    core: &Core,
    desired: &Desired,
    steps: &Plans,
    observed: &Observed,
    busy: &BTreeSet<String>,
) -> bool {
    let mut any = false;
    for step in steps.values().flat_map(|plan| &plan.steps) {
        let reason = match &step.work {
            Work::StartManager { manager } => match found(observed, &step.node, manager) {
                Some(None) => "its process ended by itself".to_owned(),
                Some(Some(ManagerObserved {
                    expired: Some(why), ..
                })) => format!("its process is replaced: {why}"),
                _ => continue,
            },
            Work::Reset { .. } => "it went to Error soon after it was activated".to_owned(),
            _ => continue,
        };
        let who = Brought::new(&step.node, key(step), &step.target);
        if !core.backoff().went(&who) {
            continue;
        }
        any = true;
        let system = step.system.as_ref().map(|s| s.name.as_str());
        let rng = core.rng.as_ref();
        let now = core.clock.now();
        let blocked = target::on(&step.node, &step.target);
        let delay = core.backoff().failed(&blocked, system, &reason, rng, now);
        let message = format!("{reason}; started again in {:.1} s", delay.as_secs_f64());
        core.record(Happening::warning("BackOff", &step.target, message).of(system));
    }
    forget_held(core, desired, observed, busy);
    any
}

/// What is held stays down on purpose: when it is let go, its start is no restart of something that has died.
fn forget_held(core: &Core, desired: &Desired, observed: &Observed, busy: &BTreeSet<String>) {
    for (node, answer) in &observed.nodes {
        let NodeObserved::Known(inventory) = answer else {
            continue;
        };
        let held = inventory.held.iter();
        for held in held.filter(|held| !busy.contains(&held.system.uid)) {
            let uid = &held.system.uid;
            let component = target::component(&held.instance);
            let mut backoff = core.backoff();
            backoff.went(&Brought::new(node, uid, &component));
            let Some(manager) = seat(desired, node, &held.system, &held.instance) else {
                continue;
            };
            if found(observed, node, &manager) == Some(None) {
                backoff.went(&Brought::new(node, uid, &target::manager(&manager)));
            }
        }
    }
}

/// The process that a component belongs to.
fn seat(desired: &Desired, node: &str, system: &SystemRef, instance: &str) -> Option<ManagerKey> {
    let parts = &desired.nodes.get(node)?.systems;
    let part = parts.iter().find(|part| part.system.uid == system.uid)?;
    let mut components = part.components.iter();
    let placed = components.find(|c| c.spec.instance == instance)?;
    Some(ManagerKey {
        system: Some(part.system.clone()),
        name: placed.manager.clone(),
    })
}

/// The manager as observed; none when its node is unknown, `Some(None)` when it is not there.
fn found<'a>(
    observed: &'a Observed,
    node: &str,
    key: &ManagerKey,
) -> Option<Option<&'a ManagerObserved>> {
    match observed.nodes.get(node) {
        Some(NodeObserved::Known(inventory)) => {
            Some(inventory.managers.iter().find(|m| m.key == *key))
        }
        _ => None,
    }
}
