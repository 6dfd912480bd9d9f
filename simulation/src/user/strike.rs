//! Faults strike, and end.

use std::time::Duration;

use tokio::time::sleep;

use crate::faults::Fault;
use crate::world::World;
use crate::world::trouble::{Lasts, begin, end, lasts};

/// How often it is looked for a process that a fault is to strike.
const LOOK: Duration = Duration::from_millis(20);

/// Waits until there is what a fault is to strike. The end of the run ends it.
pub async fn there(world: &World, fault: &Fault) {
    let (Fault::ManagerDies { node, manager } | Fault::ManagerHangs { node, manager }) = fault
    else {
        return;
    };
    let Some(node) = world.nodes.get(node) else {
        return;
    };
    while !node.machine.has(manager.as_deref()) {
        sleep(LOOK).await;
    }
}

/// Lets a fault strike, and undoes it when its time is over. True when there was something to undo.
pub async fn strike(world: &World, fault: Fault) -> bool {
    let lasts = lasts(&fault);
    let begun = begin(world, fault);
    match lasts {
        Lasts::Not => return false,
        Lasts::For(time) => sleep(time).await,
        Lasts::ForEver => std::future::pending().await,
    }
    end(world, &begun);
    true
}
