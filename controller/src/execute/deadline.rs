//! How long a run may take: as long as its longest chain of steps, each with all the time that its agent gives it. Pure.

use std::collections::BTreeMap;
use std::time::Duration;

use rts_plan::plan::{Plan, Step, StepId, Work};
use rts_schemas::system::START_TIMEOUT_MS;

use crate::core::Core;

/// Time that a run has beside what its steps may take: for agents that are slow to begin, and for many steps at once.
const SPARE: Duration = Duration::from_secs(60);
/// At least what an agent gives a step that is no start of a component.
const STEP: Duration = Duration::from_secs(25);
/// What an agent adds to each limit before it gives a step up, and more.
const GRACE: Duration = Duration::from_secs(5);
/// Longest deadline that an agent takes.
const MOST: Duration = Duration::from_secs(24 * 3600);

/// `rtsctl.startTimeout` in milliseconds by instance, where it is set.
pub type StartTimeouts = BTreeMap<String, u64>;

impl Core {
    /// How long the components of a system may take to start, where that was set.
    pub(crate) fn start_timeouts(&self, uid: &str) -> StartTimeouts {
        let registry = self.registry();
        let record = registry.systems.values().find(|record| record.uid == uid);
        let components = record.into_iter().flat_map(|r| &r.spec.components);
        components
            .filter_map(|c| Some((c.instance.clone(), c.policy.start_timeout_ms?)))
            .collect()
    }
}

/// Time from the first step to the last, in the worst case. What waits with a limit waits at most for what is before it.
pub fn of(plan: &Plan, starts: &StartTimeouts) -> Duration {
    let mut ends: BTreeMap<StepId, Duration> = BTreeMap::new();
    for step in &plan.steps {
        let before = step.before().filter_map(|id| ends.get(&id).copied());
        let begin = before.max().unwrap_or_default();
        let wait = Duration::from_millis(step.wait_ms.into());
        let end = begin.saturating_add(wait).saturating_add(own(step, starts));
        ends.insert(step.id, end.min(MOST));
    }
    let longest = ends.into_values().max().unwrap_or_default();
    longest.saturating_add(SPARE).min(MOST)
}

/// What a step itself may take.
fn own(step: &Step, starts: &StartTimeouts) -> Duration {
    match &step.work {
        Work::Create { instance, .. } | Work::Activate { instance, .. } => {
            let ms = starts.get(instance).copied().unwrap_or(START_TIMEOUT_MS);
            Duration::from_millis(ms).saturating_add(GRACE)
        }
        _ => STEP,
    }
}

#[cfg(test)]
mod tests {
    use rts_plan::desired::ManagerKey;

    use super::*;

    fn activate(id: StepId, instance: &str, wait_ms: u32) -> Step {
        let manager = ManagerKey {
            system: None,
            name: "main".into(),
        };
        Step {
            wait_ms,
            ..Step::new(
                id,
                "local",
                format!("component/{instance}"),
                Work::Activate {
                    manager,
                    instance: instance.into(),
                },
            )
        }
    }

    fn seconds(steps: Vec<Step>, starts: &[(&str, u64)]) -> u64 {
        let plan = Plan {
            steps,
            ..Plan::default()
        };
        let starts = starts.iter().map(|(i, ms)| ((*i).to_owned(), *ms));
        of(&plan, &starts.collect()).as_secs()
    }

    #[test]
    fn every_kind_of_edge_lengthens_the_chain() {
        let chain = |edge: fn(&mut Step)| {
            let mut last = activate(2, "B", 0);
            edge(&mut last);
            seconds(vec![activate(1, "A", 0), last], &[])
        };
        assert_eq!(chain(|_| {}), 60 + 15);
        assert_eq!(chain(|step| step.needs = vec![1]), 60 + 30);
        assert_eq!(chain(|step| step.after_start_of = vec![1]), 60 + 30);
        assert_eq!(chain(|step| step.after_end_of = vec![1]), 60 + 30);
    }

    #[test]
    fn a_long_start_time_out_and_waits_on_purpose_are_given() {
        let mut last = activate(2, "B", 7_000);
        last.needs = vec![1];
        let steps = || vec![activate(1, "A", 3_000), last.clone()];
        assert_eq!(seconds(steps(), &[("A", 300_000)]), 60 + 3 + 305 + 7 + 15);
        assert_eq!(seconds(Vec::new(), &[]), 60);
    }

    #[test]
    fn no_agent_is_asked_for_more_than_a_day() {
        let day = 24 * 3600;
        let steps = vec![activate(1, "A", u32::MAX)];
        assert_eq!(seconds(steps, &[("A", u64::MAX)]), day);
    }
}
