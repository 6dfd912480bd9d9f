//! Taking everything down before the process ends.

use std::time::{Duration, Instant};

use crate::component::Action;
use crate::data::Parting;
use crate::log;
use crate::manager::Manager;

/// Kept for the answer; less of a short deadline.
const MARGIN: Duration = Duration::from_millis(100);

/// Time for good-byes to leave, which takes longer only when the other end stalls.
const GOOD_BYES: Duration = Duration::from_secs(1);

/// Deletes all components at once, each on its own thread. Those that hang are left behind at the deadline.
pub fn shutdown(manager: &Manager, deadline: Instant) {
    manager.stop_creating();
    let left = deadline.saturating_duration_since(Instant::now());
    let deadline = Instant::now() + left - MARGIN.min(left / 4);
    let asked: Vec<_> = manager
        .components()
        .into_iter()
        .map(|component| {
            let pending = component.ask(Action::Delete, deadline, None);
            (component, pending)
        })
        .collect();
    for (component, pending) in asked {
        let ended = pending.and_then(|pending| component.wait(&pending));
        if let Err(failure) = ended {
            log::error(format_args!(
                "{} is left behind: {failure}",
                component.identity.instance
            ));
            // Its thread cannot do it any more; to its peers this is a planned end all the same.
            manager.detach(&component, Parting::GoodBye);
        }
    }
    // Some time even when components that hang have used it all up; the answer comes after it.
    let now = Instant::now();
    manager.wait_for_good_byes(deadline.min(now + GOOD_BYES).max(now + MARGIN / 2));
}
