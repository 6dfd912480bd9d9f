//! What can be done for a system beside a run that takes long: one component that is slow to activate must not keep the
//! others from being healed. Pure.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rts_plan::plan::Plan;

use super::by_system::{Plans, renumbered};

pub use rts_plan::Unfinished;

/// The part of a system's plan that touches nothing of a run's unfinished steps and needs nothing that does. None when
/// nothing is left.
pub fn beside(plan: &Plan, unfinished: &[Unfinished]) -> Option<Arc<Plan>> {
    let free = Plan {
        steps: rts_plan::beside(&plan.steps, unfinished),
        ..Plan::default()
    };
    // They get new numbers.
    renumbered(&free)
}

/// The steps of plans that no run stands in the way of: those of systems without a run, and what can be done beside
/// long ones.
pub fn free(
    plans: &Plans,
    busy: &BTreeSet<String>,
    long: &BTreeMap<String, Vec<Unfinished>>,
) -> Plans {
    let free = plans.iter().filter_map(|(system, plan)| {
        let plan = match long.get(system) {
            Some(left) => beside(plan, left)?,
            None if busy.contains(system) => return None,
            None => Arc::clone(plan),
        };
        Some((system.clone(), plan))
    });
    free.collect()
}

#[cfg(test)]
mod tests {
    use rts_plan::desired::{ManagerKey, SystemRef};
    use rts_plan::plan::{Limit, OnTimeout, Step, StepId, Work};

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
            .map(|(step, started)| Unfinished::of(step, *started))
            .collect();
        let plan = Plan {
            steps: steps.to_vec(),
            ..Plan::default()
        };
        let left = beside(&plan, &unfinished).unwrap_or_default();
        left.steps.iter().map(|step| step.target.clone()).collect()
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
        let begun = Unfinished::of(&slow, true);
        let left = beside(&plan, &[begun]).unwrap_or_default();
        let left = &left.steps;
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
