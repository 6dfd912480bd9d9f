//! Cuts a plan into one plan for each system. Systems share no process, so that their steps are independent but for
//! names that pass from one to another: a step that needs another system's step is left to a later round. Pure.

use std::collections::BTreeMap;
use std::sync::Arc;

use rts_plan::plan::{Limit, Plan, Step, StepId};

/// Key of a step's run: the uid of its system; empty for what belongs to none.
pub fn key(step: &Step) -> &str {
    step.system.as_ref().map_or("", |system| &system.uid)
}

/// Plans by key.
pub type Plans = BTreeMap<String, Arc<Plan>>;

/// Plans of steps alone, with their own numbers, by key. A plan of one system alone is its own, and is not copied.
pub fn by_system(plan: &Arc<Plan>) -> Plans {
    let Some(first) = plan.steps.first() else {
        return Plans::new();
    };
    let first = key(first);
    if plan.steps.iter().all(|step| key(step) == first) {
        return Plans::from([(first.to_owned(), Arc::clone(plan))]);
    }
    let parts = parts(plan).into_iter();
    parts.map(|(key, plan)| (key, Arc::new(plan))).collect()
}

/// A plan of one system of which some steps were left out, with new numbers. None when nothing is left.
pub fn renumbered(plan: &Plan) -> Option<Arc<Plan>> {
    parts(plan).into_values().next().map(Arc::new)
}

fn parts(plan: &Plan) -> BTreeMap<String, Plan> {
    let mut plans: BTreeMap<String, Plan> = BTreeMap::new();
    // Old number → key and new number, of the steps that were taken.
    let mut numbers: BTreeMap<StepId, (&str, StepId)> = BTreeMap::new();
    for step in &plan.steps {
        let key = key(step);
        let renumber = |ids: &[StepId]| -> Option<Vec<StepId>> {
            let number = |id| match numbers.get(id) {
                Some((owner, number)) if *owner == key => Some(*number),
                _ => None,
            };
            ids.iter().map(number).collect()
        };
        let (Some(needs), Some(starts), Some(ends)) = (
            renumber(&step.needs),
            renumber(&step.after_start_of),
            renumber(&step.after_end_of),
        ) else {
            continue;
        };
        let limits = step.limits.iter().filter_map(|limit| {
            let steps = renumber(&limit.steps)?;
            Some(Limit { steps, ..*limit })
        });
        let limits = limits.collect();
        let own = &mut plans.entry(key.to_owned()).or_default().steps;
        let id = own.last().map_or(1, |last| last.id + 1);
        numbers.insert(step.id, (key, id));
        own.push(Step {
            id,
            needs,
            after_start_of: starts,
            after_end_of: ends,
            limits,
            // Its reasons are for people, who see the whole plan.
            ..step.without_reasons()
        });
    }
    plans
}

#[cfg(test)]
mod tests {
    use rts_plan::desired::SystemRef;
    use rts_plan::plan::Work;

    use super::*;

    fn step(id: StepId, system: &str, needs: &[StepId]) -> Step {
        Step {
            system: Some(SystemRef {
                name: system.into(),
                uid: system.into(),
            }),
            needs: needs.to_vec(),
            ..Step::new(
                id,
                "local",
                format!("package/T{id}@local"),
                Work::Install {
                    type_name: format!("T{id}"),
                    module_digest: None,
                },
            )
        }
    }

    #[test]
    fn each_system_gets_its_steps_and_what_needs_another_system_waits() {
        let steps = vec![
            step(1, "a", &[]),
            step(2, "b", &[]),
            step(3, "a", &[1]),
            step(4, "b", &[1, 2]),
            step(5, "b", &[4]),
            step(6, "b", &[2]),
        ];
        let plan = Plan {
            steps,
            ..Plan::default()
        };
        let plans = by_system(&Arc::new(plan));
        let shape = |key: &str| -> Vec<(StepId, String, Vec<StepId>)> {
            let steps = plans[key].steps.iter();
            steps
                .map(|s| (s.id, s.target.clone(), s.needs.clone()))
                .collect()
        };
        let at = |id: u32| format!("package/T{id}@local");
        assert_eq!(shape("a"), [(1, at(1), vec![]), (2, at(3), vec![1])]);
        assert_eq!(shape("b"), [(1, at(2), vec![]), (2, at(6), vec![1])]);
    }
}
