//! What can be done for a system beside a run that takes long: one component that is slow to activate must not keep the
//! others from being healed. Pure.

use std::collections::{BTreeMap, BTreeSet};

use rts_plan::plan::{Plan, Step, Work};

use super::by_system::by_system;

/// A step that a run has not finished.
#[derive(Debug, Clone)]
pub struct Unfinished {
    /// What.
    pub step: Step,
    /// It has started.
    pub started: bool,
}

/// The part of a system's plan that touches nothing of a run's unfinished steps and needs nothing that does. None when
/// nothing is left.
pub fn beside(plan: &Plan, unfinished: &[Unfinished]) -> Option<Plan> {
    let blocker = |step: &Step| unfinished.iter().find(|other| touch(step, &other.step));
    // A start order is kept when the very step that is to start before has started. What waits for a step's end waits
    // on: it is in a later plan once that has ended.
    let begun = |step: &Step| {
        let same = |u: &&Unfinished| {
            u.started && u.step.target == step.target && u.step.work.kind() == step.work.kind()
        };
        unfinished.iter().any(|other| same(&other))
    };
    let begun: Vec<_> = plan
        .steps
        .iter()
        .filter(|s| begun(s))
        .map(|s| s.id)
        .collect();
    let free = plan.steps.iter().filter(|step| blocker(step).is_none());
    let steps = free.map(|step| {
        let mut step = step.clone();
        step.after_start_of.retain(|id| !begun.contains(id));
        step.because.retain(|why| !begun.contains(&why.step));
        for limit in &mut step.limits {
            limit.steps.retain(|id| !begun.contains(id));
        }
        step.limits.retain(|limit| !limit.steps.is_empty());
        step
    });
    let free = Plan {
        steps: steps.collect(),
        ..Plan::default()
    };
    // Leaves out what needs a step that is not there.
    by_system(&free).into_values().next()
}

/// The steps of a plan that no run stands in the way of: those of systems without a run, and what can be done beside
/// long ones.
pub fn free(
    plan: &Plan,
    busy: &BTreeSet<String>,
    long: &BTreeMap<String, Vec<Unfinished>>,
) -> Vec<Step> {
    let plans = by_system(plan).into_iter();
    let free = plans.filter_map(|(system, plan)| match long.get(&system) {
        Some(left) => beside(&plan, left),
        None => Some(plan).filter(|_| !busy.contains(&system)),
    });
    free.flat_map(|plan| plan.steps).collect()
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

#[cfg(test)]
mod tests {
    use rts_plan::desired::{ManagerKey, SystemRef};
    use rts_plan::plan::{Limit, OnTimeout, StepId};

    use super::*;

    fn step(id: StepId, target: &str, manager: &str, needs: &[StepId], after: &[StepId]) -> Step {
        let system = SystemRef {
            name: "a".into(),
            uid: "a".into(),
        };
        let manager = ManagerKey {
            system: Some(system.clone()),
            name: manager.into(),
        };
        let instance = target.to_owned();
        let work = match target.starts_with("manager/") {
            true => Work::StartManager { manager },
            false => Work::Activate { manager, instance },
        };
        Step {
            system: Some(system),
            needs: needs.to_vec(),
            after_start_of: after.to_vec(),
            ..Step::new(id, "local", target, work)
        }
    }

    fn targets(steps: &[Step], unfinished: &[(&Step, bool)]) -> Vec<String> {
        let unfinished: Vec<_> = unfinished
            .iter()
            .map(|(step, started)| Unfinished {
                step: (*step).clone(),
                started: *started,
            })
            .collect();
        let plan = Plan {
            steps: steps.to_vec(),
            ..Plan::default()
        };
        let left = beside(&plan, &unfinished).unwrap_or_default();
        left.steps.into_iter().map(|step| step.target).collect()
    }

    #[test]
    fn what_a_run_still_does_is_left_to_it_with_all_that_needs_it() {
        let slow = step(1, "slow", "m", &[], &[]);
        let steps = [
            slow.clone(),
            step(2, "after", "n", &[1], &[]),
            step(3, "other", "n", &[], &[]),
            step(4, "last", "n", &[2, 3], &[]),
        ];
        assert_eq!(targets(&steps, &[(&slow, true)]), ["other"]);
        assert_eq!(targets(&steps[..2], &[(&slow, true)]), [""; 0]);
        assert_eq!(targets(&steps[2..3], &[]), ["other"]);
    }

    #[test]
    fn a_start_order_holds_until_the_other_has_started() {
        let slow = step(1, "slow", "m", &[], &[]);
        let steps = [slow.clone(), step(2, "next", "n", &[], &[1])];
        assert_eq!(targets(&steps, &[(&slow, true)]), ["next"]);
        assert_eq!(targets(&steps, &[(&slow, false)]), [""; 0]);
    }

    #[test]
    fn an_end_order_holds_until_the_run_with_the_other_is_over() {
        let slow = step(1, "slow", "m", &[], &[]);
        let mut next = step(2, "next", "n", &[], &[]);
        next.after_end_of = vec![1];
        next.limits = vec![Limit {
            steps: vec![1],
            ms: 500,
            then: OnTimeout::Fail,
        }];
        let steps = [slow.clone(), next, step(3, "other", "n", &[], &[])];
        assert_eq!(targets(&steps, &[(&slow, true)]), ["other"]);
        assert_eq!(targets(&steps, &[(&slow, false)]), ["other"]);
        assert_eq!(targets(&steps, &[]), ["slow", "next", "other"]);
    }

    #[test]
    fn a_limit_on_what_has_started_goes_with_its_start_order() {
        let slow = step(1, "slow", "m", &[], &[]);
        let other = step(2, "other", "n", &[], &[]);
        let mut next = step(3, "next", "n", &[], &[1, 2]);
        next.limits = vec![Limit {
            steps: vec![1, 2],
            ms: 500,
            then: OnTimeout::Fail,
        }];
        let plan = Plan {
            steps: vec![slow.clone(), other, next],
            ..Plan::default()
        };
        let begun = Unfinished {
            step: slow,
            started: true,
        };
        let left = beside(&plan, &[begun]).unwrap_or_default().steps;
        assert_eq!((left.len(), &left[1].after_start_of), (2, &vec![1]));
        assert_eq!(left[1].limits[0].steps, [1]);
    }

    #[test]
    fn a_process_is_not_started_under_a_component_that_is_worked_on() {
        let slow = step(1, "slow", "m", &[], &[]);
        let steps = [
            step(1, "manager/a.m", "m", &[], &[]),
            step(2, "manager/a.n", "n", &[], &[]),
        ];
        assert_eq!(targets(&steps, &[(&slow, true)]), ["manager/a.n"]);
    }
}
