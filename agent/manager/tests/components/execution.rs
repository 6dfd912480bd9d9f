//! Execution contexts that are not periodic, and how all of them keep their time.

#[path = "execution/realtime.rs"]
mod realtime;
#[path = "execution/shared.rs"]
mod shared;

use rts_manager_api::control::*;

use self::shared::delete;
use crate::support::*;

/// A request for a Testmod that is driven in this way.
fn driven(
    manager: &Running,
    instance: &str,
    kind: &str,
    parameters: &[(&str, &str)],
) -> RequestBody {
    match manager.testmod(instance, parameters) {
        RequestBody::Create(request) => RequestBody::Create(CreateRequest {
            execution_kind: kind.to_owned(),
            ..request
        }),
        other => panic!("{other:?}"),
    }
}

fn tick(instance: &str, cycles: u32) -> RequestBody {
    RequestBody::Tick {
        instance: instance.to_owned(),
        cycles,
    }
}

#[test]
fn one_that_is_ticked_runs_as_many_cycles_and_one_that_waits_for_samples_runs_when_they_come() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    ok(
        &mut client,
        driven(&manager, "A", "other", &[("produce", "1")]),
    );
    let made = ok(&mut client, driven(&manager, "B", "eventDriven", &[]));
    let ResponseBody::Created { incarnation } = made else {
        panic!()
    };
    let request = connection("A", "B", &incarnation, None);
    ok(&mut client, binding(&request.connector, "B", "in", "A.out"));
    ok(&mut client, RequestBody::Connect(request));

    let failure = refused(&mut client, tick("A", 1), SOON);
    assert_eq!(failure.message, "A is Inactive after 0 of 1 cycles");
    let failure = refused(&mut client, tick("B", 1), SOON);
    assert_eq!(
        failure.message,
        "B is run by its own execution context (eventDriven); only one of the kind other is ticked"
    );

    ok(&mut client, activate("B"));
    ok(&mut client, activate("A"));
    let read = |client: &mut _| component(client, "B").bindings[0].samples_received;
    for round in 1..=5 {
        ok(&mut client, tick("A", 3));
        let a = component(&mut client, "A");
        assert_eq!(a.executions, 3 * round);
        assert_eq!(a.execution_kind, "other");
        until("what was sent is read", || read(&mut client) == 3 * round);
    }
    let b = component(&mut client, "B");
    assert!((5..=15).contains(&b.executions), "{}", b.executions);
    let timing = b.timing.unwrap();
    assert_eq!(timing.execution.count, b.executions);
    assert_eq!((timing.overruns, timing.jitter), (0, None));

    // What fails ends the cycles and says why.
    ok(
        &mut client,
        configure("A", &[("fail", "on_execute"), ("reason", "told to")]),
    );
    let failure = refused(&mut client, tick("A", 3), SOON);
    assert_eq!(failure.code, FailureCode::ComponentFailed);
    assert_eq!(
        failure.message,
        "A is Error after 1 of 3 cycles: on_execute: told to"
    );
    // In Error a tick calls `on_error`, and the answer says what it is in.
    let failure = refused(&mut client, tick("A", 2), SOON);
    assert_eq!(
        failure.message,
        "A is Error after 2 of 2 cycles: on_execute: told to"
    );
    ok(&mut client, deactivate("B"));
    ok(&mut client, activate("B"));
    ok(&mut client, deactivate("B"));
}

#[test]
fn what_asked_for_a_cycle_before_the_activation_is_forgotten() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    let source = driven(&manager, "A", "other", &[("produce", "1")]);
    ok(&mut client, source);
    let made = ok(&mut client, driven(&manager, "B", "eventDriven", &[]));
    let ResponseBody::Created { incarnation } = made else {
        panic!()
    };
    let request = connection("A", "B", &incarnation, None);
    ok(&mut client, binding(&request.connector, "B", "in", "A.out"));
    ok(&mut client, RequestBody::Connect(request));
    ok(&mut client, activate("A"));
    ok(&mut client, tick("A", 3));
    ok(&mut client, activate("B"));
    // Answered by its thread, between two looks at what is to be run.
    ok(&mut client, configure("B", &[("reason", "none")]));
    ok(&mut client, configure("B", &[("reason", "none yet")]));
    assert_eq!(component(&mut client, "B").executions, 0);
    ok(&mut client, tick("A", 1));
    until("the new one is read", || {
        component(&mut client, "B").bindings[0].samples_received == 1
    });
    assert_eq!(component(&mut client, "B").executions, 1);
}

