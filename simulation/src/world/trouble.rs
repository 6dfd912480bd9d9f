//! Faults begin, and are undone.

use std::time::Duration;

use super::World;
use crate::faults::Fault;
use crate::net::Weather;

/// How long a fault lasts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lasts {
    /// It is over at once: nothing is to be undone.
    Not,
    /// For so long.
    For(Duration),
    /// Nothing in it ends it.
    ForEver,
}

/// A fault that has begun.
#[derive(Debug)]
pub struct Begun {
    fault: Fault,
    /// Which weather it is.
    weather: u64,
    /// Among those that go on.
    number: u64,
}

/// How long a fault lasts.
pub fn lasts(fault: &Fault) -> Lasts {
    match fault {
        Fault::Cut { lasts, .. }
        | Fault::ModuleFails { lasts, .. }
        | Fault::Misbehaves { lasts, .. } => lasts.map_or(Lasts::ForEver, Lasts::For),
        Fault::Weather { lasts, .. }
        | Fault::DiskFails { lasts, .. }
        | Fault::DiskSlow { lasts, .. }
        | Fault::ManagersFailToStart { lasts, .. } => Lasts::For(*lasts),
        Fault::Crash { .. }
        | Fault::Reboot { .. }
        | Fault::ClockJumps { .. }
        | Fault::ManagerDies { .. }
        | Fault::ManagerHangs { .. }
        | Fault::Usurper => Lasts::Not,
    }
}

impl World {
    /// A fault has begun. Gives its number.
    fn goes_on(&self, fault: Fault) -> u64 {
        let mut going_on = super::lock(&self.going_on);
        let number = going_on.last_key_value().map_or(0, |(last, _)| last + 1);
        if lasts(&fault) != Lasts::Not {
            going_on.insert(number, fault);
        }
        number
    }

    /// A fault is over. Gives the others that go on, in the order in which they began.
    fn over(&self, number: u64) -> Vec<Fault> {
        let mut going_on = super::lock(&self.going_on);
        going_on.remove(&number);
        going_on.values().cloned().collect()
    }
}

/// Lets a fault begin. A usurper is more than that: it is nothing here.
pub fn begin(world: &World, fault: Fault) -> Begun {
    let mut weather = 0;
    match &fault {
        Fault::Crash { host, calls, down } => {
            if !world.lives.end(host, *calls, *down) {
                world.note(format!("{host} was down already"));
            }
        }
        Fault::Reboot { node, down } => reboot(world, node, *down),
        Fault::Cut { from, to, .. } => world.net.cut(from, to),
        Fault::Weather {
            lost,
            doubled,
            delay,
            ..
        } => {
            weather = world.net.weather(Weather {
                lost: *lost,
                doubled: *doubled,
                delay: *delay,
            });
        }
        Fault::DiskSlow { host, delay, .. } => match world.nodes.get(host) {
            Some(node) => node.disk.slow(Some(*delay)),
            None => world.store().slow(*delay),
        },
        Fault::ClockJumps { host, by } => {
            let node = world.nodes.get(host);
            node.map_or(&world.clock, |node| &node.clock).jump(*by);
        }
        Fault::ManagerDies { node, manager } => {
            let node = world.nodes.get(node);
            node.and_then(|node| node.machine.kill(manager.as_deref()));
        }
        Fault::ManagerHangs { node, manager } => {
            let node = world.nodes.get(node);
            node.and_then(|node| node.machine.hang(manager.as_deref()));
        }
        Fault::Misbehaves { instance, how, .. } => {
            for node in world.nodes.values() {
                node.machine.misbehave(instance, Some(*how));
            }
        }
        Fault::DiskFails { .. } | Fault::ManagersFailToStart { .. } | Fault::ModuleFails { .. } => {
            fails(world, &fault, true);
        }
        Fault::Usurper => {}
    }
    let number = world.goes_on(fault.clone());
    Begun {
        fault,
        weather,
        number,
    }
}

/// Undoes what lasts, but for what another one of its kind still does.
pub fn end(world: &World, begun: &Begun) {
    let others = world.over(begun.number);
    match &begun.fault {
        Fault::Cut { from, to, .. } => world.net.mend(from, to),
        Fault::Weather { .. } => world.net.clear(begun.weather),
        Fault::DiskSlow { host, delay, .. } => match world.nodes.get(host) {
            Some(node) => {
                let slow = others.iter().filter_map(|other| match other {
                    Fault::DiskSlow {
                        host: at, delay, ..
                    } if at == host => Some(*delay),
                    _ => None,
                });
                node.disk.slow(slow.max());
            }
            None => world.store().quick(*delay),
        },
        Fault::Misbehaves { instance, .. } => {
            let how = others.iter().rev().find_map(|other| match other {
                Fault::Misbehaves {
                    instance: of, how, ..
                } if of == instance => Some(*how),
                _ => None,
            });
            for node in world.nodes.values() {
                node.machine.misbehave(instance, how);
            }
        }
        fault => {
            // The store counts by itself.
            let of_store =
                matches!(fault, Fault::DiskFails { host, .. } if !world.nodes.contains_key(host));
            if of_store || !others.iter().any(|other| same(fault, other)) {
                fails(world, fault, false);
            }
        }
    }
}

/// True when two faults let the same thing fail.
fn same(one: &Fault, other: &Fault) -> bool {
    match (one, other) {
        (Fault::DiskFails { host, .. }, Fault::DiskFails { host: other, .. }) => host == other,
        (
            Fault::ManagersFailToStart { node, .. },
            Fault::ManagersFailToStart { node: other, .. },
        ) => node == other,
        (
            Fault::ModuleFails {
                node, type_name, ..
            },
            Fault::ModuleFails {
                node: other,
                type_name: of,
                ..
            },
        ) => (node, type_name) == (other, of),
        _ => false,
    }
}

/// Whether something fails from now on.
fn fails(world: &World, fault: &Fault, fails: bool) {
    let node = |name: &str| world.nodes.get(name);
    match fault {
        Fault::DiskFails { host, .. } => match node(host) {
            Some(node) => node.disk.fail_writes(fails),
            None => world.store().fail(fails),
        },
        Fault::ManagersFailToStart { node: name, .. } => {
            if let Some(node) = node(name) {
                node.machine.fail_to_start(fails);
            }
        }
        Fault::ModuleFails {
            node: name,
            type_name,
            ..
        } => {
            if let Some(node) = node(name) {
                node.machine.fail_module(type_name, fails);
            }
        }
        _ => {}
    }
}

/// The machine of a node loses power, and comes back.
fn reboot(world: &World, name: &str, down: Duration) {
    world.net.dark(name, true);
    world.lives.end(name, 0, Some(down));
    world.lives.keep_down(name, down);
    if let Some(node) = world.nodes.get(name) {
        node.machine.reboot();
        node.disk.lose_power();
    }
}
