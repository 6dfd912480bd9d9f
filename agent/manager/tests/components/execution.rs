//! Execution contexts that are not periodic, and how all of them keep their time.

use std::time::Duration;

use rts_manager_api::client::Client;
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

/// The same for one that shares an execution context.
fn shared(
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

fn create(client: &mut Client, request: CreateRequest) -> String {
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

fn delete(instance: &str) -> RequestBody {
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
    let tasks = std::fs::read_dir(tasks).expect("it is there");
    let mut stats =
        tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("stat")).ok());
    let stat = stats.find(|stat| stat.contains(&format!("({instance})")));
    let stat = stat.expect("it is there");
    let fields: Vec<&str> = stat
        .rsplit_once(") ")
        .expect("it is there")
        .1
        .split(' ')
        .collect();
    // The 40th and 41st of proc_pid_stat(5), of which the name is the second.
    (
        fields[38].parse().expect("it is there"),
        fields[37].parse().expect("it is there"),
    )
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
            assert_eq!(
                (found.scheduler.as_str(), found.priority),
                ("SCHED_FIFO", 7)
            );
            assert_eq!((found.asked, found.denied), (asked, vec![]));
            assert_eq!(kernel(&manager, "A"), (1, 7));
        }
        Err(refused) => {
            let message = refused.to_string();
            for said in [
                "A cannot have SCHED_FIFO priority 7",
                "start its agent",
                "required: false",
            ] {
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
    assert!(
        failure.message.starts_with(&format!("A {why}")),
        "{failure}"
    );
    assert_eq!(failure.code, FailureCode::ComponentFailed);
    assert_eq!(inventory(&mut client).components, []);

    ok(&mut client, with(&manager, "A", asked(false)));
    ok(&mut client, activate("A"));
    let found = component(&mut client, "A").realtime.unwrap();
    assert!(found.denied[0].starts_with(why), "{:?}", found.denied);
    assert_ne!(found.cpus, "");
    assert!(manager.log("A").contains(why), "{}", manager.log("A"));
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

/// Components of one thread cannot have different ones; what one asked for is let go with it.
#[test]
fn those_that_share_an_execution_context_have_the_same_of_the_machine() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    let first = {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let allowed = status
            .lines()
            .find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
        let allowed = allowed.unwrap().trim().to_owned();
        allowed.split(['-', ',']).next().unwrap().to_owned()
    };
    let on = |instance, cpus: &str, required| CreateRequest {
        realtime: Some(RealtimeRequest {
            cpus: Some(cpus.to_owned()),
            required,
            ..RealtimeRequest::default()
        }),
        ..shared(&manager, (instance, 0), "periodic", &[])
    };
    create(&mut client, shared(&manager, ("A", 0), "periodic", &[]));
    let all = cpus_of(&manager, "control");
    create(&mut client, on("B", &first, true));
    create(&mut client, on("C", &first, true));
    assert_eq!(component(&mut client, "C").realtime.unwrap().cpus, first);
    assert_eq!(cpus_of(&manager, "control"), first);
    let other = RequestBody::Create(on("D", "1022", true));
    let failure = refused(&mut client, other, SOON);
    assert!(failure.message.contains("that B shares"), "{failure}");
    create(&mut client, on("D", "1022", false));
    assert_eq!(component(&mut client, "D").realtime.unwrap().cpus, first);
    for instance in ["B", "C", "D"] {
        ok(&mut client, delete(instance));
    }
    let lost = RequestBody::Create(on("E", "1023", true));
    let failure = refused(&mut client, lost, SOON);
    assert!(failure.message.contains("processors 1023"), "{failure}");
    assert_eq!(cpus_of(&manager, "control"), all, "nobody asks any more");
}

/// Processors of a thread of the manager.
fn cpus_of(manager: &Running, thread: &str) -> String {
    let tasks =
        std::fs::read_dir(format!("/proc/{}/task", manager.child.id())).expect("it is there");
    let mut statuses =
        tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("status")).ok());
    let own = statuses.find(|status| status.starts_with(&format!("Name:\t{thread}\n")));
    let own = own.expect("it is there");
    let cpus = own
        .lines()
        .find_map(|line| line.strip_prefix("Cpus_allowed_list:"));
    cpus.expect("it is there").trim().to_owned()
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
