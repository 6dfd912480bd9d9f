//! Components that share an execution context, and composites.

use std::time::Duration;

use rts_manager_api::client::Client;
use rts_manager_api::control::*;

use super::{driven, tick};
use crate::support::*;

/// The same for one that shares an execution context.
pub fn shared(
    manager: &Running,
    (instance, order): (&str, i32),
    kind: &str,
    parameters: &[(&str, &str)],
) -> CreateRequest {
    let RequestBody::Create(request) = driven(manager, instance, kind, parameters) else {
        panic!()
    };
    CreateRequest {
        execution_context: Some(Box::new(ExecutionContextRequest {
            name: "control".to_owned(),
            order,
            shared_state: None,
        })),
        ..request
    }
}

/// The same for one that also shares its state with the others.
fn of_composite(
    manager: &Running,
    at: (&str, i32),
    kind: &str,
    parameters: &[(&str, &str)],
) -> CreateRequest {
    let mut request = shared(manager, at, kind, parameters);
    if let Some(shared) = &mut request.execution_context {
        shared.shared_state = Some("arm".to_owned());
    }
    request
}

pub fn create(client: &mut Client, request: CreateRequest) -> String {
    match ok(client, RequestBody::Create(request)) {
        ResponseBody::Created { incarnation } => incarnation,
        other => panic!("{other:?}"),
    }
}

fn connect(client: &mut Client, from: &str, to: &str, incarnation: &str) {
    let request = connection(from, to, incarnation, None);
    let source = format!("{from}.out");
    ok(client, binding(&request.connector, to, "in", &source));
    ok(client, RequestBody::Connect(request));
}

fn read_by(client: &mut Client, instance: &str) -> u64 {
    component(client, instance).bindings[0].samples_received
}

pub fn delete(instance: &str) -> RequestBody {
    RequestBody::Delete {
        instance: instance.to_owned(),
    }
}

fn members(client: &mut Client, instance: &str) -> String {
    let Some(shared) = component(client, instance).execution_context else {
        panic!("{instance} shares none")
    };
    assert_eq!(shared.name, "control");
    shared.members.join(" ")
}

#[test]
fn components_of_one_execution_context_run_in_their_order_and_a_tick_runs_all() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    let made = |at, parameters| shared(&manager, at, "other", parameters);
    let b = create(&mut client, made(("B", 20), &[]));
    create(&mut client, made(("A", 10), &[("produce", "1")]));
    create(&mut client, made(("C", 20), &[]));
    connect(&mut client, "A", "B", &b);
    for instance in ["C", "B", "A"] {
        ok(&mut client, activate(instance));
    }
    assert_eq!(members(&mut client, "B"), "A B C");
    ok(&mut client, tick("C", 1));
    assert_eq!(read_by(&mut client, "B"), 1, "A goes before B");

    // With another number it goes after it, from the next cycle on.
    let last = RequestBody::Configure {
        instance: "A".to_owned(),
        sets: default_set(&[]),
        active: None,
        rate: None,
        on_disconnect: None,
        order: Some(30),
        by_hand: None,
    };
    ok(&mut client, last);
    assert_eq!(members(&mut client, "A"), "B C A");
    ok(&mut client, tick("B", 1));
    assert_eq!(read_by(&mut client, "B"), 1);
    ok(&mut client, tick("A", 1));
    assert_eq!(read_by(&mut client, "B"), 2);
    for instance in ["A", "B", "C"] {
        assert_eq!(component(&mut client, instance).executions, 3);
    }
}

#[test]
fn one_that_fails_or_goes_leaves_the_others_of_its_execution_context_alone() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    let failing = [("fail", "on_execute"), ("reason", "told to")];
    create(&mut client, shared(&manager, ("A", 1), "other", &failing));
    create(&mut client, shared(&manager, ("B", 2), "other", &[]));
    ok(&mut client, activate("A"));
    ok(&mut client, activate("B"));
    ok(&mut client, tick("B", 3));
    assert_eq!(component(&mut client, "A").state, "Error");
    assert_eq!(component(&mut client, "B").executions, 3);

    ok(&mut client, delete("A"));
    assert_eq!(members(&mut client, "B"), "B");
    ok(&mut client, tick("B", 1));
    // One that cannot be initialised takes nobody with it either.
    let bad = shared(&manager, ("C", 0), "other", &[("fail", "on_initialize")]);
    refused(&mut client, RequestBody::Create(bad), SOON);
    assert_eq!(members(&mut client, "B"), "B");
    ok(&mut client, tick("B", 1));
    assert_eq!(component(&mut client, "B").executions, 5);

    // With the last one it is gone; its name may then be that of another kind.
    ok(&mut client, delete("B"));
    create(&mut client, shared(&manager, ("D", 0), "periodic", &[]));
    create(&mut client, shared(&manager, ("E", 0), "periodic", &[]));
    ok(&mut client, activate("E"));
    until("it runs by itself", || {
        component(&mut client, "E").executions >= 2
    });
    assert_eq!(component(&mut client, "D").executions, 0);
}

