//! Why a component is brought up again, or not: its policies in words, its restarts, and how its process ended last.

use std::time::Duration;

use jiff::Timestamp;
use rts_controller_api::objects::{Component, Event};
use rts_schemas::system::{
    DriftPolicy, LIVENESS_TIMEOUT_MS, OnDisconnect, OnHang, Policy, RESTART_WINDOW_MS,
    RestartPolicy, START_TIMEOUT_MS,
};

use super::Scene;
use crate::local::plural;
use crate::show::age::age;

/// The policies that a component's system gives it.
pub(super) fn of<'a>(component: &Component, scene: &'a Scene) -> Option<&'a Policy> {
    let system = &component.spec.system;
    let system = scene.systems.iter().find(|s| s.spec.name == *system)?;
    let mut components = system.spec.components.iter();
    let spec = components.find(|c| c.instance == component.metadata.name)?;
    Some(&spec.policy)
}

/// `always, at most 3 times in 10m`.
pub(super) fn restart(policy: &Policy) -> String {
    let when = match policy.restart {
        RestartPolicy::Always => "always",
        RestartPolicy::OnFailure => "on-failure",
        RestartPolicy::Never => "never",
    };
    match policy.restart_limit {
        Some(limit) if policy.restart != RestartPolicy::Never => {
            let window = policy.restart_window_ms.unwrap_or(RESTART_WINDOW_MS);
            let times = plural("time", limit as usize);
            format!("{when}, at most {times} in {}", time(window))
        }
        _ => when.to_owned(),
    }
}

/// Policies that are not the default ones, with what they mean.
pub(super) fn others(policy: &Policy) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    match policy.on_disconnect {
        OnDisconnect::Keep => {}
        OnDisconnect::Deactivate => lines.push((
            "On disconnect",
            "deactivate: Active again once all its connectors are connected".to_owned(),
        )),
        OnDisconnect::Stop => lines.push((
            "On disconnect",
            "stop: made again once all its peers can be".to_owned(),
        )),
    }
    let after = policy.liveness_timeout_ms;
    let longer = time(after.unwrap_or(LIVENESS_TIMEOUT_MS));
    match policy.on_hang {
        OnHang::Restart => lines.push((
            "On hang",
            format!("restart: its manager is replaced when a callback takes longer than {longer}"),
        )),
        OnHang::Report if after.is_some() => lines.push((
            "On hang",
            format!("report: only told when a callback takes longer than {longer}"),
        )),
        OnHang::Report => {}
    }
    if policy.reset_on_error {
        lines.push(("On error", "reset".to_owned()));
    }
    if let Some(start) = policy.start_timeout_ms.filter(|ms| *ms != START_TIMEOUT_MS) {
        lines.push(("Start", format!("may take {}", time(start))));
    }
    match policy.drift {
        DriftPolicy::Repair => {}
        DriftPolicy::Ignore => lines.push((
            "By hand",
            "ignore: what is changed by hand is told and left".to_owned(),
        )),
        DriftPolicy::Adopt => lines.push((
            "By hand",
            "adopt: what is changed by hand becomes part of the system".to_owned(),
        )),
    }
    lines
}

/// How the process of a manager ended last, as its events tell.
pub(super) fn last_exit(target: &str, scene: &Scene) -> Option<String> {
    let died = |event: &&Event| event.spec.object == target && event.spec.reason == "ManagerDied";
    let event = scene.events.iter().rev().find(died)?;
    let time = event.status.time.or(event.metadata.creation_timestamp);
    Some(format!(
        "{} ({} ago)",
        event.spec.message,
        age(time, scene.now)
    ))
}

/// `in 4s, at 12:00:04Z`; none when the time has come.
pub(super) fn when(next: Timestamp, now: Timestamp) -> Option<String> {
    if next <= now {
        return None;
    }
    // What is said to come in 0 s would have come.
    let left = Duration::try_from(next.duration_since(now)).unwrap_or_default();
    let left = left + Duration::from_millis(999);
    let seconds = i64::try_from(left.as_secs()).unwrap_or(i64::MAX);
    let ago = now.checked_sub(Duration::from_secs(seconds.unsigned_abs()));
    let clock = next.strftime("%H:%M:%SZ");
    Some(format!("in {}, at {clock}", age(ago.ok(), now)))
}

fn time(ms: u64) -> String {
    if ms.is_multiple_of(1000) {
        let ago = Timestamp::UNIX_EPOCH;
        let now = ago.checked_add(Duration::from_millis(ms));
        return now.map_or_else(|_| format!("{ms}ms"), |now| age(Some(ago), now));
    }
    format!("{ms}ms")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::samples;

    #[test]
    fn policies_are_told_in_words() {
        let mut policy = Policy::default();
        assert_eq!(restart(&policy), "always");
        assert!(others(&policy).is_empty());
        policy.liveness_timeout_ms = Some(2000);
        let report = "report: only told when a callback takes longer than 2s".to_owned();
        assert_eq!(others(&policy), [("On hang", report)]);
        policy.liveness_timeout_ms = None;
        policy.restart = RestartPolicy::OnFailure;
        policy.restart_limit = Some(3);
        assert_eq!(restart(&policy), "on-failure, at most 3 times in 10m");
        policy.restart_window_ms = Some(1500);
        assert_eq!(restart(&policy), "on-failure, at most 3 times in 1500ms");
        policy.restart = RestartPolicy::Never;
        assert_eq!(restart(&policy), "never");
        policy.on_disconnect = OnDisconnect::Deactivate;
        policy.on_hang = OnHang::Restart;
        policy.reset_on_error = true;
        policy.start_timeout_ms = Some(60_000);
        policy.drift = DriftPolicy::Adopt;
        let lines: Vec<_> = others(&policy)
            .into_iter()
            .map(|(key, text)| format!("{key}: {text}"))
            .collect();
        insta::assert_snapshot!(lines.join("\n"), @r"
        On disconnect: deactivate: Active again once all its connectors are connected
        On hang: restart: its manager is replaced when a callback takes longer than 5s
        On error: reset
        Start: may take 60s
        By hand: adopt: what is changed by hand becomes part of the system
        ");
    }

    #[test]
    fn the_next_try_is_told_twice() {
        let now = samples::NOW;
        let at = |ms| when(now + jiff::SignedDuration::from_millis(ms), now);
        assert_eq!(at(3500).unwrap(), "in 4s, at 22:13:23Z");
        assert_eq!(at(-1), None);
    }
}
