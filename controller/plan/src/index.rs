//! Desired and observed state, indexed: every later part looks things up here and never scans.
//!
//! Components, processes and connectors are numbered once ([`names`]), so that every map over them is a table.

mod names;

use std::collections::{BTreeMap, BTreeSet};

use rts_schemas::system::{OnDisconnect, Orders, PortKind};
use rustc_hash::FxHashMap;

pub(crate) use self::names::{Id, Keys, LinkId, Seat};
use self::names::{Ids, LinkIds, Seats};
use crate::desired::{
    Desired, Elsewhere, ManagerKey, NodeSystem, PlacedComponent, PlacedConnector, SystemRef,
};
use crate::observed::{
    ComponentObserved, ConnectorObserved, Held, Inventory, ManagerObserved, NodeObserved, Observed,
};
use crate::table::Table;

/// A desired component.
#[derive(Debug)]
pub(crate) struct Want<'a> {
    pub node: &'a str,
    pub system: &'a SystemRef,
    pub placed: &'a PlacedComponent,
    pub key: &'a ManagerKey,
    id: Id<'a>,
    seat: Seat<'a>,
}

impl<'a> Want<'a> {
    pub fn id(&self) -> Id<'a> {
        self.id
    }

    pub fn seat(&self) -> Seat<'a> {
        self.seat
    }

    pub fn on_disconnect(&self) -> OnDisconnect {
        self.placed.spec.policy.on_disconnect
    }
}

/// An observed component. `lives` in [`Facts`] holds all of them; others point there by index.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Live<'a> {
    pub node: &'a str,
    pub manager: &'a ManagerObserved,
    pub component: &'a ComponentObserved,
    id: Option<Id<'a>>,
    seat: Seat<'a>,
}

impl<'a> Live<'a> {
    pub fn id(&self) -> Option<Id<'a>> {
        self.id
    }

    pub fn seat(&self) -> Seat<'a> {
        self.seat
    }
}

/// A desired connector.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Link<'a> {
    pub system: &'a SystemRef,
    pub connector: &'a PlacedConnector,
    /// The components at its source and its target.
    pub ends: [Id<'a>; 2],
}

/// A system's orders, once for all nodes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SystemOrders<'a> {
    pub orders: &'a Orders,
}

/// Everything, indexed.
#[derive(Debug, Default)]
pub(crate) struct Facts<'a> {
    ids: Ids<'a>,
    link_ids: LinkIds<'a>,
    pub wants: Table<Id<'a>, Want<'a>>,
    /// Desired connectors.
    pub links: Table<LinkId<'a>, Link<'a>>,
    pub orders: BTreeMap<&'a str, SystemOrders<'a>>,
    /// Components that the orders of a system name and that lie on nodes of which nothing is said here, by its uid.
    pub elsewhere: BTreeMap<&'a str, BTreeMap<&'a str, &'a Elsewhere>>,
    /// Desired components that may still run on another node, of which nothing is said here.
    pub may_run: Table<Id<'a>, &'a str>,
    /// Nodes that were told what to run.
    pub nodes: BTreeSet<&'a str>,
    /// Nodes with something to run, or to stop, that did not answer, and why.
    pub unknown: BTreeMap<&'a str, &'a str>,
    pub processes: Table<Seat<'a>, &'a ManagerObserved>,
    /// Processes of systems that have not said what they hold.
    pub unseen: Vec<(Seat<'a>, &'a ManagerObserved)>,
    pub lives: Vec<Live<'a>>,
    by_id: Table<Id<'a>, Vec<usize>>,
    pub by_name: FxHashMap<(&'a str, &'a str), Vec<usize>>,
    pub by_incarnation: FxHashMap<&'a str, usize>,
    by_seat: Table<Seat<'a>, Vec<usize>>,
    /// Identities of the connectors of all `lives`, one after the other, and where those of each end.
    live_links: Vec<LinkId<'a>>,
    links_end: Vec<usize>,
    /// Processes in which something is desired.
    pub wanted_seats: Table<Seat<'a>, Vec<Id<'a>>>,
    /// By node and component: why its agent does not bring it up again.
    held: BTreeMap<(&'a str, Id<'a>), &'a str>,
    /// Peer → the components that stop without it (`onDisconnect: stop`), with the connector between them.
    pub leans: Table<Id<'a>, Vec<(Id<'a>, &'a str)>>,
    /// Systems with at least one desired component, and their members.
    pub members: BTreeMap<&'a str, Vec<Id<'a>>>,
}

/// Digests of the parts of one node, by system uid; each is made once, and only when it is asked for.
struct Digests<'a> {
    parts: &'a [NodeSystem],
    made: BTreeMap<&'a str, Vec<String>>,
}

