//! A callback that fails, each in each way: what becomes of its component, and that nothing becomes of others.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::fmt::Write;

use rts_manager_api::client::Client;
use rts_manager_api::control::*;

use crate::support::*;

const CALLBACKS: [&str; 13] = [
    "on_initialize",
    "on_startup",
    "on_activated",
    "on_execute",
    "on_state_update",
    "on_rate_changed",
    "on_configured",
    "on_deactivated",
    "on_aborting",
    "on_error",
    "on_reset",
    "on_shutdown",
    "on_finalize",
];

/// How a callback fails: in the bare interface of C, in the Rust SDK, or by a panic there.
const WAYS: [(&str, &[(&str, &str)]); 3] = [
    ("Testmod", &[("reason", "told to")]),
    ("Failing", &[]),
    ("Failing", &[("panics", "true")]),
];

#[test]
fn a_callback_that_fails_harms_its_own_component_alone_whatever_it_is_written_in() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("Witness", &[]);
    ok(&mut client, activate("Witness"));
    let load = RequestBody::LoadModule {
        type_name: "Failing".to_owned(),
        path: built("libfailing.so").display().to_string(),
        digest: None,
    };
    ok(&mut client, load);
    let told = WAYS.map(|(type_name, parameters)| {
        let mut told = String::new();
        for callback in CALLBACKS {
            let outcome = outcome(&manager, &mut client, type_name, parameters, callback);
            writeln!(told, "{callback}: {}", without_places(&outcome)).unwrap();
            let before = component(&mut client, "Witness");
            assert_eq!((before.state.as_str(), before.restarts), ("Active", 0));
            until("others run on", || {
                component(&mut client, "Witness").executions > before.executions
            });
        }
        told
    });
    insta::assert_snapshot!(told[0]);
    assert_eq!(told[0], told[1]);
    assert_eq!(told[0], told[2]);
}

/// Makes a component whose `callback` fails, has it called, and deletes it: what was answered, and the state it came to.
fn outcome(
    manager: &Running,
    client: &mut Client,
    type_name: &str,
    parameters: &[(&str, &str)],
    callback: &str,
) -> String {
    // These three are called in Error only.
    let fail = match callback {
        "on_aborting" | "on_error" | "on_reset" => format!("on_execute,{callback}"),
        _ => callback.to_owned(),
    };
    let mut parameters = parameters.to_vec();
    parameters.push(("fail", &fail));
    let RequestBody::Create(mut request) = manager.testmod("A", &parameters) else {
        panic!()
    };
    request.type_name = type_name.to_owned();
    let mut answers = Vec::new();
    let mut ask = |client: &mut Client, body| match client.call(body, SOON) {
        Ok(_) => true,
        Err(refusal) => {
            answers.push(refusal.to_string());
            false
        }
    };
    let state = if ask(client, RequestBody::Create(request)) {
        if ask(client, activate("A")) {
            let in_error = |client: &mut Client| component(client, "A").state == "Error";
            match callback {
                "on_rate_changed" => {
                    ask(client, rate("A", 500.0));
                }
                "on_configured" => {
                    ask(client, configure("A", &[("produce", "1")]));
                }
                "on_deactivated" => {
                    ask(client, deactivate("A"));
                }
                "on_shutdown" | "on_finalize" => {}
                _ => until("it fails", || in_error(client)),
            }
            if callback == "on_reset" {
                let reset = RequestBody::Reset {
                    instance: "A".to_owned(),
                };
                ask(client, reset);
            }
        }
        let seen = component(client, "A");
        let message = seen
            .message
            .map_or(String::new(), |message| format!(" ({message})"));
        format!("{}{message}", seen.state)
    } else {
        "not created".to_owned()
    };
    let delete = RequestBody::Delete {
        instance: "A".to_owned(),
    };
    ok(client, delete);
    assert!(
        inventory(client)
            .components
            .iter()
            .all(|c| c.instance != "A")
    );
    answers.push(state);
    answers.join("; ")
}

/// Without the place of a panic.
fn without_places(text: &str) -> String {
    let mut parts = text.split("panicked at ");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        out += part.split_once(": ").map_or(part, |(_, text)| text);
    }
    out
}

fn rate(instance: &str, rate: f64) -> RequestBody {
    RequestBody::Configure {
        instance: instance.to_owned(),
        sets: default_set(&[]),
        active: None,
        rate: Some(rate),
        on_disconnect: None,
        order: None,
        by_hand: None,
    }
}
