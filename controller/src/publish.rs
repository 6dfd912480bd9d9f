//! Turns what is stored, planned and observed into the objects that clients see. Decides nothing.

mod components;
mod composites;
mod conditions;
mod connectors;
pub mod drift;
mod managers;
mod nodes;
pub mod system;
mod waiting;

use std::collections::BTreeMap;

use rts_agent_api::messages::LedgerFence;
use rts_controller_api::API_VERSION;
use rts_controller_api::objects::{Component, Connector, Kind, Manager, Metadata, Object, System};
use rts_plan::observed::{Inventory, NodeObserved};

use crate::core::{Core, Registry, World};
use crate::ledger::Standing;
use crate::sessions::NodeEntry;
use crate::view::Resource;

/// Everything that objects are made of.
pub struct Scene<'a> {
    registry: &'a Registry,
    world: &'a World,
    nodes: &'a BTreeMap<String, NodeEntry>,
    /// Node → reason, message and ledger, where the store and the node's ledger do not agree.
    fenced: BTreeMap<String, Fenced>,
    /// What was changed by hand.
    drifts: drift::Drifts<'a>,
    /// Target → why it does not go on.
    reasons: BTreeMap<String, waiting::Reason>,
    /// Inventory of each node, and whether it is from the last observation.
    inventories: BTreeMap<&'a str, (&'a Inventory, bool)>,
}

/// Why nothing is sent to a node.
struct Fenced {
    reason: &'static str,
    message: String,
    ledger: Option<LedgerFence>,
}

/// Publishes all objects.
pub fn all(core: &Core) {
    let fenced = fenced(core);
    let registry = core.registry().clone();
    let nodes = core.sessions.all();
    let world = core.world();
    let backoff = core.backoff();
    let scene = Scene {
        drifts: drift::by_target(&world.plan.drift),
        reasons: waiting::reasons(&world, &backoff, &nodes),
        inventories: inventories(&world, &nodes),
        registry: &registry,
        world: &world,
        nodes: &nodes,
        fenced,
    };
    core.view.replace(nodes::nodes(&scene));
    let before = |key: &str| core.view.get(key);
    let mut components = components::components(&scene, before);
    components.extend(composites::composites(&scene, &components));
    let system = |component: &Component| component.spec.system.clone();
    core.view.replace(settled(core, components, system));
    let system = |connector: &Connector| connector.spec.system.clone();
    let connectors = connectors::connectors(&scene);
    core.view.replace(settled(core, connectors, system));
    let system = |manager: &Manager| manager.spec.system.clone();
    core.view
        .replace(settled(core, managers::managers(&scene), system));
    let now = core.clock.now();
    let systems: Vec<_> = registry
        .systems
        .values()
        .filter(|record| !registry.pending.contains(record.name()))
        .map(|record| {
            let before = core.view.get(record.name());
            system::system(&scene, &backoff, record, before.as_ref(), now)
        })
        .collect();
    let system = |system: &System| system.metadata.name.clone();
    core.view.replace(settled(core, systems, system));
}

/// These objects, but for those of systems whose last change is not durable: they stay as they were shown last.
fn settled<T: Resource>(core: &Core, mut objects: Vec<T>, of: impl Fn(&T) -> String) -> Vec<T> {
    let pending = core.registry().pending.clone();
    if pending.is_empty() {
        return objects;
    }
    objects.retain(|object| !pending.contains(&of(object)));
    let before = core.view.list::<T>().items.into_iter();
    objects.extend(before.filter(|object| pending.contains(&of(object))));
    objects
}

/// Nodes with whose ledgers the store does not agree.
fn fenced(core: &Core) -> BTreeMap<String, Fenced> {
    let standings = Standing::all(core).into_iter();
    let fenced = standings.filter_map(|(node, standing)| {
        let fenced = Fenced {
            reason: standing.reason()?,
            message: standing.message(core, &node)?,
            ledger: standing.ledger().cloned(),
        };
        Some((node, fenced))
    });
    fenced.collect()
}

/// What was last seen of every node: as observed, or, of an unknown node, before that.
fn inventories<'a>(
    world: &'a World,
    nodes: &'a BTreeMap<String, NodeEntry>,
) -> BTreeMap<&'a str, (&'a Inventory, bool)> {
    let mut all: BTreeMap<&str, (&Inventory, bool)> = nodes
        .iter()
        .map(|(node, entry)| (node.as_str(), (&entry.inventory, entry.unsure())))
        .collect();
    for (node, answer) in &world.observed.nodes {
        let lost = nodes.get(node).is_some_and(|entry| entry.lost);
        if let (NodeObserved::Known(inventory), false) = (answer, lost) {
            all.insert(node, (inventory, true));
        }
    }
    all
}

/// An object without labels.
fn object<Spec, Status>(
    kind: Kind,
    metadata: Metadata,
    spec: Spec,
    status: Status,
) -> Object<Spec, Status> {
    Object {
        api_version: API_VERSION.to_owned(),
        kind,
        metadata,
        spec,
        status,
    }
}
