//! Turns what is stored, planned and observed into the objects that clients see. Decides nothing.

mod components;
mod composites;
mod conditions;
mod connectors;
pub mod drift;
mod managers;
mod nodes;
mod shown;
pub mod system;
mod waiting;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rts_agent_api::messages::LedgerFence;
use rts_controller_api::API_VERSION;
use rts_controller_api::objects::{Kind, Metadata, Object};
use rts_plan::observed::{Inventory, NodeObserved};

use crate::core::{Core, World};
use crate::ledger::Standing;
use crate::sessions::NodeEntry;
use crate::store::Records;
use crate::view::Resource;

pub use self::shown::Shown;

/// Everything that objects are made of.
pub struct Scene<'a> {
    systems: &'a Records,
    /// Systems by name whose last change is not durable: what is shown of them stays.
    pending: &'a BTreeSet<String>,
    world: &'a World,
    nodes: &'a BTreeMap<String, NodeEntry>,
    /// Node → reason, message and ledger, where the store and the node's ledger do not agree.
    fenced: BTreeMap<String, Fenced>,
    /// What was changed by hand.
    drifts: drift::Drifts<'a>,
    /// Target → why it does not go on.
    reasons: BTreeMap<String, waiting::Reason>,
    /// Inventory of each node, and whether it is from the last observation.
    inventories: Inventories<'a>,
}

/// Inventory of each node, and whether it is from the last observation.
type Inventories<'a> = BTreeMap<&'a str, (&'a Arc<Inventory>, bool)>;

/// Why nothing is sent to a node.
struct Fenced {
    reason: &'static str,
    message: String,
    ledger: Option<LedgerFence>,
}

/// Publishes all objects. Those of nodes of which nothing else is known than the last time are not made anew.
pub fn all(core: &Core) {
    let fenced = fenced(core);
    let (systems, pending) = {
        let registry = core.registry();
        (registry.systems.clone(), registry.pending.clone())
    };
    let nodes = core.sessions.all();
    let mut shown = core.shown();
    let world = core.world();
    let backoff = core.backoff();
    let scene = Scene {
        drifts: drift::by_target(&world.plan.drift),
        reasons: waiting::reasons(&world, &backoff, &nodes),
        inventories: inventories(&world, &nodes),
        systems: &systems,
        pending: &pending,
        world: &world,
        nodes: &nodes,
        fenced,
    };
    core.view.replace(nodes::nodes(&scene));
    shown.show(core, &scene);
    let now = core.clock.now();
    let systems: Vec<_> = systems
        .values()
        .filter(|record| !pending.contains(record.name()))
        .map(|record| {
            let before = core.view.get(record.name());
            system::system(&scene, &backoff, record, before.as_ref(), now)
        })
        .collect();
    core.view
        .replace(settled(core, &scene, systems, |s| &s.metadata.name));
}

/// These objects, but for those of systems whose last change is not durable: they stay as they were shown last.
fn settled<T: Resource>(
    core: &Core,
    scene: &Scene<'_>,
    mut objects: Vec<T>,
    of: impl Fn(&T) -> &String,
) -> Vec<T> {
    if scene.pending.is_empty() {
        return objects;
    }
    objects.retain(|object| !scene.pending.contains(of(object)));
    let before = core.view.list::<T>().items.into_iter();
    objects.extend(before.filter(|object| scene.pending.contains(of(object))));
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
fn inventories<'a>(world: &'a World, nodes: &'a BTreeMap<String, NodeEntry>) -> Inventories<'a> {
    let mut all: Inventories<'_> = nodes
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
