//! Placement: which node and which manager process each component of each stored system goes to.
//!
//! A node that is named outright wins, then a host hint that matches a node, then the local node. Nothing is left for
//! an executor to choose.

mod context;
mod elsewhere;
mod nodes;

use std::collections::{BTreeMap, BTreeSet};

use rts_schemas::names;
use rts_schemas::stand_in::{Ends, Shape};
use rts_schemas::system::{ComponentSpec, ConnectorSpec, PortKind, PortRef, SystemSpec};
use serde_json::json;
use sha2::{Digest, Sha256};

use crate::desired::{
    Desired, EndPlace, NodeSpec, NodeSystem, PlacedComponent, PlacedConnector, SystemRef,
};

pub use self::context::Context;
use self::elsewhere::{elsewhere, may_still_run};
pub use self::nodes::Hosts;
use self::nodes::choose_nodes;

/// Manager of components that name none.
pub const DEFAULT_MANAGER: &str = "main";

/// Stand-ins, and remarks on them, that a note names.
const NAMED: usize = 20;

/// What placement must know of a node.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct NodeFacts {
    /// Node name.
    pub name: String,
    /// Host names and addresses that mean this node.
    pub aliases: Vec<String>,
}

/// A system as the controller stores it.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredSystem {
    /// Name and identity.
    pub reference: SystemRef,
    /// What was applied last.
    pub spec: SystemSpec,
    /// Type name → SHA-256 of the module file found when it was applied.
    pub module_digests: BTreeMap<String, String>,
    /// Instance → what the stand-in is made of that takes its place, as it was decided when it was applied.
    pub stand_ins: BTreeMap<String, Shape>,
    /// Its end was asked for: it runs nothing any more.
    pub deleting: bool,
}

/// What was settled of a stored system when it was admitted; nothing is settled of one that is only looked at.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Settled {
    /// Its generation.
    pub generation: u64,
    /// Instance → node that was chosen. It holds until the system is admitted again, whatever hosts mean by then: a
    /// node whose agent has not greeted yet is no reason to go elsewhere.
    pub places: BTreeMap<String, String>,
    /// Nodes that it ever ran on: when it goes, each of them is told so.
    pub nodes: BTreeSet<String>,
    /// Instance → nodes that it was moved away from and where it may still run.
    pub left: BTreeMap<String, BTreeSet<String>>,
}

/// Result of [`place`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Placed {
    /// Every node's spec. Every known node is there, so that one which lost its last component is told so.
    pub desired: Desired,
    /// System name → remarks for people: which host went where.
    pub notes: BTreeMap<String, Vec<String>>,
    /// What an apply is refused for. `desired` is usable all the same: a component on an unknown node stays there and
    /// waits, so that one bad system never holds up, or tears down, another.
    pub problems: Vec<PlaceError>,
}

impl Placed {
    /// The first problem as an error; for callers that must refuse rather than go on.
    pub fn accept(mut self) -> Result<Self, PlaceError> {
        if self.problems.is_empty() {
            Ok(self)
        } else {
            Err(self.problems.swap_remove(0))
        }
    }
}

/// Why a system cannot be placed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlaceError {
    /// `rtsctl.node` names a node that nobody knows.
    #[error(
        "component {component} of system {system} is to run on node {node}, which is not known (known: {})",
        known.join(", ")
    )]
    UnknownNode {
        /// System name.
        system: String,
        /// Instance name.
        component: String,
        /// Node that was named.
        node: String,
        /// Names of the nodes that there are.
        known: Vec<String>,
    },
    /// Two systems want the same instance name on one node.
    #[error("instance {instance} on node {node} is wanted by two systems: {} and {}", systems[0], systems[1])]
    InstanceClash {
        /// Node name.
        node: String,
        /// Instance name.
        instance: String,
        /// Names of both systems, sorted.
        systems: [String; 2],
    },
    /// Components that are to share an execution context are in different processes.
    #[error(
        "components {} and {} of system {system} share the execution context {context}, which needs one process, but are to run in {} and {}",
        components[0], components[1], places[0], places[1]
    )]
    ContextApart {
        /// System name.
        system: String,
        /// Name of the execution context.
        context: String,
        /// Instance names.
        components: Box<[String; 2]>,
        /// Process of each, as `NODE/MANAGER`.
        places: Box<[String; 2]>,
    },
}

/// Places all systems, with nothing settled before.
pub fn place(systems: &[StoredSystem], nodes: &[NodeFacts], local: &str) -> Placed {
    place_settled(systems, nodes, local, &BTreeMap::new())
}

/// Places all systems. `settled` is by system uid.
pub fn place_settled(
    systems: &[StoredSystem],
    nodes: &[NodeFacts],
    local: &str,
    settled: &BTreeMap<String, Settled>,
) -> Placed {
    let mut placed = Placed::default();
    let names = nodes.iter().map(|n| n.name.as_str()).chain([local]);
    for name in names {
        node_spec(&mut placed.desired, name);
    }
    let mut sorted: Vec<&StoredSystem> = systems.iter().collect();
    sorted.sort_by(|a, b| a.reference.cmp(&b.reference));
    let hosts = Hosts::new(nodes, local);
    let nothing = Settled::default();
    for system in &sorted {
        let settled = settled.get(&system.reference.uid).unwrap_or(&nothing);
        place_system(&mut placed, system, settled, &hosts, local);
    }
    find_clashes(&mut placed);
    placed
}

