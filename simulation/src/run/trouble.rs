//! Faults, made to happen, and undone.

use std::sync::Arc;

use tokio::time::{Instant, sleep, sleep_until};

use super::stage::Stage;
use crate::faults::{Fault, When};
use crate::schedule::Named;
use crate::words::CONTROLLER;
use crate::world::programs;
use crate::world::trouble::{Lasts, begin, end, lasts};

/// Lets a fault happen when its time comes, unless everything is quiet before; gives back what it changed.
pub(super) async fn happen(world: Arc<Stage>, named: Named, quiet: Instant) {
    if !due(&world, named.fault.when, quiet).await {
        return;
    }
    let fault = named.fault.fault;
    world.note(format!("{}: {fault}", named.name));
    world.coverage.count(&format!("fault {}", kind(&fault)));
    if fault == Fault::Usurper {
        usurp(&world, quiet);
    }
    let lasts = lasts(&fault);
    let begun = begin(&world, fault);
    // What never ends by itself ends with the quiet.
    let until = match lasts {
        Lasts::Not => return,
        Lasts::For(time) => (Instant::now() + time).min(quiet),
        Lasts::ForEver => quiet,
    };
    sleep_until(until).await;
    end(&world, &begun);
    world.note(format!("{} is over", named.name));
}

async fn due(world: &Stage, when: When, quiet: Instant) -> bool {
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

/// A controller is started from a backup of the store, while the present one goes on until everything is quiet. From then
/// on the new one is what everybody reaches and what is started again.
fn usurp(world: &Arc<Stage>, quiet: Instant) {
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
    let Some(old) = world.lives().retire(CONTROLLER) else {
        return;
    };
    world.hosts.controller_leaves();
    tokio::spawn(programs::run(
        Arc::clone(&world.world),
        CONTROLLER.to_owned(),
    ));
    let world = Arc::clone(world);
    tokio::spawn(async move {
        sleep_until(quiet).await;
        if !old.is_over() {
            world.note("the controller of before ends");
            old.end();
        }
    });
}
