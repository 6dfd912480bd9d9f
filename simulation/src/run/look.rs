//! Whether all that really runs is what users want, and what is not.

use std::collections::{BTreeMap, BTreeSet};

use rts_controller_api::objects::{Phase, System};
use rts_manager_api::control::ComponentInfo;
use rts_plan::observed::NodeObserved;
use rts_schemas::system::{ComponentSpec, OnHang, SystemSpec};

use super::wish::Wish;
use crate::machine::Really;
use crate::workload::node_of;
use crate::world::World;

/// What is not as it should be, in words; by system, with an empty name for what belongs to none.
pub(super) type Wrongs = BTreeMap<String, Vec<String>>;

/// All processes that live, with their nodes.
fn really(world: &World) -> Vec<(&str, Really)> {
    let nodes = world.nodes.iter();
    nodes
        .flat_map(|(name, node)| {
            let processes = node.machine.really().into_iter();
            processes.map(|process| (name.as_str(), process))
        })
        .collect()
}

/// Everything that is not as it should be.
pub(super) fn wrongs(world: &World, wishes: &BTreeMap<String, Wish>) -> Wrongs {
    let processes = really(world);
    let mut wrongs = Wrongs::new();
    for (name, wish) in wishes {
        let mut of = shown(world, name, wish);
        if wish.wanted {
            let missing = wish.spec.components.iter();
            of.extend(missing.filter_map(|component| wrong(component, &wish.spec, &processes)));
        }
        if !of.is_empty() {
            wrongs.insert(name.clone(), of);
        }
    }
    let mut strange = strangers(&processes, wishes);
    if !strange.is_empty() {
        wrongs
            .entry(String::new())
            .or_default()
            .append(&mut strange);
    }
    wrongs
}

/// What the controller says of a system.
fn shown(world: &World, name: &str, wish: &Wish) -> Vec<String> {
    let Some(core) = world.hosts.controller() else {
        return vec!["there is no controller".to_owned()];
    };
    match (core.view.get::<System>(name), wish.wanted) {
        (None, false) => Vec::new(),
        (None, true) => vec!["the controller does not know it".to_owned()],
        (Some(_), false) => vec!["it is still there".to_owned()],
        (Some(system), true) => {
            let status = &system.status;
            let planned = status.observed_generation == system.metadata.generation;
            if planned && status.phase == Phase::Converged && status.synced && status.healthy {
                return Vec::new();
            }
            let mut words = vec![format!(
                "it is {:?} at generation {} of {}, synced {}, healthy {}",
                status.phase,
                status.observed_generation,
                system.metadata.generation,
                status.synced,
                status.healthy
            )];
            let waiting = status.waiting_on.iter();
            words.extend(waiting.map(|w| format!("{} waits: {}", w.target, w.reason)));
            words
        }
    }
}

/// What is wrong with one component.
fn wrong(
    wanted: &ComponentSpec,
    spec: &SystemSpec,
    processes: &[(&str, Really)],
) -> Option<String> {
    let name = &wanted.instance;
    let mut found = Vec::new();
    for (node, process) in processes {
        for component in &process.inventory.components {
            if component.instance == *name && component.system.is_some() {
                found.push((*node, process, component));
            }
        }
    }
    let [(node, process, component)] = &found[..] else {
        return Some(format!("{name} runs {} times", found.len()));
    };
    if *node != node_of(wanted) {
        return Some(format!("{name} runs on {node}"));
    }
    if !process.answers {
        return Some(format!("the process of {name} does not answer"));
    }
    if component.state != "Active" {
        return Some(format!("{name} is {}", component.state));
    }
    unlike(wanted, spec, component)
}

