//! What of a system does not run, and why.

use rts_controller_api::objects::{System, Waiting};

use crate::error::{CliError, Rest};
use crate::session::Session;
use crate::show::progress;

/// Most verbs that are named in one message.
const ENDS: usize = 3;

/// The error, with what is missing in few words.
pub fn partly(system: &System, waiting: &[Waiting]) -> CliError {
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
        rest: rest(system, waiting),
        nodes: status.nodes.clone().into(),
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

/// What becomes of what is missing: its reasons name failure policies, and what was done by hand.
fn rest(system: &System, waiting: &[Waiting]) -> Rest {
    let required = waiting.iter().filter(|w| w.required);
    let held = |w: &Waiting| w.reason.contains("rtsctl.restart");
    let waits = |w: &Waiting| w.tries == 0 && w.next_try.is_none();
    let by_hand = |w: &Waiting| w.next_try.is_none() && w.reason.contains("by hand");
    if required.clone().all(|w| held(w) || waits(w)) && required.clone().any(held) {
        return Rest::Held;
    }
    let in_error = |w: &Waiting| {
        let instance = w.target.strip_prefix("component/")?;
        let stays = w.next_try.is_none() && w.reason.ends_with("(rtsctl.resetOnError is off)");
        stays.then(|| instance.to_owned())
    };
    let instances: Vec<String> = required.clone().filter_map(in_error).collect();
    let stops = |w: &Waiting| held(w) || waits(w) || in_error(w).is_some();
    if !instances.is_empty() && required.clone().all(stops) {
        return Rest::InError(instances);
    }
    if waiting.iter().all(|w| !w.required) || !required.clone().all(by_hand) {
        return Rest::Tried;
    }
    let mut ends: Vec<String> = required.filter_map(|w| end_of(system, w)).collect();
    ends.truncate(ENDS);
    Rest::ByHand(ends)
}

/// What ends what a person did by hand.
fn end_of(system: &System, waiting: &Waiting) -> Option<String> {
    match waiting.target.split_once('/')? {
        ("component", name) if waiting.reason.starts_with("was deactivated by hand") => {
            Some(format!("rtsctl activate {name}"))
        }
        ("connector", name) if waiting.reason.starts_with("was disconnected by hand") => {
            let mut connectors = system.spec.connectors.iter();
            let connector = connectors.find(|c| c.name == name)?;
            let (source, target) = (&connector.source, &connector.target);
            Some(format!("rtsctl connect {source} {target}"))
        }
        _ => None,
    }
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

    fn connectors() -> Vec<rts_schemas::system::ConnectorSpec> {
        let hello = include_bytes!("../../../../manifests/hello/system.xml");
        let hello = rts_schemas::rts_profile::load("hello.xml", hello, None, &[]);
        hello.unwrap().0.connectors
    }

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
        let by_hand = |target: &str, reason: &str| Waiting {
            target: target.to_owned(),
            reason: format!("{reason} by hand and is left so (see rtsctl.drift)"),
            tries: 0,
            ..both[1].clone()
        };
        let cut = by_hand("connector/Sine0.out-Filter0.in", "was disconnected");
        let idle = by_hand("component/Filter0", "was deactivated");
        assert!(said(&system, &[cut.clone(), both[1].clone()]).contains("goes on trying"));
        insta::assert_snapshot!(said(&system, std::slice::from_ref(&idle)), @"system/hello is only partly applied: not as it should be: component/Filter0; it was changed by hand and is left so (rtsctl.drift) until `rtsctl activate Filter0`; see `rtsctl describe component/Filter0`");
        std::sync::Arc::make_mut(&mut system.spec).connectors = connectors();
        insta::assert_snapshot!(said(&system, &[cut, idle]), @"system/hello is only partly applied: not as it should be: connector/Sine0.out-Filter0.in, component/Filter0; it was changed by hand and is left so (rtsctl.drift) until `rtsctl connect Sine0.out Filter0.in` and `rtsctl activate Filter0`; see `rtsctl describe connector/Sine0.out-Filter0.in`");
        insta::assert_snapshot!(said(&system, &[]), @"system/hello is only partly applied: it is not healthy, and the controller does not say why; the controller goes on trying: see `rtsctl describe system/hello`");
        let in_error = |instance: &str| Waiting {
            target: format!("component/{instance}"),
            reason: "in Error: on_activated returned ERROR (rtsctl.resetOnError is off)".to_owned(),
            ..both[1].clone()
        };
        let idle = Waiting {
            target: "component/C".to_owned(),
            reason: "waits for A".to_owned(),
            tries: 0,
            ..both[1].clone()
        };
        insta::assert_snapshot!(said(&system, &[in_error("A"), in_error("B"), idle]), @"system/hello is only partly applied: not as it should be: component/A, component/B, component/C; nothing is tried any more while it is in Error (rtsctl.resetOnError is off): run `rtsctl reset A B`; see `rtsctl describe component/A`");
        assert!(said(&system, &[in_error("A"), both[1].clone()]).contains("goes on trying"));
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
