//! Faults strike, and end.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::sleep;

use super::world::World;
use crate::faults::Fault;
use crate::net::Weather;

/// Lets a fault strike, and undoes it when its time is over. True when there was something to undo.
pub async fn strike(world: &Arc<World>, fault: &Fault) -> bool {
    let Some(lasts) = begin(world, fault).await else {
        return matches!(fault, Fault::Weather { .. });
    };
    match lasts {
        Some(lasts) => sleep(lasts).await,
        None => std::future::pending().await,
    }
    end(world, fault);
    true
}

/// True when nothing ends it.
pub fn lasts_for_ever(fault: &Fault) -> bool {
    matches!(
        fault,
        Fault::Cut { lasts: None, .. }
            | Fault::ModuleFails { lasts: None, .. }
            | Fault::Misbehaves { lasts: None, .. }
    )
}

/// How long it lasts by itself: a fault that is over at once gives none, and one for ever `Some(None)`.
async fn begin(world: &Arc<World>, fault: &Fault) -> Option<Option<Duration>> {
    let node = |name: &str| world.nodes.get(name);
    match fault {
        Fault::Crash { host, calls, down } => {
            world.end(host, *calls, *down);
            return None;
        }
        Fault::Reboot { node: name, down } => {
            world.net.dark(name, true);
            if !world.end(name, 0, Some(*down)) {
                world.keep_down(name, *down);
            }
            if let Some(node) = node(name) {
                node.machine.reboot();
                node.disk.lose_power();
            }
            return None;
        }
        Fault::Cut { from, to, lasts } => {
            world.net.cut(from, to);
            return Some(*lasts);
        }
        Fault::Weather {
            lost,
            doubled,
            delay,
            lasts,
        } => {
            let number = world.net.weather(Weather {
                lost: *lost,
                doubled: *doubled,
                delay: *delay,
            });
            sleep(*lasts).await;
            world.net.clear(number);
            return None;
        }
        Fault::DiskFails { host, lasts } => {
            match node(host) {
                Some(node) => node.disk.fail_writes(true),
                None => world.store.fail(true),
            }
            return Some(Some(*lasts));
        }
        Fault::DiskSlow { host, delay, lasts } => {
            match node(host) {
                Some(node) => node.disk.slow(Some(*delay)),
                None => world.store.slow(*delay),
            }
            return Some(Some(*lasts));
        }
        Fault::ClockJumps { host, by } => {
            let clock = node(host).map_or(&world.clock, |node| &node.clock);
            clock.jump(*by);
        }
        Fault::ManagerDies {
            node: name,
            manager,
        } => {
            if let Some(node) = node(name) {
                node.machine.kill(manager.as_deref());
            }
        }
        Fault::ManagerHangs {
            node: name,
            manager,
        } => {
            if let Some(node) = node(name) {
                node.machine.hang(manager.as_deref());
            }
        }
        Fault::ManagersFailToStart { node: name, lasts } => {
            if let Some(node) = node(name) {
                node.machine.fail_to_start(true);
            }
            return Some(Some(*lasts));
        }
        Fault::ModuleFails {
            node: name,
            type_name,
            lasts,
        } => {
            if let Some(node) = node(name) {
                node.machine.fail_module(type_name, true);
            }
            return Some(*lasts);
        }
        Fault::Misbehaves {
            instance,
            how,
            lasts,
        } => {
            for node in world.nodes.values() {
                node.machine.misbehave(instance, Some(*how));
            }
            return Some(*lasts);
        }
        Fault::Usurper => {}
    }
    None
}

fn end(world: &World, fault: &Fault) {
    let node = |name: &str| world.nodes.get(name);
    match fault {
        Fault::Cut { from, to, .. } => world.net.mend(from, to),
        Fault::DiskFails { host, .. } => match node(host) {
            Some(node) => node.disk.fail_writes(false),
            None => world.store.fail(false),
        },
        Fault::DiskSlow { host, delay, .. } => match node(host) {
            Some(node) => node.disk.slow(None),
            None => world.store.quick(*delay),
        },
        Fault::ManagersFailToStart { node: name, .. } => {
            if let Some(node) = node(name) {
                node.machine.fail_to_start(false);
            }
        }
        Fault::ModuleFails {
            node: name,
            type_name,
            ..
        } => {
            if let Some(node) = node(name) {
                node.machine.fail_module(type_name, false);
            }
        }
        Fault::Misbehaves { instance, .. } => {
            for node in world.nodes.values() {
                node.machine.misbehave(instance, None);
            }
        }
        _ => {}
    }
}
