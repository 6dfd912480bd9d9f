//! What can be done beside steps that are under way: one component that is slow to activate, or waits on purpose, must not
//! keep the others from being healed.

use std::collections::BTreeSet;

use rustc_hash::FxHashSet;

use crate::desired::ManagerKey;
use crate::plan::{Step, StepId, Work};

/// A step that was begun with others and has not ended: as much of it as says what it touches.
#[derive(Debug, Clone)]
pub struct Unfinished {
    node: String,
    target: String,
    kind: &'static str,
    manager: Option<ManagerKey>,
    of_process: bool,
    started: bool,
}

impl Unfinished {
    /// This step, which has started or not.
    pub fn of(step: &Step, started: bool) -> Self {
        Self {
            node: step.node.clone(),
            target: step.target.clone(),
            kind: step.work.kind(),
            manager: step.work.manager().cloned(),
            of_process: of_process(step),
            started,
        }
    }
}

/// The steps of a plan that touch nothing of unfinished ones and need nothing that does. They keep their numbers.
pub fn beside(steps: &[Step], unfinished: &[Unfinished]) -> Vec<Step> {
    let touched = Touched::by(unfinished);
    // A start order is kept when the very step that is to start before has started. What waits for a step's end waits
    // on: it is in a later plan once that has ended.
    let started = unfinished.iter().filter(|other| other.started);
    let started: FxHashSet<(&str, &str)> = started
        .map(|other| (other.target.as_str(), other.kind))
        .collect();
    let begun = |step: &&Step| started.contains(&(step.target.as_str(), step.work.kind()));
    let begun: BTreeSet<StepId> = steps.iter().filter(begun).map(|step| step.id).collect();
    let mut taken = BTreeSet::new();
    let mut free = Vec::new();
    for step in steps.iter().filter(|step| !touched.touches(step)) {
        let stands = |id: &StepId| taken.contains(id) || begun.contains(id);
        let before = step.needs.iter().chain(&step.after_end_of);
        let mut before = before.copied().filter(|id| !taken.contains(id));
        if before.next().is_some() || !step.after_start_of.iter().all(stands) {
            continue;
        }
        let mut step = step.clone();
        step.after_start_of.retain(|id| !begun.contains(id));
        step.because.retain(|why| !begun.contains(&why.step));
        for limit in &mut step.limits {
            limit.steps.retain(|id| !begun.contains(id));
        }
        step.limits.retain(|limit| !limit.steps.is_empty());
        taken.insert(step.id);
        free.push(step);
    }
    free
}

/// What unfinished steps work on, to be looked up: there may be as many of them as of the others.
#[derive(Default)]
struct Touched<'a> {
    targets: FxHashSet<(&'a str, &'a str)>,
    /// Processes that something is done in.
    managers: FxHashSet<(&'a str, &'a ManagerKey)>,
    /// Processes that are themselves changed.
    processes: FxHashSet<(&'a str, &'a ManagerKey)>,
}

impl<'a> Touched<'a> {
    fn by(unfinished: &'a [Unfinished]) -> Self {
        let mut touched = Self::default();
        for other in unfinished {
            let node = other.node.as_str();
            touched.targets.insert((node, &other.target));
            if let Some(manager) = &other.manager {
                touched.managers.insert((node, manager));
                if other.of_process {
                    touched.processes.insert((node, manager));
                }
            }
        }
        touched
    }

    /// True when a step cannot be under way at once with some of them.
    fn touches(&self, step: &Step) -> bool {
        let node = step.node.as_str();
        let managers = match of_process(step) {
            true => &self.managers,
            false => &self.processes,
        };
        let manager = step.work.manager();
        self.targets.contains(&(node, &step.target))
            || manager.is_some_and(|manager| managers.contains(&(node, manager)))
    }
}

/// True for what changes a process as a whole, and stands in the way of all that is done in it.
fn of_process(step: &Step) -> bool {
    matches!(
        step.work,
        Work::StartManager { .. }
            | Work::StopManager { .. }
            | Work::LoadModule { .. }
            | Work::UnloadModule { .. }
    )
}
