//! Execution contexts that are not periodic, and how all of them keep their time.

use rts_manager_api::control::*;

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
    assert_eq!(failure.message, "A is Error after 1 of 3 cycles");
    ok(&mut client, deactivate("B"));
    ok(&mut client, activate("B"));
    ok(&mut client, deactivate("B"));
}

#[test]
fn an_event_driven_component_may_ask_for_its_own_cycles() {
    let manager = start("m");
    let mut client = manager.client();
    let load = RequestBody::LoadModule {
        type_name: "Failing".to_owned(),
        path: built("libfailing.so").display().to_string(),
        digest: None,
    };
    ok(&mut client, load);
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

/// A request for a Testmod whose execution context is to have this.
fn with(manager: &Running, instance: &str, asked: RealtimeRequest) -> RequestBody {
    match driven(manager, instance, "periodic", &[]) {
        RequestBody::Create(request) => RequestBody::Create(CreateRequest {
            realtime: Some(asked),
            ..request
        }),
        other => panic!("{other:?}"),
    }
}

/// Policy and priority of the thread of a component, as the kernel has them.
fn kernel(manager: &Running, instance: &str) -> (u32, u32) {
    let tasks = format!("/proc/{}/task", manager.child.id());
    let tasks = std::fs::read_dir(tasks).unwrap();
    let mut stats = tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("stat")).ok());
    let stat = stats.find(|stat| stat.contains(&format!("({instance})")));
    let stat = stat.unwrap();
    let fields: Vec<&str> = stat.rsplit_once(") ").unwrap().1.split(' ').collect();
    // The 40th and 41st of proc_pid_stat(5), of which the name is the second.
    (fields[38].parse().unwrap(), fields[37].parse().unwrap())
}

#[test]
fn an_execution_context_is_on_sched_fifo_or_the_machine_says_why_not() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    let asked = RealtimeRequest {
        priority: Some(7),
        required: true,
        ..RealtimeRequest::default()
    };
    match client.call(with(&manager, "A", asked.clone()), SOON) {
        Ok(_) => {
            let found = component(&mut client, "A").realtime.unwrap();
            assert_eq!((found.scheduler.as_str(), found.priority), ("SCHED_FIFO", 7));
            assert_eq!((found.asked, found.denied), (asked, vec![]));
            assert_eq!(kernel(&manager, "A"), (1, 7));
        }
        Err(refused) => {
            let message = refused.to_string();
            for said in ["A cannot have SCHED_FIFO priority 7", "start its agent", "required: false"] {
                assert!(message.contains(said), "{message}");
            }
            assert_eq!(inventory(&mut client).components, []);
        }
    }
    // One beside it has nothing of its own.
    manager.create("B", &[]);
    assert_eq!(component(&mut client, "B").realtime, None);
    assert_eq!(kernel(&manager, "B"), (0, 0));
}

#[test]
fn a_processor_that_is_not_there_is_refused_or_told() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    let asked = |required| RealtimeRequest {
        cpus: Some("1023".to_owned()),
        required,
        ..RealtimeRequest::default()
    };
    let failure = refused(&mut client, with(&manager, "A", asked(true)), SOON);
    let why = "cannot run on the processors 1023 (resources.cpus): none of them is there";
    assert!(failure.message.starts_with(&format!("A {why}")), "{failure}");
    assert_eq!(failure.code, FailureCode::ComponentFailed);
    assert_eq!(inventory(&mut client).components, []);

    ok(&mut client, with(&manager, "A", asked(false)));
    ok(&mut client, activate("A"));
    let found = component(&mut client, "A").realtime.unwrap();
    assert!(found.denied[0].starts_with(why), "{:?}", found.denied);
    assert_ne!(found.cpus, "");
    assert!(manager.log("A").contains(why), "{}", manager.log("A"));
}
