//! Whether a component is brought up again after its process ended by itself.
//!
//! Pure: the caller knows how the process ended and counts the deaths; it keeps a [`Verdict::Held`] until the system
//! changes.

use std::time::Duration;

use rts_schemas::system::{Policy, RESTART_WINDOW_MS, RestartPolicy};

/// How a process ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// It exited with this code.
    Code(i32),
    /// A signal ended it.
    Signal(i32),
    /// It is gone and nobody knows how. Counts as a failure.
    Unknown,
}

impl Ended {
    /// True for anything but exit code 0.
    pub fn failed(self) -> bool {
        self != Self::Code(0)
    }
}

impl std::fmt::Display for Ended {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Code(code) => write!(f, "exited with code {code}"),
            Self::Signal(signal) => write!(f, "was ended by signal {signal}"),
            Self::Unknown => write!(f, "ended for an unknown reason"),
        }
    }
}

/// What follows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// It is brought up again, after its back-off.
    Again,
    /// It is not brought up again; why, and how to mend it.
    Held(String),
}

/// The window in which the deaths of a component count against its limit.
pub fn window(policy: &Policy) -> Duration {
    Duration::from_millis(policy.restart_window_ms.unwrap_or(RESTART_WINDOW_MS))
}

/// Whether a component is brought up again after its process ended; `recent` counts its deaths within
/// [`window`], this one included.
pub fn verdict(policy: &Policy, ended: Ended, recent: u32) -> Verdict {
    match policy.restart {
        RestartPolicy::Never => held(format!("its process {ended} and rtsctl.restart is never")),
        RestartPolicy::OnFailure if !ended.failed() => held(format!(
            "its process {ended} and rtsctl.restart is on-failure"
        )),
        RestartPolicy::Always | RestartPolicy::OnFailure => within_limit(policy, recent),
    }
}

fn within_limit(policy: &Policy, recent: u32) -> Verdict {
    match policy.restart_limit {
        Some(limit) if recent > limit => held(format!(
            "its process died {recent} times within {}, more than rtsctl.restartLimit {limit} allows",
            words(window(policy))
        )),
        _ => Verdict::Again,
    }
}

fn held(why: String) -> Verdict {
    const MEND: &str = "apply a change to start it, or tear the system down and apply it again";
    Verdict::Held(format!("{why}; {MEND}"))
}

/// A window in the largest unit that divides it.
fn words(window: Duration) -> String {
    let ms = window.as_millis();
    let units = [(3_600_000, "h"), (60_000, "min"), (1000, "s")];
    let unit = units
        .into_iter()
        .find(|(size, _)| ms > 0 && ms.is_multiple_of(*size));
    let (size, unit) = unit.unwrap_or((1, "ms"));
    format!("{} {unit}", ms / size)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn policy(restart: RestartPolicy, limit: Option<u32>) -> Policy {
        Policy {
            restart,
            restart_limit: limit,
            ..Policy::default()
        }
    }

    fn reason(policy: &Policy, ended: Ended, recent: u32) -> String {
        match verdict(policy, ended, recent) {
            Verdict::Held(reason) => reason,
            Verdict::Again => "again".to_owned(),
        }
    }

    #[test]
    fn reasons_say_how_to_mend() {
        let never = policy(RestartPolicy::Never, None);
        insta::assert_snapshot!(reason(&never, Ended::Signal(9), 1), @"its process was ended by signal 9 and rtsctl.restart is never; apply a change to start it, or tear the system down and apply it again");
        let on_failure = policy(RestartPolicy::OnFailure, None);
        insta::assert_snapshot!(reason(&on_failure, Ended::Code(0), 1), @"its process exited with code 0 and rtsctl.restart is on-failure; apply a change to start it, or tear the system down and apply it again");
        let limited = policy(RestartPolicy::Always, Some(3));
        insta::assert_snapshot!(reason(&limited, Ended::Unknown, 4), @"its process died 4 times within 10 min, more than rtsctl.restartLimit 3 allows; apply a change to start it, or tear the system down and apply it again");
    }

    #[test]
    fn on_failure_brings_up_what_did_not_end_well() {
        let policy = policy(RestartPolicy::OnFailure, None);
        for ended in [
            Ended::Code(1),
            Ended::Code(-1),
            Ended::Signal(15),
            Ended::Unknown,
        ] {
            assert_eq!(verdict(&policy, ended, u32::MAX), Verdict::Again, "{ended}");
        }
    }

    #[test]
    fn windows_read_well() {
        let shown = [500, 90_000, 600_000, 7_200_000].map(|ms| words(Duration::from_millis(ms)));
        assert_eq!(shown, ["500 ms", "90 s", "10 min", "2 h"]);
    }

    fn endings() -> impl Strategy<Value = Ended> {
        prop_oneof![
            prop_oneof![Just(0), any::<i32>()].prop_map(Ended::Code),
            any::<i32>().prop_map(Ended::Signal),
            Just(Ended::Unknown),
        ]
    }

    proptest! {
        #[test]
        fn never_is_never(ended in endings(), limit: Option<u32>, recent: u32) {
            let verdict = verdict(&policy(RestartPolicy::Never, limit), ended, recent);
            prop_assert_ne!(verdict, Verdict::Again);
        }

        #[test]
        fn a_limit_holds_exactly_above_it(ended in endings(), limit: u32, recent: u32) {
            let verdict = verdict(&policy(RestartPolicy::Always, Some(limit)), ended, recent);
            prop_assert_eq!(verdict == Verdict::Again, recent <= limit);
        }

        #[test]
        fn more_deaths_never_free(ended in endings(), limit: Option<u32>, few: u32, more: u32) {
            for restart in [RestartPolicy::Always, RestartPolicy::OnFailure, RestartPolicy::Never] {
                let policy = policy(restart, limit);
                let held = |recent| verdict(&policy, ended, recent) != Verdict::Again;
                prop_assert!(!held(few.min(more)) || held(few.max(more)));
            }
        }

        #[test]
        fn without_a_limit_always_is_always(ended in endings(), recent: u32) {
            let verdict = verdict(&policy(RestartPolicy::Always, None), ended, recent);
            prop_assert_eq!(verdict, Verdict::Again);
        }
    }
}
