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
    Begun { fault, weather }
}

/// Undoes what lasts.
pub fn end(world: &World, begun: &Begun) {
    match &begun.fault {
        Fault::Cut { from, to, .. } => world.net.mend(from, to),
        Fault::Weather { .. } => world.net.clear(begun.weather),
        Fault::DiskSlow { host, delay, .. } => match world.nodes.get(host) {
            Some(node) => node.disk.slow(None),
            None => world.store().quick(*delay),
        },
        Fault::Misbehaves { instance, .. } => {
            for node in world.nodes.values() {
                node.machine.misbehave(instance, None);
            }
        }
        fault => fails(world, fault, false),
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