#[test]
fn a_tick_gives_way_to_whoever_asks_something_else() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    let slow = [("hang", "on_execute"), ("hang_ms", "10")];
    ok(&mut client, driven(&manager, "A", "other", &slow));
    ok(&mut client, activate("A"));
    let mut other = manager.client();
    let ticker = std::thread::spawn(move || other.call(tick("A", 1_000_000), SOON * 10));
    until("it is ticked", || {
        component(&mut client, "A").executions > 2
    });
    ok(&mut client, deactivate("A"));
    assert_eq!(component(&mut client, "A").state, "Inactive");
    let refused = ticker.join().unwrap().unwrap_err().to_string();
    let why = "of 1000000 cycles, until something else was asked of its own execution context";
    assert!(refused.contains(why), "{refused}");
}

fn load_failing() -> RequestBody {
    RequestBody::LoadModule {
        type_name: "Failing".to_owned(),
        path: built("libfailing.so").display().to_string(),
        digest: None,
    }
}

#[test]
fn an_event_driven_component_may_ask_for_its_own_cycles() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_failing());
    for (instance, kind) in [("A", "eventDriven"), ("B", "periodic")] {
        let made = driven(&manager, instance, kind, &[("produce", "-1")]);
        let RequestBody::Create(mut request) = made else {
            panic!()
        };
        request.type_name = "Failing".to_owned();
        ok(&mut client, RequestBody::Create(request));
    }
    ok(&mut client, activate("A"));
    until("it runs", || component(&mut client, "A").executions >= 3);
    ok(&mut client, deactivate("A"));
    let failure = refused(&mut client, activate("B"), SOON);
    assert_eq!(
        failure.message,
        "B: on_activated: the execution context cannot be woken: it is not event-driven"
    );
}

#[test]
fn a_periodic_one_counts_how_late_it_begins_and_how_often_it_is_not_done_in_time() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[("hang", "on_execute"), ("hang_ms", "3")]);
    ok(&mut client, activate("A"));
    until("cycles are counted", || {
        component(&mut client, "A").executions >= 3
    });
    ok(&mut client, deactivate("A"));
    let seen = component(&mut client, "A");
    let timing = seen.timing.unwrap();
    // At 1000 Hz a cycle of 3 ms is never in time.
    assert_eq!(timing.overruns, seen.executions);
    assert!(timing.execution.median >= 3_000_000, "{timing:?}");
    assert_eq!(timing.jitter.unwrap().count, seen.executions);
}

/// Names of the threads of the manager.
fn threads(manager: &Running) -> Vec<String> {
    let tasks =
        std::fs::read_dir(format!("/proc/{}/task", manager.child.id())).expect("it is there");
    let names =
        tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("comm")).ok());
    names.map(|name| name.trim_end().to_owned()).collect()
}

/// The thread has a waker, and it is not ended with the component.
#[test]
fn a_thread_of_the_component_asks_for_cycles_until_it_has_ended() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_failing());
    let RequestBody::Create(request) = driven(&manager, "A", "eventDriven", &[("thread", "true")])
    else {
        panic!()
    };
    let request = CreateRequest {
        type_name: "Failing".to_owned(),
        ..request
    };
    ok(&mut client, RequestBody::Create(request));
    ok(&mut client, activate("A"));
    until("its thread has it run", || {
        component(&mut client, "A").executions >= 5
    });
    assert!(threads(&manager).contains(&"waker".to_owned()));
    ok(&mut client, delete("A"));
    until("its thread has ended too", || {
        !threads(&manager).contains(&"waker".to_owned())
    });
    assert_eq!(inventory(&mut client).components, []);
}
