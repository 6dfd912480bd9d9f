//! What was shown last, and of what it was made: components, connectors and managers of a node of which nothing else is known
//! since are left as they are.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rts_controller_api::objects::{Component, Connector, Manager};
use rts_plan::observed::Inventory;
use rts_plan::plan::Drift;

use super::connectors::Found;
use super::waiting::Reason;
use super::{Scene, components, composites, connectors, managers, settled};
use crate::core::Core;
use crate::placement::Placement;
use crate::store::Records;
use crate::view::Resource;

/// What was shown last.
#[derive(Debug, Default)]
pub struct Shown {
    /// None when all is to be made anew in any case.
    common: Option<Common>,
    nodes: BTreeMap<String, OfNode>,
}

/// What objects of all nodes are made of.
#[derive(Debug)]
struct Common {
    systems: Records,
    placed: Arc<Placement>,
    drift: Vec<Drift>,
    reasons: BTreeMap<String, Reason>,
}

/// What the objects of one node were made of, and their keys.
#[derive(Debug, Default)]
struct OfNode {
    inventory: Option<(Arc<Inventory>, bool)>,
    components: BTreeSet<String>,
    connectors: BTreeSet<String>,
    managers: BTreeSet<String>,
}

impl Shown {
    /// Shows what differs from the last time.
    pub fn show(&mut self, core: &Core, scene: &Scene<'_>) {
        let same = self.common.as_ref().is_some_and(|then| then.is_of(scene));
        let names = names(scene);
        if !same || names.iter().any(|node| !self.nodes.contains_key(*node)) {
            return self.show_all(core, scene);
        }
        let then = |node: &str| self.nodes.get(node).and_then(|n| n.inventory.as_ref());
        let changed = |node: &&str| !is_same(then(node), now(scene, node));
        let changed: BTreeSet<&str> = names.into_iter().filter(changed).collect();
        // What a node's in-ports say is shown with the connectors that lead there.
        let feeders = scene.world.placed.feeders();
        let feeders = changed.iter().filter_map(|node| feeders.get(*node));
        let feeders = feeders.flatten().map(String::as_str);
        let sources = changed.iter().copied().chain(feeders).collect();
        match connectors::of_nodes(scene, &sources) {
            (found, true) => self.show_some(core, scene, &changed, &sources, found),
            _ => self.show_all(core, scene),
        }
    }

    /// Shows what is of the nodes that have changed, and the connectors whose sources are on these nodes.
    fn show_some(
        &mut self,
        core: &Core,
        scene: &Scene<'_>,
        changed: &BTreeSet<&str>,
        sources: &BTreeSet<&str>,
        found: Vec<Found<'_>>,
    ) {
        for node in changed {
            let (components, managers) = of_node(core, scene, node);
            let new = OfNode::of(scene, node, &components, &managers);
            let then = self.nodes.entry((*node).to_owned()).or_default();
            let gone = then.components.difference(&new.components);
            core.view.patch(components, gone.cloned());
            let gone = then.managers.difference(&new.managers);
            core.view.patch(managers, gone.cloned());
            let connectors = std::mem::take(&mut then.connectors);
            *then = OfNode { connectors, ..new };
        }
        let mut keys = keys(&found);
        for node in sources {
            let new = keys.remove(node).unwrap_or_default();
            let then = self.nodes.entry((*node).to_owned()).or_default();
            let gone: Vec<String> = then.connectors.difference(&new).cloned().collect();
            core.view.patch::<Connector>([], gone);
            then.connectors = new;
        }
        core.view
            .patch(found.into_iter().map(|found| found.connector), []);
    }

    /// Makes everything anew.
    fn show_all(&mut self, core: &Core, scene: &Scene<'_>) {
        let names = names(scene);
        let (found, regular) = connectors::of_nodes(scene, &names);
        let (mut all, mut processes) = (Vec::new(), Vec::new());
        let mut keys = keys(&found);
        self.nodes.clear();
        for node in names {
            let (components, managers) = of_node(core, scene, node);
            let mut new = OfNode::of(scene, node, &components, &managers);
            new.connectors = keys.remove(node).unwrap_or_default();
            self.nodes.insert(node.to_owned(), new);
            all.extend(components);
            processes.extend(managers);
        }
        let composites = composites::composites(scene, &all);
        // What composites are made of may be on any node.
        let regular = regular && composites.is_empty() && scene.pending.is_empty();
        self.common = regular.then(|| Common::of(scene));
        all.extend(composites);
        let view = &core.view;
        view.replace(settled(core, scene, all, |c| &c.spec.system));
        let connectors = found.into_iter().map(|found| found.connector).collect();
        view.replace(settled(core, scene, connectors, |c| &c.spec.system));
        view.replace(settled(core, scene, processes, |m| &m.spec.system));
    }
}

impl Common {
    fn of(scene: &Scene<'_>) -> Self {
        Self {
            systems: scene.systems.clone(),
            placed: Arc::clone(&scene.world.placed),
            drift: scene.world.plan.drift.clone(),
            reasons: scene.reasons.clone(),
        }
    }

    fn is_of(&self, scene: &Scene<'_>) -> bool {
        let mut records = self.systems.values().zip(scene.systems.values());
        scene.pending.is_empty()
            && Arc::ptr_eq(&self.placed, &scene.world.placed)
            && self.systems.len() == scene.systems.len()
            && records.all(|(a, b)| Arc::ptr_eq(a, b))
            && self.drift == scene.world.plan.drift
            && self.reasons == scene.reasons
    }
}

impl OfNode {
    fn of(scene: &Scene<'_>, node: &str, components: &[Component], managers: &[Manager]) -> Self {
        Self {
            inventory: now(scene, node).map(|(all, known)| (Arc::clone(all), known)),
            components: components.iter().map(Resource::key).collect(),
            connectors: BTreeSet::new(),
            managers: managers.iter().map(Resource::key).collect(),
        }
    }
}

fn of_node(core: &Core, scene: &Scene<'_>, node: &str) -> (Vec<Component>, Vec<Manager>) {
    let before = |key: &str| core.view.get(key);
    (
        components::of_node(scene, node, before),
        managers::of_node(scene, node),
    )
}

/// Node → keys of connectors.
fn keys<'a>(found: &[Found<'a>]) -> BTreeMap<&'a str, BTreeSet<String>> {
    let mut keys: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for Found { node, connector } in found {
        keys.entry(node).or_default().insert(connector.key());
    }
    keys
}

/// Nodes that have something, or are to have it.
fn names<'a>(scene: &Scene<'a>) -> BTreeSet<&'a str> {
    let desired = scene.world.placed.desired.nodes.keys();
    let seen = scene.inventories.keys().copied();
    desired.map(String::as_str).chain(seen).collect()
}

/// What is known of a node now.
fn now<'a>(scene: &Scene<'a>, node: &str) -> Option<(&'a Arc<Inventory>, bool)> {
    scene.inventories.get(node).copied()
}

/// True when it is the very same.
fn is_same(then: Option<&(Arc<Inventory>, bool)>, now: Option<(&Arc<Inventory>, bool)>) -> bool {
    match (then, now) {
        (Some((then, was_known)), Some((now, is_known))) => {
            Arc::ptr_eq(then, now) && *was_known == is_known
        }
        (then, now) => then.is_none() && now.is_none(),
    }
}