fn node_spec<'a>(desired: &'a mut Desired, node: &str) -> &'a mut NodeSpec {
    desired
        .nodes
        .entry(node.to_owned())
        .or_insert_with(|| NodeSpec {
            node: node.to_owned(),
            systems: Vec::new(),
        })
}

fn place_system(
    placed: &mut Placed,
    system: &StoredSystem,
    settled: &Settled,
    hosts: &Hosts,
    local: &str,
) {
    let nodes = choose_nodes(placed, system, settled, hosts, local);
    let managers = choose_managers(&system.spec, &nodes);
    let place_of = |instance: &str| -> Option<EndPlace> {
        Some(EndPlace {
            node: nodes.get(instance)?.clone(),
            manager: managers.get(instance)?.clone(),
        })
    };
    if !system.deleting {
        let apart = contexts_apart(system, place_of);
        placed.problems.extend(apart);
    }
    let empty = || NodeSystem {
        system: system.reference.clone(),
        generation: settled.generation,
        components: Vec::new(),
        connectors: Vec::new(),
        orders: system.spec.orders.clone(),
        elsewhere: BTreeMap::new(),
    };
    let shapes = &system.stand_ins;
    if !shapes.is_empty() && !system.deleting {
        let notes = placed.notes.entry(system.reference.name.clone());
        notes.or_default().extend(tell(system));
    }
    let mut parts: BTreeMap<&str, NodeSystem> = BTreeMap::new();
    if system.deleting {
        parts.extend(settled.nodes.iter().map(|node| (node.as_str(), empty())));
    }
    for component in &system.spec.components {
        let node = &nodes[component.instance.as_str()];
        let part = parts.entry(node).or_insert_with(empty);
        if !system.deleting {
            let manager = managers[component.instance.as_str()].clone();
            part.components
                .push(place_component(system, component, manager));
        }
    }
    for connector in &system.spec.connectors {
        // Who provides a service to whom matters to the end of a system, and nobody observes it.
        if !system.deleting || connector.kind == PortKind::Service {
            place_connector(&mut parts, connector, |end| place_of(&end.instance), shapes);
        }
    }
    let named = elsewhere::named(&system.spec, &nodes);
    for (node, mut part) in parts {
        if !system.deleting {
            part.elsewhere = elsewhere(&named, node);
            may_still_run(&mut part, node, &settled.left);
        }
        node_spec(&mut placed.desired, node).systems.push(part);
    }
}

/// The first of each execution context's components that is not where the first is.
fn contexts_apart(
    system: &StoredSystem,
    place_of: impl Fn(&str) -> Option<EndPlace>,
) -> Vec<PlaceError> {
    let mut first: BTreeMap<&str, (&str, EndPlace)> = BTreeMap::new();
    let mut apart = BTreeMap::new();
    for component in &system.spec.components {
        let (Some(context), Some(place)) = (
            component.execution_context.name.as_deref(),
            place_of(&component.instance),
        ) else {
            continue;
        };
        let instance = component.instance.as_str();
        let (other, there) = first.entry(context).or_insert((instance, place.clone()));
        if *there != place {
            let called = |place: &EndPlace| format!("{}/{}", place.node, place.manager);
            apart.entry(context).or_insert(PlaceError::ContextApart {
                system: system.reference.name.clone(),
                context: context.to_owned(),
                components: Box::new([(*other).to_owned(), instance.to_owned()]),
                places: Box::new([called(there), called(&place)]),
            });
        }
    }
    apart.into_values().collect()
}

/// Instance → manager name. An isolated component's process is its own even when its name is used for another.
fn choose_managers<'a>(
    spec: &'a SystemSpec,
    nodes: &BTreeMap<&str, String>,
) -> BTreeMap<&'a str, String> {
    let mut managers = BTreeMap::new();
    let mut taken = BTreeSet::new();
    let (isolated, shared): (Vec<_>, Vec<_>) =
        spec.components.iter().partition(|c| c.placement.isolated);
    for component in shared {
        let name = match &component.placement.manager {
            Some(name) => sanitise(name),
            None => DEFAULT_MANAGER.to_owned(),
        };
        taken.insert((nodes[component.instance.as_str()].clone(), name.clone()));
        managers.insert(component.instance.as_str(), name);
    }
    for component in isolated {
        let node = &nodes[component.instance.as_str()];
        let mut name = sanitise(&component.instance);
        while !taken.insert((node.clone(), name.clone())) {
            name = sanitise(&format!("{name}-own"));
        }
        managers.insert(component.instance.as_str(), name);
    }
    managers
}

