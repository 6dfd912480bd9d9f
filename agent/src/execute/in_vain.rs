//! What is said of a step that waited for as long as it may.

use std::collections::BTreeMap;

use rts_plan::plan::{Step, StepId};

use super::queue::Missing;
use super::what;

/// Most steps that are named.
const MAX_NAMED: usize = 5;

/// Why a step failed: it waited, and these did not come.
pub(super) fn reason(
    steps: &BTreeMap<StepId, Step>,
    id: StepId,
    limit: usize,
    missing: &[Missing],
) -> String {
    let step = steps.get(&id);
    let limit = step.and_then(|step| step.limits.get(limit));
    let ms = limit.map_or(0, |limit| limit.ms);
    let one = missing.len() == 1;
    // Two words for two kinds of waits; where both are, the stronger one.
    let done = match (missing.iter().all(|m| m.start_only), one) {
        (true, true) => "has not started",
        (true, false) => "have not started",
        (false, true) => "has not ended",
        (false, false) => "have not ended",
    };
    format!(
        "{}: waited {ms} ms for {} (Preceding time-out of the profile), which {done}",
        step.map(what).unwrap_or_default(),
        names(steps, missing)
    )
}

fn names(steps: &BTreeMap<StepId, Step>, missing: &[Missing]) -> String {
    let name = |missing: &Missing| {
        let id = missing.step;
        let elsewhere = || format!("step {id} of another node");
        steps.get(&id).map_or_else(elsewhere, what)
    };
    let mut names: Vec<String> = missing.iter().take(MAX_NAMED).map(name).collect();
    if missing.len() > MAX_NAMED {
        names.push(format!("{} more", missing.len() - MAX_NAMED));
    }
    let last = names.pop().unwrap_or_default();
    if names.is_empty() {
        last
    } else {
        format!("{} and {last}", names.join(", "))
    }
}