#[test]
fn a_rate_is_that_of_the_execution_context_and_all_are_told() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    create(&mut client, shared(&manager, ("A", 0), "periodic", &[]));
    assert_eq!(component(&mut client, "A").rate, 1000.0, "of its module");
    let mut slow = shared(&manager, ("B", 0), "periodic", &[]);
    slow.rate = Some(50.0);
    create(&mut client, slow);
    let told = |instance| {
        let log = manager.log(instance);
        log.matches("on_rate_changed").count()
    };
    assert_eq!((told("A"), told("B")), (1, 0));
    create(&mut client, shared(&manager, ("C", 0), "periodic", &[]));
    for instance in ["A", "B", "C"] {
        assert_eq!(component(&mut client, instance).rate, 50.0);
    }
    let faster = RequestBody::Configure {
        instance: "C".to_owned(),
        sets: default_set(&[]),
        active: None,
        rate: Some(200.0),
        on_disconnect: None,
        order: None,
        by_hand: None,
    };
    ok(&mut client, faster);
    for instance in ["A", "B", "C"] {
        assert_eq!(component(&mut client, instance).rate, 200.0);
    }
    assert_eq!((told("A"), told("B"), told("C")), (2, 1, 1));
}

#[test]
fn a_sample_runs_along_a_chain_on_one_event_driven_execution_context() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    ok(
        &mut client,
        driven(&manager, "S", "other", &[("produce", "1")]),
    );
    let on = |at, parameters| shared(&manager, at, "eventDriven", parameters);
    let a = create(&mut client, on(("A", 1), &[("produce", "1")]));
    let b = create(&mut client, on(("B", 2), &[]));
    create(&mut client, on(("C", 3), &[]));
    connect(&mut client, "S", "A", &a);
    connect(&mut client, "A", "B", &b);
    for instance in ["A", "B", "C", "S"] {
        ok(&mut client, activate(instance));
    }
    for round in 1..=3 {
        ok(&mut client, tick("S", 1));
        until("it is at the end of the chain", || {
            read_by(&mut client, "B") == round
        });
        assert_eq!(component(&mut client, "A").executions, round);
        assert_eq!(component(&mut client, "B").executions, round);
    }
    assert_eq!(component(&mut client, "C").executions, 0, "nobody woke it");
}

#[test]
fn one_that_hangs_is_named_to_who_waits_for_another_and_the_second_pass_is_after_the_first_of_all()
{
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    let hangs = [("hang", "on_state_update"), ("hang_ms", "60000")];
    create(&mut client, shared(&manager, ("A", 1), "other", &hangs));
    create(&mut client, shared(&manager, ("B", 2), "other", &[]));
    ok(&mut client, activate("A"));
    ok(&mut client, activate("B"));
    let mut other = manager.client();
    std::thread::spawn(move || other.call(tick("B", 1), SOON));
    until("A hangs", || component(&mut client, "A").busy.is_some());
    let (a, b) = (component(&mut client, "A"), component(&mut client, "B"));
    assert_eq!(a.busy.unwrap().callback, "on_state_update");
    assert_eq!(
        (a.executions, b.executions),
        (1, 1),
        "B has executed before"
    );
    assert_eq!(b.busy, None);
    let failure = refused(&mut client, deactivate("B"), Duration::from_millis(100));
    let told =
        "B waits for the execution context `control`, where A has been in on_state_update for ";
    assert!(failure.message.starts_with(told), "{}", failure.message);
}

#[test]
fn members_that_share_their_state_fail_are_reset_and_deactivated_together() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    create(&mut client, of_composite(&manager, ("A", 1), "other", &[]));
    create(&mut client, of_composite(&manager, ("B", 2), "other", &[]));
    create(&mut client, shared(&manager, ("C", 3), "other", &[]));
    let states =
        |client: &mut Client| ["A", "B", "C"].map(|instance| component(client, instance).state);
    for instance in ["A", "B", "C"] {
        ok(&mut client, activate(instance));
    }
    let failing = configure("A", &[("fail", "on_execute"), ("reason", "told to")]);
    ok(&mut client, failing);
    ok(&mut client, tick("C", 2));
    assert_eq!(states(&mut client), ["Error", "Error", "Active"]);
    let why = component(&mut client, "B").message.unwrap();
    assert_eq!(why, "A of arm is in Error: on_execute: told to");
    assert_eq!(component(&mut client, "B").executions, 1);

    ok(&mut client, configure("A", &[("fail", "")]));
    let reset = RequestBody::Reset {
        instance: "B".to_owned(),
    };
    ok(&mut client, reset);
    assert_eq!(states(&mut client), ["Inactive", "Inactive", "Active"]);
    ok(&mut client, activate("A"));
    ok(&mut client, activate("B"));
    ok(&mut client, deactivate("B"));
    assert_eq!(states(&mut client), ["Inactive", "Inactive", "Active"]);

    // None is activated beside one that is in Error.
    ok(&mut client, configure("A", &[("fail", "on_activated")]));
    refused(&mut client, activate("A"), SOON);
    let failure = refused(&mut client, activate("B"), SOON);
    assert_eq!(
        failure.message,
        "B: A, with which it shares its state in arm, is in Error: reset that first"
    );
}
