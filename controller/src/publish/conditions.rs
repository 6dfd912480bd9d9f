//! Conditions of a system: Synced, Healthy, Progressing, Drifted.

use jiff::Timestamp;
use rts_controller_api::objects::{Condition, Phase, System, SystemStatus};

use super::system::Facts;
use crate::store::SystemRecord;

/// The conditions; one whose status did not change keeps its time.
pub fn conditions(
    facts: &Facts,
    status: &SystemStatus,
    record: &SystemRecord,
    before: Option<&System>,
    now: Timestamp,
) -> Vec<Condition> {
    let first_wait = facts.waiting.first();
    let waits = first_wait.map_or_else(String::new, |w| format!("{}: {}", w.target, w.reason));
    let progressing = matches!(status.phase, Phase::Progressing | Phase::Terminating);
    let synced = match (status.synced, facts.planned) {
        (true, _) if facts.left => (
            "UpToDate",
            "as written, but for what was changed by hand and is left".to_owned(),
        ),
        (true, _) => ("UpToDate", "everything is as written".to_owned()),
        (false, false) => (
            "NotPlanned",
            "this generation is not planned yet".to_owned(),
        ),
        (false, true) if !waits.is_empty() => ("Waiting", waits.clone()),
        (false, true) => ("Differs", format!("{} changes to make", facts.differences)),
    };
    let healthy = match facts.unhealthy.first() {
        None => (
            "AllActive",
            "every required component is Active and every connector Connected".to_owned(),
        ),
        Some(first) => ("NotHealthy", and_more(first, facts.unhealthy.len())),
    };
    let moving = match status.phase {
        Phase::Terminating => ("Terminating", "being taken down".to_owned()),
        Phase::Progressing => (
            "StepsToDo",
            format!(
                "{} of {} steps done",
                status.progress.done, status.progress.total
            ),
        ),
        Phase::Converged => ("Converged", "nothing is left to do".to_owned()),
        Phase::Degraded if waits.is_empty() => ("NotHealthy", healthy.1.clone()),
        Phase::Degraded => ("Waiting", waits),
    };
    let truth = |value| if value { "True" } else { "False" };
    let (is_drifted, drifted) = match facts.drift.first() {
        Some(first) => {
            let message = and_more(first, facts.drift.len());
            ("True", ("ChangedByHand", message))
        }
        None if facts.silent => {
            let message = "not all of its nodes can be asked".to_owned();
            ("Unknown", ("NotSeen", message))
        }
        None => {
            let message = "nothing of it was changed by hand".to_owned();
            ("False", ("AsWritten", message))
        }
    };
    [
        ("Synced", truth(status.synced), synced),
        ("Healthy", truth(status.healthy), healthy),
        ("Progressing", truth(progressing), moving),
        ("Drifted", is_drifted, drifted),
    ]
    .into_iter()
    .map(|(kind, value, (reason, message))| {
        let old = before
            .and_then(|before| before.status.conditions.iter().find(|c| c.kind == kind))
            .filter(|old| old.status == value);
        Condition {
            kind: kind.to_owned(),
            status: value.to_owned(),
            reason: reason.to_owned(),
            message,
            last_transition_time: old.map_or(now, |old| old.last_transition_time),
            observed_generation: record.generation,
        }
    })
    .collect()
}

fn and_more(first: &str, count: usize) -> String {
    match count {
        0 | 1 => first.to_owned(),
        count => format!("{first}, and {} more", count - 1),
    }
}
