//! What of a system does not run, and why.

use rts_controller_api::objects::{System, Waiting};

use crate::error::CliError;
use crate::session::Session;
use crate::show::progress;

/// The error, with what is missing in few words.
pub(super) fn partly(system: &System, waiting: &[Waiting]) -> CliError {
    let status = &system.status;
    let mut required = waiting.iter().filter(|w| w.required);
    let summary = if status.active < status.components {
        format!(
            "{} of {} components active",
            status.active, status.components
        )
    } else if waiting.is_empty() {
        unhealthy(system)
    } else {
        let targets: Vec<_> = required.clone().map(|w| w.target.as_str()).collect();
        format!("not as it should be: {}", targets.join(", "))
    };
    CliError::Partly {
        system: system.metadata.name.clone(),
        summary,
        target: required
            .find(|w| w.target.starts_with("component/") || w.target.starts_with("connector/"))
            .map(|w| w.target.clone()),
        held: is_held(waiting),
    }
}

/// What the controller says of a system that is not healthy, though it waits for nothing.
fn unhealthy(system: &System) -> String {
    let mut conditions = system.status.conditions.iter();
    let healthy = conditions.find(|c| c.kind == "Healthy" && c.status != "True");
    match healthy.map(|condition| condition.message.as_str()) {
        None | Some("") => "it is not healthy, and the controller does not say why".to_owned(),
        Some(message) => format!("it is not healthy: {message}"),
    }
}

/// What is missing is held by failure policies, which its reason names, and nothing of it is tried again.
fn is_held(waiting: &[Waiting]) -> bool {
    let mut required = waiting.iter().filter(|w| w.required);
    let held = |w: &Waiting| w.reason.contains("rtsctl.restart");
    let stands = |w: &Waiting| held(w) || (w.tries == 0 && w.next_try.is_none());
    required.clone().all(stands) && required.any(held)
}

/// What a system is busy with, and what does not go on.
pub fn list_unfinished(system: &System, session: &Session) {
    for step in &system.status.progress.running {
        let text = format!("{step} has not ended");
        session.out.fault("", &text, None);
    }
    list_waiting(&system.status.waiting_on, session);
}

/// What does not go on.
pub(super) fn list_waiting(waiting: &[Waiting], session: &Session) {
    let (required, optional): (Vec<_>, Vec<_>) = waiting.iter().partition(|w| w.required);
    for text in progress::grouped(required, tries) {
        session.out.fault("", &text, None);
    }
    for text in progress::grouped(optional, tries) {
        session.out.warn(&text);
    }
}

fn tries(waiting: &Waiting) -> String {
    match waiting.tries {
        0 => String::new(),
        1 => " (tried once)".to_owned(),
        tries => format!(" (tried {tries} times)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::samples;
    use rts_controller_api::objects::Condition;

    #[test]
    fn a_partial_apply_says_what_is_missing() {
        let mut system = samples::system();
        let waiting = Waiting {
            target: "connector/A.o-B.i".to_owned(),
            reason: "refused".to_owned(),
            required: true,
            transient: false,
            tries: 1,
            next_try: None,
        };
        let held = Waiting {
            target: "component/A".to_owned(),
            reason: "its process was killed by signal 9 and rtsctl.restart is never".to_owned(),
            tries: 0,
            ..waiting.clone()
        };
        let said = |system: &System, waiting: &[Waiting]| {
            let error = partly(system, waiting);
            format!("{}; {}", error.line(), error.help().unwrap())
        };
        let both = [held.clone(), waiting.clone()];
        assert!(said(&system, &both).contains("goes on trying"));
        insta::assert_snapshot!(said(&system, &[held]), @"system/hello is only partly applied: not as it should be: component/A; it is not started again by itself: apply a change of it, or run `rtsctl teardown hello` and apply again; see `rtsctl describe component/A`");
        insta::assert_snapshot!(said(&system, &[waiting]), @"system/hello is only partly applied: not as it should be: connector/A.o-B.i; the controller goes on trying: see `rtsctl describe connector/A.o-B.i`");
        insta::assert_snapshot!(said(&system, &[]), @"system/hello is only partly applied: it is not healthy, and the controller does not say why; the controller goes on trying: see `rtsctl describe system/hello`");
        system.status.conditions = vec![Condition {
            kind: "Healthy".to_owned(),
            status: "False".to_owned(),
            reason: "NotHealthy".to_owned(),
            message: "A has been in on_execute for 5 s".to_owned(),
            last_transition_time: samples::NOW,
            observed_generation: 2,
        }];
        let hangs = said(&system, &[]);
        assert!(hangs.contains("it is not healthy: A has been in on_execute for 5 s"));
        system.status.active = 2;
        insta::assert_snapshot!(said(&system, &[]), @"system/hello is only partly applied: 2 of 3 components active; the controller goes on trying: see `rtsctl describe system/hello`");
    }
}
