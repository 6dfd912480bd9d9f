//! How it ended.

use std::collections::BTreeSet;

use rts_controller::Core;
use rts_controller_api::objects::{Component, Connector, Node, Phase, System};
use rts_controller_api::simulate::{SimulatedComponent, SimulatedEnd, SimulatedSystem, Undone};
use rts_plan::target;

use super::record::Record;

/// The applied system, and its generation once that is known.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// Systems that must be there.
    pub systems: BTreeSet<String>,
    /// What was acknowledged.
    pub applied: Option<(String, u64)>,
}

/// True when all is as it is wanted to be, as the controller sees it.
pub fn converged(core: &Core, wanted: &Wanted) -> bool {
    let systems = core.view.list::<System>().items;
    let good = |name: &String| {
        systems
            .iter()
            .any(|s| s.metadata.name == *name && is_good(s, wanted))
    };
    wanted.applied.is_some() && wanted.systems.iter().all(good)
}

fn is_good(system: &System, wanted: &Wanted) -> bool {
    let (status, meta) = (&system.status, &system.metadata);
    let least = match &wanted.applied {
        Some((name, generation)) if *name == meta.name => *generation,
        _ => 0,
    };
    status.synced
        && status.healthy
        && status.phase == Phase::Converged
        && status.observed_generation == meta.generation
        && meta.generation >= least
}

/// Everything as it is in the end; without a controller, what can be said.
pub fn end(core: Option<&Core>, wanted: &Wanted, record: &Record) -> SimulatedEnd {
    let mut end = SimulatedEnd {
        converged: false,
        converged_ms: None,
        simulated_ms: 0,
        systems: Vec::new(),
        components: Vec::new(),
        undone: Vec::new(),
    };
    let mut undone = |object: &str, reason: &str| {
        end.undone.push(Undone {
            object: object.to_owned(),
            reason: reason.to_owned(),
        });
    };
    let Some(core) = core else {
        undone(
            "controller",
            "it is down: nothing is decided or seen until it is started again",
        );
        return end;
    };
    let systems = core.view.list::<System>().items;
    for name in &wanted.systems {
        let found = systems.iter().find(|s| s.metadata.name == *name);
        match found {
            None => undone(&format!("system/{name}"), "it was not stored"),
            Some(system) if !is_good(system, wanted) => {
                let status = &system.status;
                for waits in &status.waiting_on {
                    undone(&waits.target, &waits.reason);
                }
                if status.waiting_on.is_empty() {
                    undone(&format!("system/{name}"), &why(system));
                }
            }
            Some(_) => {}
        }
    }
    for node in core.view.list::<Node>().items {
        if node.status.state != "Ready" {
            let reason = node
                .status
                .message
                .as_deref()
                .unwrap_or("its agent is not heard");
            let text = format!("it is {}: {reason}", node.status.state);
            undone(&target::node(&node.metadata.name), &text);
        }
    }
    for connector in core.view.list::<Connector>().items {
        if connector.status.state != "Connected" {
            let name = target::connector(&connector.metadata.name);
            undone(&name, &format!("it is {}", connector.status.state));
        }
    }
    let mut seen = BTreeSet::new();
    end.undone
        .retain(|undone| seen.insert(undone.object.clone()));
    end.systems = systems
        .iter()
        .map(|system| SimulatedSystem {
            name: system.metadata.name.clone(),
            synced: system.status.synced,
            healthy: system.status.healthy,
        })
        .collect();
    let components = core.view.list::<Component>().items.into_iter();
    end.components = components
        .map(|component| shown(component, record))
        .collect();
    end
}

/// What the conditions of a system say that are not met.
fn why(system: &System) -> String {
    let unmet = system.status.conditions.iter().filter(|condition| {
        let wanted = matches!(condition.kind.as_str(), "Synced" | "Healthy");
        wanted && condition.status != "True" && !condition.message.is_empty()
    });
    let said: Vec<&str> = unmet.map(|condition| condition.message.as_str()).collect();
    match said.as_slice() {
        [] => format!("it is {:?}", system.status.phase),
        said => said.join("; "),
    }
}

fn shown(component: Component, record: &Record) -> SimulatedComponent {
    let name = component.metadata.name;
    SimulatedComponent {
        restarts: record.restarts(&name),
        name,
        system: Some(component.spec.system).filter(|system| !system.is_empty()),
        node: component.status.node,
        manager: component.status.manager,
        state: component.status.state,
    }
}