impl<'a> Digests<'a> {
    /// True when a component is held under the part of its system that is desired now.
    fn counts(&mut self, held: &'a Held) -> bool {
        let Some(decided) = &held.part else {
            return true;
        };
        let (uid, parts) = (held.system.uid.as_str(), self.parts);
        let made = self.made.entry(uid).or_insert_with(|| {
            let own = parts.iter().filter(|part| part.system.uid == uid);
            own.map(NodeSystem::digest).collect()
        });
        made.contains(decided)
    }
}

impl<'a> Facts<'a> {
    /// `keys` are those of `desired`.
    pub fn new(keys: &'a Keys, desired: &'a Desired, observed: &'a Observed) -> Self {
        let mut facts = Self {
            ids: Ids::of(desired, observed),
            ..Self::default()
        };
        facts.reserve(desired, observed);
        let seats = Seats::of(keys, desired, observed);
        facts.add_desired(desired, &seats);
        facts.add_leans();
        for (node, answer) in &observed.nodes {
            if let NodeObserved::Known(inventory) = answer {
                facts.add_inventory(node, inventory, desired, &seats);
            }
        }
        for (node, spec) in &desired.nodes {
            let reason = match observed.nodes.get(node) {
                Some(NodeObserved::Known(_)) => continue,
                Some(NodeObserved::Unknown { reason }) => reason.as_str(),
                None => "it was not asked",
            };
            if !spec.systems.is_empty() {
                facts.unknown.insert(node, reason);
            }
        }
        facts
    }

    /// Growing step by step would copy everything again and again.
    fn reserve(&mut self, desired: &'a Desired, observed: &Observed) {
        let parts = || desired.nodes.values().flat_map(|spec| &spec.systems);
        let links = parts().map(|part| part.connectors.len()).sum();
        self.links.reserve(links);
        self.link_ids.reserve(parts());
        self.wants.reserve(self.ids.len());
        self.by_id.reserve(self.ids.len());
        let managers = observed.nodes.values().flat_map(|node| match node {
            NodeObserved::Known(inventory) => inventory.managers.as_slice(),
            NodeObserved::Unknown { .. } => &[],
        });
        let components = managers.map(|manager| manager.components.len()).sum();
        self.lives.reserve(components);
        self.links_end.reserve(components);
        self.by_name.reserve(components);
        self.by_incarnation.reserve(components);
    }

    fn add_desired(&mut self, desired: &'a Desired, seats: &Seats<'a>) {
        for (node, spec) in &desired.nodes {
            self.nodes.insert(node);
            for part in &spec.systems {
                let orders = SystemOrders {
                    orders: &part.orders,
                };
                self.orders.entry(&part.system.uid).or_insert(orders);
                for connector in &part.connectors {
                    self.add_link(part, connector);
                }
                for placed in &part.components {
                    self.add_want(node, part, placed, seats);
                }
            }
        }
        for id in self.wants.keys() {
            self.members.entry(id.uid).or_default().push(*id);
        }
        for part in desired.nodes.values().flat_map(|spec| &spec.systems) {
            self.add_elsewhere(part);
        }
    }

    fn add_elsewhere(&mut self, part: &'a NodeSystem) {
        let uid = part.system.uid.as_str();
        for (instance, there) in &part.elsewhere {
            let id = self.ids.get(uid, instance);
            let want = id.filter(|id| self.wants.contains_key(id));
            if let Some(id) = want {
                if !self.nodes.contains(there.node.as_str()) {
                    self.may_run.insert(id, &there.node);
                }
            } else {
                let others = self.elsewhere.entry(uid).or_default();
                others.insert(instance, there);
            }
        }
    }

    fn add_link(&mut self, part: &'a NodeSystem, connector: &'a PlacedConnector) {
        let (uid, spec) = (part.system.uid.as_str(), &connector.spec);
        let ends = [&spec.source, &spec.target].map(|end| self.ids.get(uid, &end.instance));
        if let [Some(source), Some(target)] = ends {
            let link = Link {
                system: &part.system,
                connector,
                ends: [source, target],
            };
            let id = self.link_ids.number(uid, &spec.name);
            self.links.insert(id, link);
        }
    }

    fn add_want(
        &mut self,
        node: &'a str,
        part: &'a NodeSystem,
        placed: &'a PlacedComponent,
        seats: &Seats<'a>,
    ) {
        let id = self.ids.get(&part.system.uid, &placed.spec.instance);
        let seat = seats.wanted(node, &part.system, &placed.manager);
        let (Some(id), Some(seat)) = (id, seat) else {
            return;
        };
        self.wanted_seats.or_default(seat).push(id);
        let want = Want {
            node,
            system: &part.system,
            placed,
            key: seat.1,
            id,
            seat,
        };
        self.wants.insert(id, want);
    }

