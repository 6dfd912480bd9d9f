//! Delays the restart of what ends by itself: a process that was started not long ago and is gone, a component that
//! is in Error again soon after it was activated.

use std::collections::{BTreeMap, BTreeSet};

use rts_plan::backoff::RESET_AFTER;
use rts_plan::desired::ManagerKey;
use rts_plan::observed::{ManagerObserved, NodeObserved, Observed};
use rts_plan::plan::{Plan, Step, Work};
use rts_plan::target::on;
use tokio::time::Instant;

use super::by_system::key;
use crate::core::Core;
use crate::view::Happening;

/// When each target was last brought up, while nobody took it down. One that lived longer than [`RESET_AFTER`] starts
/// without delay.
#[derive(Debug, Default)]
pub struct Deaths {
    up: BTreeMap<(String, String), Instant>,
}

impl Deaths {
    /// A step succeeded.
    pub fn succeeded(&mut self, step: &Step) {
        let key = (step.node.clone(), step.target.clone());
        match step.work {
            Work::StartManager { .. } | Work::Activate { .. } => {
                self.up.insert(key, Instant::now());
            }
            Work::StopManager { .. } | Work::Deactivate { .. } | Work::Delete { .. } => {
                self.up.remove(&key);
            }
            _ => {}
        }
    }

    /// Counts what a plan would bring up again although it was brought up not long ago. True when there is any.
    /// Systems with a run are left out: what was seen of them is older than what their steps have done.
    pub fn count(
        &mut self,
        core: &Core,
        plan: &Plan,
        observed: &Observed,
        busy: &BTreeSet<String>,
    ) -> bool {
        self.up.retain(|_, at| at.elapsed() < RESET_AFTER);
        let mut any = false;
        for step in plan.steps.iter().filter(|step| !busy.contains(key(step))) {
            let reason = match &step.work {
                Work::StartManager { manager } => match found(observed, &step.node, manager) {
                    Some(None) => "its process ended by itself".to_owned(),
                    Some(Some(ManagerObserved {
                        expired: Some(why), ..
                    })) => format!("its process is replaced: {why}"),
                    _ => continue,
                },
                Work::Reset { .. } => "it went to Error soon after it was activated".to_owned(),
                _ => continue,
            };
            let who = (step.node.clone(), step.target.clone());
            if self.up.remove(&who).is_none() {
                continue;
            }
            any = true;
            let system = step.system.as_ref().map(|s| s.name.as_str());
            let rng = core.rng.as_ref();
            let now = core.clock.now();
            let blocked = on(&step.node, &step.target);
            let delay = core.backoff().failed(&blocked, system, &reason, rng, now);
            let message = format!("{reason}; started again in {:.1} s", delay.as_secs_f64());
            core.record(Happening::warning("BackOff", &step.target, message).of(system));
        }
        any
    }
}

/// The manager as observed; none when its node is unknown, `Some(None)` when it is not there.
fn found<'a>(
    observed: &'a Observed,
    node: &str,
    key: &ManagerKey,
) -> Option<Option<&'a ManagerObserved>> {
    match observed.nodes.get(node) {
        Some(NodeObserved::Known(inventory)) => {
            Some(inventory.managers.iter().find(|m| m.key == *key))
        }
        _ => None,
    }
}