/// A manager name is part of file names and addresses; [`names::is_manager_name`] is its rule. A name that had to be
/// changed (an isolated component's may hold blanks) gets a few digits of its hash, so that two never fall together.
fn sanitise(name: &str) -> String {
    if names::is_manager_name(name) {
        return name.to_owned();
    }
    let mut near = names::manager_name(name).unwrap_or_else(|| "manager".to_owned());
    near.truncate(50);
    let hash = format!("{:x}", Sha256::digest(name));
    format!("{near}-{}", &hash[..8])
}

/// Names the stand-ins, and what connectors say that they are not.
fn tell(system: &StoredSystem) -> Vec<String> {
    let shapes = &system.stand_ins;
    let all = &system.spec.components;
    let named: Vec<&str> = shapes.keys().take(NAMED).map(String::as_str).collect();
    let more = match shapes.len() - named.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let mut notes = vec![format!(
        "{} of {} components are stand-ins: {}{more}",
        shapes.len(),
        all.len(),
        named.join(", ")
    )];
    let ends = Ends::of(&system.spec);
    let stand_ins = all.iter().filter(|c| shapes.contains_key(&c.instance));
    notes.extend(stand_ins.flat_map(|c| ends.disagreements(c)).take(NAMED));
    notes
}

fn place_component(
    system: &StoredSystem,
    component: &ComponentSpec,
    manager: String,
) -> PlacedComponent {
    let stand_in = system.stand_ins.get(&component.instance).cloned();
    // A stand-in needs no module.
    let pinned = system.module_digests.get(&component.type_name);
    let module_digest = pinned.filter(|_| stand_in.is_none()).cloned();
    let recreate_hash = recreate_hash(
        &component.type_name,
        module_digest.as_deref(),
        &manager,
        &Context::of(component, stand_in.is_some()),
        stand_in.as_ref(),
    );
    PlacedComponent {
        spec: component.clone(),
        manager,
        module_digest,
        stand_in,
        recreate_hash,
    }
}

/// Puts a connector into the parts of both its ends. One without an end in the system is the checks' business.
fn place_connector(
    parts: &mut BTreeMap<&str, NodeSystem>,
    connector: &ConnectorSpec,
    place_of: impl Fn(&PortRef) -> Option<EndPlace>,
    shapes: &BTreeMap<String, Shape>,
) {
    let (Some(source), Some(target)) = (place_of(&connector.source), place_of(&connector.target))
    else {
        return;
    };
    let undetermined = [&connector.source, &connector.target]
        .into_iter()
        .find_map(|end| {
            let why = shapes.get(&end.instance)?.undetermined(&end.port)?;
            Some(format!("port {end} of a stand-in is undetermined: {why}"))
        });
    for node in BTreeSet::from([source.node.as_str(), target.node.as_str()]) {
        if let Some(part) = parts.get_mut(node) {
            part.connectors.push(PlacedConnector {
                spec: connector.clone(),
                source: source.clone(),
                target: target.clone(),
                undetermined: undetermined.clone(),
            });
        }
    }
}

fn find_clashes(placed: &mut Placed) {
    for (node, spec) in &placed.desired.nodes {
        let mut seen: BTreeMap<&str, &str> = BTreeMap::new();
        for system in &spec.systems {
            for component in &system.components {
                let instance = component.spec.instance.as_str();
                let name = system.system.name.as_str();
                if let Some(other) = seen.insert(instance, name) {
                    placed.problems.push(PlaceError::InstanceClash {
                        node: node.clone(),
                        instance: instance.to_owned(),
                        systems: [other.to_owned(), name.to_owned()],
                    });
                }
            }
        }
    }
}

/// Hash over what cannot change in place. 16 hexadecimal digits.
pub fn recreate_hash(
    type_name: &str,
    module_digest: Option<&str>,
    manager: &str,
    context: &Context,
    stand_in: Option<&Shape>,
) -> String {
    let mut parts = vec![
        json!(type_name),
        json!(module_digest),
        json!(manager),
        json!(context.kind),
    ];
    parts.extend(stand_in.map(|shape| json!(shape)));
    // Its order can change in place. What asks for nothing keeps the hash that it had before there was anything to ask for.
    let shared = context.shared.as_ref();
    let named =
        shared.map(|shared| json!({"executionContext": [shared.name, shared.shared_state]}));
    let realtime = context.realtime.as_ref();
    let realtime = realtime.map(|realtime| json!({"realtime": realtime}));
    parts.extend(named.into_iter().chain(realtime));
    let text = serde_json::Value::from(parts).to_string();
    let mut hash = format!("{:x}", Sha256::digest(text));
    hash.truncate(16);
    hash
}

/// SHA-256 over the canonical JSON of a node's spec, hexadecimal: fields in the order of the type, maps sorted.
pub fn digest(spec: &NodeSpec) -> String {
    digest_of(spec)
}

pub(crate) fn digest_of(part: &impl serde::Serialize) -> String {
    // Nothing in a NodeSpec can fail to become JSON: maps have text keys, and a rate that is not finite becomes null.
    let json = serde_json::to_vec(part).unwrap_or_default();
    format!("{:x}", Sha256::digest(json))
}

#[cfg(test)]
mod tests;
