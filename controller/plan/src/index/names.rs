//! Identities of components, processes and connectors: names with a number, by which they are compared and found.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use crate::desired::{Desired, ManagerKey, NodeSystem, SystemRef};
use crate::observed::{NodeObserved, Observed};
use crate::table::Numbered;

/// Compares by number alone: equal names have equal numbers.
macro_rules! numbered {
    ($name:ident, $number:tt) => {
        impl PartialEq for $name<'_> {
            fn eq(&self, other: &Self) -> bool {
                self.$number == other.$number
            }
        }

        impl Eq for $name<'_> {}

        impl PartialOrd for $name<'_> {
            fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
                Some(self.cmp(other))
            }
        }

        impl Ord for $name<'_> {
            fn cmp(&self, other: &Self) -> Ordering {
                self.$number.cmp(&other.$number)
            }
        }

        impl Numbered for $name<'_> {
            fn number(&self) -> usize {
                self.$number as usize
            }
        }
    };
}

/// Identity of a component: system uid and instance name. Numbers follow the names.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Id<'a> {
    pub uid: &'a str,
    pub instance: &'a str,
    number: u32,
}

numbered!(Id, number);

/// Identity of a process: node and key. Numbers follow the names.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seat<'a>(pub &'a str, pub &'a ManagerKey, u32);

numbered!(Seat, 2);

/// Identity of a connector: system uid and name. Numbers follow the order in which they were met.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinkId<'a>(pub &'a str, pub &'a str, u32);

numbered!(LinkId, 2);

/// Numbers of all components that are desired, observed, or an end of a desired connector.
#[derive(Debug, Default)]
pub(super) struct Ids<'a> {
    by_name: BTreeMap<&'a str, FxHashMap<&'a str, Id<'a>>>,
}

impl<'a> Ids<'a> {
    pub fn of(desired: &'a Desired, observed: &'a Observed) -> Self {
        let mut ids = Self::default();
        for part in desired.nodes.values().flat_map(|spec| &spec.systems) {
            let own = ids.by_name.entry(&part.system.uid).or_default();
            own.reserve(part.components.len());
            let components = part.components.iter().map(|c| c.spec.instance.as_str());
            let connectors = part.connectors.iter().map(|c| &c.spec);
            let ends = connectors.flat_map(|c| [c.source.instance.as_str(), &c.target.instance]);
            components
                .chain(ends)
                .for_each(|name| add(own, &part.system.uid, name));
        }
        for inventory in observed.nodes.values().filter_map(|node| match node {
            NodeObserved::Known(inventory) => Some(inventory),
            NodeObserved::Unknown { .. } => None,
        }) {
            let components = inventory.managers.iter().flat_map(|m| &m.components);
            let components = components.filter_map(|c| Some((c.system.as_ref()?, &c.instance)));
            let held = inventory.held.iter().map(|h| (&h.system, &h.instance));
            for (system, name) in components.chain(held) {
                let own = ids.by_name.entry(&system.uid).or_default();
                add(own, &system.uid, name);
            }
        }
        ids.number();
        ids
    }

    fn number(&mut self) {
        let mut next = 0;
        for own in self.by_name.values_mut() {
            let mut all: Vec<&mut Id<'a>> = own.values_mut().collect();
            all.sort_unstable_by_key(|id| id.instance);
            for id in all {
                id.number = next;
                next += 1;
            }
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.by_name.values().map(FxHashMap::len).sum()
    }

    pub fn get(&self, uid: &str, instance: &str) -> Option<Id<'a>> {
        self.by_name.get(uid)?.get(instance).copied()
    }
}

fn add<'a>(own: &mut FxHashMap<&'a str, Id<'a>>, uid: &'a str, instance: &'a str) {
    own.entry(instance).or_insert(Id {
        uid,
        instance,
        number: 0,
    });
}

/// Keys of the processes that are desired, part by part: nothing else has them in one piece.
#[derive(Debug, Default)]
pub(crate) struct Keys(Vec<Vec<ManagerKey>>);

impl Keys {
    pub fn of(desired: &Desired) -> Self {
        let parts = desired.nodes.values().flat_map(|spec| &spec.systems);
        let keys = parts.map(|part| {
            let mut names: Vec<&str> = part.components.iter().map(|c| c.manager.as_str()).collect();
            names.sort_unstable();
            names.dedup();
            let key = |name: &str| ManagerKey {
                system: Some(part.system.clone()),
                name: name.to_owned(),
            };
            names.into_iter().map(key).collect()
        });
        Self(keys.collect())
    }
}

/// Numbers of all processes that are desired or observed.
#[derive(Debug)]
pub(super) struct Seats<'a> {
    by_key: BTreeMap<(&'a str, &'a ManagerKey), Seat<'a>>,
    wanted: FxHashMap<(&'a str, &'a str, &'a str), Seat<'a>>,
}

impl<'a> Seats<'a> {
    /// `keys` are those of `desired`.
    pub fn of(keys: &'a Keys, desired: &'a Desired, observed: &'a Observed) -> Self {
        let mut seats = BTreeMap::new();
        let nodes = desired.nodes.iter();
        let parts = nodes.flat_map(|(node, spec)| spec.systems.iter().map(move |_| node));
        for (node, own) in parts.zip(&keys.0) {
            seats.extend(
                own.iter()
                    .map(|key| ((node.as_str(), key), Seat(node, key, 0))),
            );
        }
        for (node, answer) in &observed.nodes {
            if let NodeObserved::Known(inventory) = answer {
                for manager in &inventory.managers {
                    let seat = Seat(node, &manager.key, 0);
                    seats.entry((node.as_str(), &manager.key)).or_insert(seat);
                }
            }
        }
        for (number, seat) in (0..).zip(seats.values_mut()) {
            seat.2 = number;
        }
        let of_system = |seat: &&Seat<'a>| seat.1.system.is_some();
        let wanted = seats.values().filter(of_system).map(|seat| {
            let system = seat.1.system.as_ref().map_or("", |s| s.uid.as_str());
            ((seat.0, system, seat.1.name.as_str()), *seat)
        });
        Self {
            wanted: wanted.collect(),
            by_key: seats,
        }
    }

    pub fn get(&self, node: &'a str, key: &'a ManagerKey) -> Option<Seat<'a>> {
        self.by_key.get(&(node, key)).copied()
    }

    /// The process of a system that has this name.
    pub fn wanted(&self, node: &str, system: &SystemRef, name: &str) -> Option<Seat<'a>> {
        self.wanted.get(&(node, system.uid.as_str(), name)).copied()
    }
}

/// Numbers of connectors.
#[derive(Debug, Default)]
pub(super) struct LinkIds<'a> {
    by_name: BTreeMap<&'a str, FxHashMap<&'a str, LinkId<'a>>>,
    next: u32,
}

impl<'a> LinkIds<'a> {
    /// Makes room for the connectors of these parts.
    pub fn reserve(&mut self, parts: impl Iterator<Item = &'a NodeSystem>) {
        for part in parts {
            let own = self.by_name.entry(&part.system.uid).or_default();
            own.reserve(part.connectors.len());
        }
    }

    pub fn get(&self, uid: &str, name: &str) -> Option<LinkId<'a>> {
        self.by_name.get(uid)?.get(name).copied()
    }

    /// The identity of a connector, with the next number when it has none.
    pub fn number(&mut self, uid: &'a str, name: &'a str) -> LinkId<'a> {
        let own = self.by_name.entry(uid).or_default();
        *own.entry(name).or_insert_with(|| {
            self.next += 1;
            LinkId(uid, name, self.next - 1)
        })
    }
}
