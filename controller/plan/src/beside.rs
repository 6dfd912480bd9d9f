//! What can be done beside steps that are under way: one component that is slow to activate, or waits on purpose, must not
//! keep the others from being healed.

use std::collections::BTreeSet;

use crate::plan::{Step, StepId, Work};

/// A step that was begun with others and has not ended.
#[derive(Debug, Clone)]
pub struct Unfinished {
    /// What.
    pub step: Step,
    /// It has started.
    pub started: bool,
}

/// The steps of a plan that touch nothing of unfinished ones and need nothing that does. They keep their numbers.
pub fn beside(steps: &[Step], unfinished: &[Unfinished]) -> Vec<Step> {
    let blocked = |step: &Step| unfinished.iter().any(|other| touch(step, &other.step));
    // A start order is kept when the very step that is to start before has started. What waits for a step's end waits
    // on: it is in a later plan once that has ended.
    let begun = |step: &&Step| {
        let same = |u: &Unfinished| {
            u.started && u.step.target == step.target && u.step.work.kind() == step.work.kind()
        };
        unfinished.iter().any(same)
    };
    let begun: BTreeSet<StepId> = steps.iter().filter(begun).map(|step| step.id).collect();
    let mut taken = BTreeSet::new();
    let mut free = Vec::new();
    for step in steps.iter().filter(|step| !blocked(step)) {
        let mut step = step.clone();
        step.after_start_of.retain(|id| !begun.contains(id));
        step.because.retain(|why| !begun.contains(&why.step));
        for limit in &mut step.limits {
            limit.steps.retain(|id| !begun.contains(id));
        }
        step.limits.retain(|limit| !limit.steps.is_empty());
        if step.before().all(|id| taken.contains(&id)) {
            taken.insert(step.id);
            free.push(step);
        }
    }
    free
}

/// True when two steps cannot be under way at once.
fn touch(one: &Step, other: &Step) -> bool {
    let process = |step: &Step| {
        matches!(
            step.work,
            Work::StartManager { .. }
                | Work::StopManager { .. }
                | Work::LoadModule { .. }
                | Work::UnloadModule { .. }
        )
    };
    let managers = one.work.manager().zip(other.work.manager());
    let same_manager = managers.is_some_and(|(one, other)| one == other);
    one.node == other.node
        && (one.target == other.target || same_manager && (process(one) || process(other)))
}
