//! Faults strike, and end.

use tokio::time::sleep;

use crate::faults::Fault;
use crate::world::World;
use crate::world::trouble::{Lasts, begin, end, lasts};

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
