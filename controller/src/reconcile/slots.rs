//! Which runs are under way: one for each system, and one more beside it when it takes long.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use tokio::task::AbortHandle;
use tokio::time::Instant;

use super::side::Unfinished;
use crate::core::RunState;

/// A run that takes longer gets another one beside it, when something else is to be done for its system.
const LONG: Duration = Duration::from_secs(1);
/// Ends the name of the second slot of a system.
const BESIDE: &str = "#beside";

/// The runs, by slot: the system's uid, or the same and [`BESIDE`].
#[derive(Debug, Default)]
pub struct Slots(BTreeMap<String, Running>);

#[derive(Debug)]
struct Running {
    task: AbortHandle,
    since: Instant,
    state: RunState,
}

/// The system of a slot.
pub fn system_of(slot: &str) -> &str {
    slot.strip_suffix(BESIDE).unwrap_or(slot)
}

impl Slots {
    /// Number of runs.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Slots that are taken.
    pub fn names(&self) -> BTreeSet<String> {
        self.0.keys().cloned().collect()
    }

    /// Systems with a run.
    pub fn systems(&self) -> BTreeSet<String> {
        self.0
            .keys()
            .map(|slot| system_of(slot).to_owned())
            .collect()
    }

    /// A free slot of a system.
    pub fn free(&self, system: &str) -> Option<String> {
        let beside = format!("{system}{BESIDE}");
        let slots = [system.to_owned(), beside];
        slots.into_iter().find(|slot| !self.0.contains_key(slot))
    }

    /// Takes a slot.
    pub fn take(&mut self, slot: String, task: AbortHandle, state: RunState) {
        let since = Instant::now();
        self.0.insert(slot, Running { task, since, state });
    }

    /// Frees the slots of runs that have ended.
    pub fn tidy(&mut self) {
        self.0.retain(|_, running| !running.task.is_finished());
    }

    /// What the runs of each system have still to do, for systems whose runs all take long.
    pub fn long(&self) -> BTreeMap<String, Vec<Unfinished>> {
        let mut long: BTreeMap<String, Vec<Unfinished>> = BTreeMap::new();
        let mut short = BTreeSet::new();
        for (slot, running) in &self.0 {
            let system = system_of(slot).to_owned();
            if running.since.elapsed() < LONG {
                short.insert(system);
                continue;
            }
            long.entry(system)
                .or_default()
                .extend(unfinished(&running.state));
        }
        long.retain(|system, _| !short.contains(system));
        long
    }
}

/// What a run has still to do.
fn unfinished(state: &RunState) -> Vec<Unfinished> {
    let progress = state.progress.lock();
    let steps = state.plan.steps.iter();
    let open = steps.filter(|step| !progress.ended.contains_key(&step.id));
    open.map(|step| Unfinished::of(step, progress.running.contains(&step.id)))
        .collect()
}