/// What a component has that its spec does not say, or the other way round.
fn unlike(wanted: &ComponentSpec, spec: &SystemSpec, component: &ComponentInfo) -> Option<String> {
    let name = &wanted.instance;
    for (set, values) in &wanted.configuration.sets {
        for (parameter, value) in values {
            let real = component.sets.get(set).and_then(|set| set.get(parameter));
            if real != Some(value) {
                return Some(format!("{name}.{parameter} is {real:?}, not {value}"));
            }
        }
    }
    if wanted
        .execution_context
        .rate
        .is_some_and(|rate| rate != component.rate)
    {
        return Some(format!("{name} has {} Hz", component.rate));
    }
    let own = spec
        .connectors
        .iter()
        .filter(|c| c.source.instance == *name);
    let own: BTreeSet<&str> = own.map(|c| c.name.as_str()).collect();
    let real: BTreeMap<&str, &str> = component
        .connectors
        .iter()
        .map(|c| (c.name.as_str(), c.state.as_str()))
        .collect();
    for connector in &own {
        let state = real.get(connector).copied().unwrap_or("not there");
        if state != "Connected" {
            return Some(format!("{connector} is {state}"));
        }
    }
    let mut names = real.keys();
    let strange = names.find(|connector| !own.contains(*connector));
    let strange = strange.map(|connector| format!("{connector} is there and nobody wants it"));
    strange.or_else(|| left_end(spec, component))
}

/// An in-port end of a component that no connector of its system has.
fn left_end(spec: &SystemSpec, component: &ComponentInfo) -> Option<String> {
    let name = &component.instance;
    let wanted = |connector: &str| {
        let mut all = spec.connectors.iter();
        all.any(|c| c.name == connector && c.target.instance == *name)
    };
    let mut ends = component.bindings.iter();
    let left = ends.find(|end| !wanted(&end.connector))?;
    let connector = &left.connector;
    Some(format!(
        "{name} has an end of {connector}, and nobody wants it"
    ))
}

/// Components and processes that nobody wants.
fn strangers(processes: &[(&str, Really)], wishes: &BTreeMap<String, Wish>) -> Vec<String> {
    let wanted = |system: &str, instance: &str| {
        let wish = wishes.get(system).filter(|wish| wish.wanted);
        wish.is_some_and(|wish| wish.spec.components.iter().any(|c| c.instance == instance))
    };
    let mut strange = Vec::new();
    for (node, process) in processes {
        let name = process.key.display_name();
        if process.inventory.components.is_empty() {
            strange.push(format!("the process of {name} on {node} has nothing in it"));
        }
        for component in &process.inventory.components {
            let system = component.system.as_ref().map_or("", |s| s.name.as_str());
            if !wanted(system, &component.instance) {
                strange.push(format!("{} runs on {node} in {name}", component.instance));
            }
        }
    }
    strange
}

/// What waits for a module whose file is another than when the system was applied: code that nobody applied is not run.
fn exchanged(system: System) -> Option<String> {
    let mut waiting = system.status.waiting_on.into_iter();
    let waits = waiting.find(|w| w.reason.contains("changed since the system was applied"))?;
    Some(format!("{} was exchanged without an apply", waits.target))
}

/// Why a system that is not well stays so until a user does something, as its policies say; none when it must come to
/// be well by itself.
pub(super) fn excuse(world: &World, wish: &Wish) -> Option<String> {
    let components = &wish.spec.components;
    let of = |name: &str| components.iter().find(|c| c.instance == name);
    let core = world.hosts.controller()?;
    let shown = core.view.get::<System>(&wish.spec.name);
    if let Some(exchanged) = shown.and_then(exchanged) {
        return Some(exchanged);
    }
    let observed = core.world().observed.clone();
    let known = observed.nodes.values().filter_map(|node| match node {
        NodeObserved::Known(inventory) => Some(inventory),
        NodeObserved::Unknown { .. } => None,
    });
    for inventory in known {
        let mut held = inventory.held.iter();
        if let Some(held) = held.find(|held| of(&held.instance).is_some()) {
            return Some(format!("{} is held", held.instance));
        }
        for manager in &inventory.managers {
            let mut own = manager
                .components
                .iter()
                .filter_map(|c| Some((c, of(&c.instance)?)));
            if !manager.responsive
                && own
                    .clone()
                    .all(|(_, spec)| spec.policy.on_hang == OnHang::Report)
            {
                return Some(format!("{} hangs", manager.key.display_name()));
            }
            let stays = own.find(|(component, spec)| {
                let policy = &spec.policy;
                let error = component.state == rts_plan::observed::LifeCycleState::Error;
                (error && !policy.reset_on_error)
                    || (component.hangs.is_some() && policy.on_hang == OnHang::Report)
            });
            if let Some((component, _)) = stays {
                let state = component.state;
                return Some(format!("{} is {state:?} or hangs", component.instance));
            }
        }
    }
    None
}
