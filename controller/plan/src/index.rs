//! Desired and observed state, indexed: every later part looks things up here and never scans.

use std::collections::{BTreeMap, BTreeSet};

use rts_schemas::system::{OnDisconnect, Orders, PortKind};

use crate::desired::{
    Desired, ManagerKey, NodeSystem, PlacedComponent, PlacedConnector, SystemRef,
};
use crate::observed::{ComponentObserved, Held, ManagerObserved, NodeObserved, Observed};

/// Identity of a component: system uid and instance name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Id<'a> {
    pub uid: &'a str,
    pub instance: &'a str,
}

/// Identity of a process: node and key.
pub(crate) type Seat<'a> = (&'a str, ManagerKey);

/// A desired component.
#[derive(Debug)]
pub(crate) struct Want<'a> {
    pub node: &'a str,
    pub system: &'a SystemRef,
    pub placed: &'a PlacedComponent,
    pub key: ManagerKey,
}

impl<'a> Want<'a> {
    pub fn id(&self) -> Id<'a> {
        Id {
            uid: &self.system.uid,
            instance: &self.placed.spec.instance,
        }
    }

    pub fn seat(&self) -> Seat<'a> {
        (self.node, self.key.clone())
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
}

impl<'a> Live<'a> {
    pub fn id(&self) -> Option<Id<'a>> {
        self.component.system.as_ref().map(|system| Id {
            uid: &system.uid,
            instance: &self.component.instance,
        })
    }

    pub fn seat(&self) -> Seat<'a> {
        (self.node, self.manager.key.clone())
    }
}

/// A system's orders, once for all nodes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SystemOrders<'a> {
    pub orders: &'a Orders,
}

/// Everything, indexed.
#[derive(Debug, Default)]
pub(crate) struct Facts<'a> {
    pub wants: BTreeMap<Id<'a>, Want<'a>>,
    /// Desired connectors by system uid and name.
    pub links: BTreeMap<(&'a str, &'a str), (&'a SystemRef, &'a PlacedConnector)>,
    pub orders: BTreeMap<&'a str, SystemOrders<'a>>,
    /// Nodes that were told what to run.
    pub nodes: BTreeSet<&'a str>,
    /// Nodes with something to run, or to stop, that did not answer, and why.
    pub unknown: BTreeMap<&'a str, &'a str>,
    pub processes: BTreeMap<Seat<'a>, &'a ManagerObserved>,
    pub lives: Vec<Live<'a>>,
    pub by_id: BTreeMap<Id<'a>, Vec<usize>>,
    pub by_name: BTreeMap<(&'a str, &'a str), Vec<usize>>,
    pub by_incarnation: BTreeMap<&'a str, usize>,
    pub by_seat: BTreeMap<Seat<'a>, Vec<usize>>,
    /// Processes in which something is desired.
    pub wanted_seats: BTreeMap<Seat<'a>, Vec<Id<'a>>>,
    /// By node and component: why its agent does not bring it up again.
    held: BTreeMap<(&'a str, Id<'a>), &'a str>,
    /// Peer → the components that stop without it (`onDisconnect: stop`), with the connector between them.
    pub leans: BTreeMap<Id<'a>, Vec<(Id<'a>, &'a str)>>,
}

/// True when a component is held under the part of its system that is desired now.
fn counts(held: &Held, parts: Option<&Vec<NodeSystem>>) -> bool {
    let Some(decided) = &held.part else {
        return true;
    };
    let mut own = parts.into_iter().flatten();
    own.any(|part| part.system.uid == held.system.uid && part.digest() == *decided)
}

impl<'a> Facts<'a> {
    pub fn new(desired: &'a Desired, observed: &'a Observed) -> Self {
        let mut facts = Self::default();
        facts.add_desired(desired);
        facts.add_leans();
        for (node, answer) in &observed.nodes {
            if let NodeObserved::Known(inventory) = answer {
                for manager in &inventory.managers {
                    facts.add_process(node, manager);
                }
                let parts = desired.nodes.get(node).map(|spec| &spec.systems);
                for held in inventory.held.iter().filter(|held| counts(held, parts)) {
                    let id = Id {
                        uid: &held.system.uid,
                        instance: &held.instance,
                    };
                    facts.held.insert((node, id), &held.reason);
                }
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

    fn add_desired(&mut self, desired: &'a Desired) {
        for (node, spec) in &desired.nodes {
            self.nodes.insert(node);
            for part in &spec.systems {
                let orders = SystemOrders {
                    orders: &part.orders,
                };
                self.orders.entry(&part.system.uid).or_insert(orders);
                for connector in &part.connectors {
                    let key = (part.system.uid.as_str(), connector.spec.name.as_str());
                    self.links.insert(key, (&part.system, connector));
                }
                for placed in &part.components {
                    let want = Want {
                        node,
                        system: &part.system,
                        placed,
                        key: ManagerKey {
                            system: Some(part.system.clone()),
                            name: placed.manager.clone(),
                        },
                    };
                    let seat = self.wanted_seats.entry(want.seat()).or_default();
                    seat.push(want.id());
                    self.wants.insert(want.id(), want);
                }
            }
        }
    }

    fn add_leans(&mut self) {
        let mut leans: BTreeMap<Id<'a>, Vec<(Id<'a>, &'a str)>> = BTreeMap::new();
        for ((uid, name), (_, connector)) in &self.links {
            let [source, target] = ends(uid, connector);
            for (id, peer) in [(source, target), (target, source)] {
                let want = self.wants.get(&id);
                let stops = want.is_some_and(|want| want.on_disconnect() == OnDisconnect::Stop);
                let data = connector.spec.kind == PortKind::Data;
                if stops && data && id != peer && self.wants.contains_key(&peer) {
                    leans.entry(peer).or_default().push((id, name));
                }
            }
        }
        self.leans = leans;
    }

    fn add_process(&mut self, node: &'a str, manager: &'a ManagerObserved) {
        let seat = (node, manager.key.clone());
        if self.processes.contains_key(&seat) {
            // Its flock makes a second process of one key impossible; an inventory that says so is not acted upon.
            return;
        }
        self.by_seat.entry(seat.clone()).or_default();
        self.processes.insert(seat, manager);
        for component in &manager.components {
            let live = Live {
                node,
                manager,
                component,
            };
            let index = self.lives.len();
            self.lives.push(live);
            if let Some(id) = live.id() {
                self.by_id.entry(id).or_default().push(index);
            }
            let name = (node, component.instance.as_str());
            self.by_name.entry(name).or_default().push(index);
            self.by_incarnation.insert(&component.incarnation, index);
            self.by_seat.entry(live.seat()).or_default().push(index);
        }
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
        let first = Id { uid, instance: "" };
        let next = self.wants.range(first..).next();
        next.is_some_and(|(id, _)| id.uid == uid)
    }

    /// Systems with at least one desired component, and their members.
    pub fn members(&self) -> BTreeMap<&'a str, Vec<&'a str>> {
        let mut members: BTreeMap<&'a str, Vec<&'a str>> = BTreeMap::new();
        for id in self.wants.keys() {
            members.entry(id.uid).or_default().push(id.instance);
        }
        members
    }
}

/// The components at the source and the target of a connector.
pub(crate) fn ends<'a>(uid: &'a str, connector: &'a PlacedConnector) -> [Id<'a>; 2] {
    let spec = &connector.spec;
    [&spec.source, &spec.target].map(|end| Id {
        uid,
        instance: &end.instance,
    })
}
