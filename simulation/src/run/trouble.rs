//! Faults, made to happen, and undone.

use std::sync::Arc;
use std::time::Duration;

use tokio::time::{Instant, sleep, sleep_until};

use super::programs;
use super::world::World;
use crate::faults::{Fault, When};
use crate::net::Weather;
use crate::schedule::Named;

/// Lets a fault happen when its time comes, unless everything is quiet before; gives back what it changed.
pub(super) async fn happen(world: Arc<World>, named: Named, quiet: Instant) {
    if !due(&world, named.fault.when, quiet).await {
        return;
    }
    let fault = named.fault.fault;
    world.note(format!("{}: {fault}", named.name));
    world.coverage.count(&format!("fault {}", kind(&fault)));
    begin(&world, &fault, quiet);
    let lasts = lasts(&fault);
    sleep_until(lasts.map_or(quiet, |lasts| (Instant::now() + lasts).min(quiet))).await;
    if end(&world, &fault) {
        world.note(format!("{} is over", named.name));
    }
}

async fn due(world: &World, when: When, quiet: Instant) -> bool {
    match when {
        When::At(at) => sleep(at.saturating_sub(world.truth.now())).await,
        When::Step(step) => {
            tokio::select! {
                biased;
                () = world.ground.until_step(step) => {}
                () = sleep_until(quiet) => {}
            }
        }
    }
    Instant::now() < quiet
}

/// One word for it.
fn kind(fault: &Fault) -> String {
    let value = serde_json::to_value(fault).unwrap_or_default();
    let key = value.as_object().and_then(|o| o.keys().next().cloned());
    key.or_else(|| value.as_str().map(str::to_owned))
        .unwrap_or_default()
}

/// How long it lasts; at once over for what is no state.
fn lasts(fault: &Fault) -> Option<Duration> {
    match fault {
        Fault::Cut { lasts, .. }
        | Fault::ModuleFails { lasts, .. }
        | Fault::Misbehaves { lasts, .. } => *lasts,
        Fault::Weather { lasts, .. }
        | Fault::DiskFails { lasts, .. }
        | Fault::DiskSlow { lasts, .. }
        | Fault::ManagersFailToStart { lasts, .. } => Some(*lasts),
        Fault::Usurper => None,
        _ => Some(Duration::ZERO),
    }
}

fn begin(world: &Arc<World>, fault: &Fault, quiet: Instant) {
    let node = |name: &str| world.nodes.get(name);
    // What never ends by itself ends with the quiet.
    let rest = quiet.saturating_duration_since(Instant::now());
    match fault {
        Fault::Crash { host, calls, down } => {
            if !world.end(host, *calls, down.unwrap_or(rest)) {
                world.note(format!("{host} was down already"));
            }
        }
        Fault::Reboot { node: name, down } => {
            world.net.dark(name, true);
            world.end(name, 0, *down);
            world.keep_down(name, *down);
            if let Some(node) = node(name) {
                node.machine.reboot();
                node.disk.lose_power();
            }
        }
        Fault::Cut { from, to, .. } => world.net.cut(from, to),
        Fault::Weather {
            lost,
            doubled,
            delay,
            lasts,
        } => {
            let weather = Weather {
                lost: *lost,
                doubled: *doubled,
                delay: *delay,
            };
            let (net, number) = (world.net.clone(), world.net.weather(weather));
            let until = (Instant::now() + *lasts).min(quiet);
            tokio::spawn(async move {
                sleep_until(until).await;
                net.clear(number);
            });
        }
        Fault::DiskFails { host, .. } => match node(host) {
            Some(node) => node.disk.fail_writes(true),
            None => world.store().fail(true),
        },
        Fault::DiskSlow { host, delay, .. } => match node(host) {
            Some(node) => node.disk.slow(Some(*delay)),
            None => world.store().slow(*delay),
        },
        Fault::ClockJumps { host, by } => {
            node(host)
                .map_or(&world.clock, |node| &node.clock)
                .jump(*by);
        }
        Fault::ManagerDies {
            node: name,
            manager,
        } => {
            node(name).and_then(|node| node.machine.kill(manager.as_deref()));
        }
        Fault::ManagerHangs {
            node: name,
            manager,
        } => {
            node(name).and_then(|node| node.machine.hang(manager.as_deref()));
        }
        Fault::ManagersFailToStart { node: name, .. } => {
            if let Some(node) = node(name) {
                node.machine.fail_to_start(true);
            }
        }
        Fault::ModuleFails {
            node: name,
            type_name,
            ..
        } => {
            if let Some(node) = node(name) {
                node.machine.fail_module(type_name, true);
            }
        }
        Fault::Misbehaves { instance, how, .. } => {
            for node in world.nodes.values() {
                node.machine.misbehave(instance, Some(*how));
            }
        }
        Fault::Usurper => usurp(world, quiet),
    }
}

/// Ends what lasts. False where there is nothing to end.
fn end(world: &World, fault: &Fault) -> bool {
    let node = |name: &str| world.nodes.get(name);
    match fault {
        Fault::Cut { from, to, .. } => world.net.mend(from, to),
        Fault::DiskFails { host, .. } => match node(host) {
            Some(node) => node.disk.fail_writes(false),
            None => world.store().fail(false),
        },
        Fault::DiskSlow { host, delay, .. } => match node(host) {
            Some(node) => node.disk.slow(None),
            None => world.store().quick(*delay),
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
        Fault::Weather { .. } => {}
        _ => return false,
    }
    true
}

/// A controller is started from a backup of the store, while the present one goes on until everything is quiet. From then
/// on the new one is what everybody reaches and what is started again.
fn usurp(world: &Arc<World>, quiet: Instant) {
    let chance = world.seed.stream("usurper");
    let ago = usize::try_from(chance.between(1, 8)).unwrap_or(1);
    let take_over = chance.chance(0.5);
    let now = rts_host::clock::Clock::now(&world.clock);
    let old = world.store();
    world.desired.restored();
    let new = old.restored(world.seed, ago, take_over, now);
    world.note(format!(
        "the store is restored as it was {ago} writes ago, epoch {}{}",
        new.state().epoch,
        if take_over { ", taking over" } else { "" }
    ));
    let desired = world.desired.clone();
    new.tell(Box::new(move |record| {
        // What a ledger held is in force again, or only the part of it that this node has.
        if record.deleted.is_none() {
            desired.asked(&record.spec);
        }
    }));
    world.put_store(new);
    let Some(old) = world.retire("controller") else {
        return;
    };
    tokio::spawn(programs::controller(Arc::clone(world)));
    let world = Arc::clone(world);
    tokio::spawn(async move {
        sleep_until(quiet).await;
        if !old.is_over() {
            world.note("the controller of before ends");
            old.end();
        }
    });
}