    fn add_leans(&mut self) {
        let mut leans: Table<Id<'a>, Vec<(Id<'a>, &'a str)>> = Table::default();
        for (key, link) in self.links.iter() {
            let [source, target] = link.ends;
            for (id, peer) in [(source, target), (target, source)] {
                let want = self.wants.get(&id);
                let stops = want.is_some_and(|want| want.on_disconnect() == OnDisconnect::Stop);
                let data = link.connector.spec.kind == PortKind::Data;
                if stops && data && id != peer && self.wants.contains_key(&peer) {
                    leans.or_default(peer).push((id, key.1));
                }
            }
        }
        self.leans = leans;
    }

    fn add_inventory(
        &mut self,
        node: &'a str,
        inventory: &'a Inventory,
        desired: &'a Desired,
        seats: &Seats<'a>,
    ) {
        for manager in &inventory.managers {
            if let Some(seat) = seats.get(node, &manager.key) {
                self.add_process(seat, manager);
            }
        }
        let parts = desired.nodes.get(node);
        let mut digests = Digests {
            parts: parts.map_or(&[], |spec| &spec.systems),
            made: BTreeMap::new(),
        };
        for held in inventory.held.iter().filter(|held| digests.counts(held)) {
            if let Some(id) = self.ids.get(&held.system.uid, &held.instance) {
                self.held.insert((node, id), &held.reason);
            }
        }
    }

    fn add_process(&mut self, seat: Seat<'a>, manager: &'a ManagerObserved) {
        if self.processes.contains_key(&seat) {
            // Its flock makes a second process of one key impossible; an inventory that says so is not acted upon.
            return;
        }
        self.processes.insert(seat, manager);
        if manager.unseen && !manager.responsive && manager.key.system.is_some() {
            self.unseen.push((seat, manager));
        }
        let first = self.lives.len();
        for component in &manager.components {
            let index = self.lives.len();
            let system = component.system.as_ref();
            for connector in &component.connectors {
                let uid = system.map_or("", |system| system.uid.as_str());
                let link = self.link_ids.number(uid, &connector.name);
                self.live_links.push(link);
            }
            self.links_end.push(self.live_links.len());
            let live = Live {
                node: seat.0,
                manager,
                component,
                id: system.and_then(|system| self.ids.get(&system.uid, &component.instance)),
                seat,
            };
            self.lives.push(live);
            if let Some(id) = live.id() {
                self.by_id.or_default(id).push(index);
            }
            let name = (seat.0, component.instance.as_str());
            self.by_name.entry(name).or_default().push(index);
            self.by_incarnation.insert(&component.incarnation, index);
        }
        self.by_seat
            .insert(seat, (first..self.lives.len()).collect());
    }

    /// A component by its names; none for one that is neither desired nor observed.
    pub fn id(&self, uid: &str, instance: &str) -> Option<Id<'a>> {
        self.ids.get(uid, instance)
    }

    /// A connector by its name; none for one that is neither desired nor observed.
    pub fn link(&self, uid: &str, name: &str) -> Option<LinkId<'a>> {
        self.link_ids.get(uid, name)
    }

    /// The connectors of an observed component, with their identities.
    pub fn connectors(
        &self,
        live: usize,
    ) -> impl Iterator<Item = (LinkId<'a>, &'a ConnectorObserved)> {
        let before = live
            .checked_sub(1)
            .and_then(|live| self.links_end.get(live));
        let begin = before.copied().unwrap_or_default();
        let own = self.live_links[begin..self.links_end[live]].iter();
        own.copied().zip(&self.lives[live].component.connectors)
    }

    /// The processes' contents, by index into `lives`.
    pub fn in_seat(&self, seat: &Seat<'a>) -> &[usize] {
        self.by_seat.get(seat).map_or(&[], Vec::as_slice)
    }

    pub fn instances(&self, id: Id<'a>) -> &[usize] {
        self.by_id.get(&id).map_or(&[], Vec::as_slice)
    }

    /// Why a component's agent does not bring it up again; what is there is not held.
    pub fn held(&self, want: &Want<'a>) -> Option<&'a str> {
        let held = self.held.get(&(want.node, want.id())).copied();
        held.filter(|_| self.instances(want.id()).is_empty())
    }

    /// True when anything of a system is desired.
    pub fn has_members(&self, uid: &'a str) -> bool {
        self.members.contains_key(uid)
    }
}
