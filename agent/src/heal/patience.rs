//! Time that a batch needs beside what is usual.

use std::collections::BTreeMap;
use std::time::Duration;

use rts_plan::plan::{Step, StepId};

use crate::execute::{limit, usual_limit};
use crate::policies::Policies;

/// The longest chain of what steps wait on purpose (`WaitTime`), and of what they may take beyond the usual
/// (`rtsctl.startTimeout`). Who waits for others with a limit waits no longer than these take, so that limits add nothing:
/// with this time on top, each of them is over before the batch is.
pub(super) fn patience(steps: &[Step], policies: &Policies) -> Duration {
    let mut ends: BTreeMap<StepId, Duration> = BTreeMap::new();
    for step in steps {
        let begin = step.before().filter_map(|id| ends.get(&id)).max();
        let begin = begin.copied().unwrap_or_default();
        let wait = Duration::from_millis(step.wait_ms.into());
        let extra = limit(step, policies).saturating_sub(usual_limit(&step.work));
        let end = begin.saturating_add(wait).saturating_add(extra);
        ends.insert(step.id, end);
    }
    ends.into_values().max().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use rts_plan::desired::{ManagerKey, NodeSpec, NodeSystem, SystemRef};
    use rts_plan::plan::Work;
    use serde_json::json;

    use super::*;

    fn step(id: StepId, instance: &str, needs: &[StepId], wait_ms: u32) -> Step {
        let system = SystemRef {
            name: "hello".to_owned(),
            uid: "u".to_owned(),
        };
        let work = Work::Activate {
            manager: ManagerKey {
                system: Some(system.clone()),
                name: "main".to_owned(),
            },
            instance: instance.to_owned(),
        };
        Step {
            system: Some(system),
            after_end_of: needs.to_vec(),
            wait_ms,
            ..Step::new(id, "local", format!("component/{instance}"), work)
        }
    }

    fn policies() -> Policies {
        let part: NodeSystem = serde_json::from_value(json!({
            "system": {"name": "hello", "uid": "u"},
            "components": [{
                "spec": {
                    "instance": "Slow0",
                    "type": "Slow",
                    "policy": {"startTimeoutMs": 90_000}
                },
                "manager": "main",
                "recreateHash": ""
            }]
        }))
        .unwrap();
        Policies::of_spec(&NodeSpec {
            node: "local".to_owned(),
            systems: vec![part],
        })
    }

    #[test]
    fn waits_and_long_starts_add_up_along_a_chain() {
        let ms = |steps: &[Step]| patience(steps, &policies()).as_millis();
        assert_eq!(ms(&[]), 0);
        assert_eq!(ms(&[step(1, "A0", &[], 0), step(2, "B0", &[1], 0)]), 0);
        let slow = step(1, "Slow0", &[], 0);
        let beside = step(2, "A0", &[], 70_000);
        assert_eq!(ms(&[slow.clone(), beside.clone()]), 80_000);
        let behind = step(3, "B0", &[1, 2], 5_000);
        assert_eq!(ms(&[slow, beside, behind]), 85_000);
    }
}
