//! What stands before a step, in few words, and the critical path.

use crate::plan::{Limit, OnTimeout, Plan, Step, StepId};

/// Most steps of a path that are all named.
const NAMED: usize = 16;

/// `1,2; start of 3; end of 4; waits 500 ms; at most 200 ms for 4, then fails`. Empty when nothing stands before it.
pub fn after(step: &Step) -> String {
    let mut parts = Vec::new();
    let lists = [
        ("", &step.needs),
        ("start of ", &step.after_start_of),
        ("end of ", &step.after_end_of),
    ];
    for (how, ids) in lists {
        if !ids.is_empty() {
            parts.push(format!("{how}{}", join(ids, ",")));
        }
    }
    if step.wait_ms > 0 {
        parts.push(format!("waits {}", milliseconds(u64::from(step.wait_ms))));
    }
    parts.extend(step.limits.iter().map(limit));
    parts.join("; ")
}

/// `at most 200 ms for 4, then fails`.
pub fn limit(limit: &Limit) -> String {
    within(limit, &format!(" for {}", join(&limit.steps, ",")))
}

/// The same with this in the place of ` for 4`.
pub(super) fn within(limit: &Limit, whom: &str) -> String {
    let then = match limit.then {
        OnTimeout::Fail => "fails",
        OnTimeout::GoOn => "goes on",
    };
    let time = milliseconds(u64::from(limit.ms));
    format!("at most {time}{whom}, then {then}")
}

/// `critical path: 1 → 4 → 9 (3 steps, waits 1.5 s)`: what the plan cannot be faster than. Until everything is Active,
/// when it brings anything up. None without steps.
pub fn critical_path(plan: &Plan) -> Option<String> {
    let path = &plan.critical_path;
    if path.is_empty() {
        return None;
    }
    let step = |id: &StepId| plan.steps.get((*id as usize).checked_sub(1)?);
    let waits = path.iter().filter_map(step).map(|s| u64::from(s.wait_ms));
    let waits = match waits.sum::<u64>() {
        0 => String::new(),
        ms => format!(", waits {}", milliseconds(ms)),
    };
    let count = path.len();
    let s = if count == 1 { "" } else { "s" };
    Some(format!(
        "critical path: {} ({count} step{s}{waits})",
        chain(path)
    ))
}

/// `1 → 4 → 9`; the middle of a long one is left out.
pub(crate) fn chain(path: &[StepId]) -> String {
    if path.len() <= NAMED {
        return join(path, " → ");
    }
    let half = NAMED / 2;
    let (first, last) = (&path[..half], &path[path.len() - half..]);
    format!("{} → … → {}", join(first, " → "), join(last, " → "))
}

/// `500 ms`, `1.5 s`.
pub(crate) fn milliseconds(ms: u64) -> String {
    if ms < 1000 {
        return format!("{ms} ms");
    }
    format!("{} s", ms as f64 / 1000.0)
}

pub(crate) fn join(ids: &[StepId], by: &str) -> String {
    let ids: Vec<String> = ids.iter().map(ToString::to_string).collect();
    ids.join(by)
}
