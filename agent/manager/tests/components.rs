//! Components in a real manager process: life cycle, configuration, failures, hangs.

#[path = "components/execution.rs"]
mod execution;
#[path = "components/failures.rs"]
mod failures;
mod support;
#[path = "components/taps.rs"]
mod taps;

use std::collections::BTreeMap;
use std::io::{BufReader, Write};
use std::time::Duration;

use rts_manager_api::control::*;
use rts_manager_api::{PROTOCOL_VERSION, frame};
use support::*;

/// What is asked at once is answered as it ends: nobody waits for what takes longer, and a mistake is that request's own.
#[test]
fn requests_that_come_together_end_each_for_itself() {
    let manager = start("m");
    manager.create("Before", &[]);
    let (mut stream, mut bytes) = (manager.connect(), Vec::new());
    let greeting = Greeting::Control {
        version: PROTOCOL_VERSION,
    };
    frame::write(&mut bytes, &greeting).unwrap();
    let hang = ("hang_ms", "600000");
    let requests = [
        (
            manager.testmod("Late", &[hang, ("hang", "on_initialize")]),
            300,
        ),
        (manager.testmod("A", &[]), 10_000),
        (activate("Nobody"), 10_000),
        (activate("Before"), 10_000),
        (manager.testmod("B", &[]), 10_000),
    ];
    for (id, (body, deadline_ms)) in (1..).zip(requests) {
        let request = Request {
            id,
            deadline_ms,
            body,
        };
        frame::write(&mut bytes, &request).unwrap();
    }
    stream.write_all(&bytes).unwrap();
    let mut reader = BufReader::new(stream);
    let _: Hello = frame::read(&mut reader).unwrap();
    let mut answers = Vec::new();
    while answers.len() < 5 {
        if let FromManager::Response(response) = frame::read_answer(&mut reader).unwrap() {
            answers.push(response);
        }
    }
    assert_eq!(answers[4].id, 1, "it is the last one: {answers:#?}");
    answers.sort_by_key(|answer| answer.id);
    let refusals = |answer: &Response| answer.result.as_ref().err().map(|failure| failure.code);
    assert_eq!(
        answers.iter().map(refusals).collect::<Vec<_>>(),
        [
            Some(FailureCode::Deadline),
            None,
            Some(FailureCode::NotFound),
            None,
            None
        ]
    );
    let mut client = manager.client();
    assert_eq!(component(&mut client, "Before").state, "Active");
    assert_eq!(component(&mut client, "B").state, "Inactive");
}

/// However many they are.
#[test]
fn requests_that_come_together_take_one_thread() {
    let manager = start("m");
    manager.create("A", &[]);
    let hang = ("hang_ms", "600000");
    let late = manager.testmod("Late", &[hang, ("hang", "on_initialize")]);
    let ask = |id: u64, body| Request {
        id,
        deadline_ms: 500,
        body,
    };
    let (mut stream, mut bytes) = (manager.connect(), Vec::new());
    let greeting = Greeting::Control {
        version: PROTOCOL_VERSION,
    };
    frame::write(&mut bytes, &greeting).unwrap();
    frame::write(&mut bytes, &ask(0, late)).unwrap();
    // Each waits until its deadline, or for the component to be there.
    const MANY: u64 = 50;
    for id in 1..=MANY {
        frame::write(&mut bytes, &ask(id, activate("Late"))).unwrap();
    }
    stream.write_all(&bytes).unwrap();
    let mut reader = BufReader::new(stream);
    let _: Hello = frame::read(&mut reader).unwrap();
    let mut answers = 0;
    while answers <= MANY {
        if let FromManager::Response(response) = frame::read_answer(&mut reader).unwrap() {
            assert!(response.result.is_err(), "{response:?}");
            answers += 1;
        }
    }
    // A thread that is not needed stays for a while.
    let tasks = format!("/proc/{}/task", manager.child.id());
    let tasks = std::fs::read_dir(tasks).unwrap().flatten();
    let names = tasks.filter_map(|task| std::fs::read_to_string(task.path().join("comm")).ok());
    let threads = names.filter(|name| name.trim() == "request").count();
    assert!((1..20).contains(&threads), "{threads} threads");
}

#[test]
fn a_component_lives_and_is_seen() {
    let manager = start("m");
    let mut client = manager.client();
    assert_eq!(client.hello().name, "m");
    assert_eq!(client.hello().incarnation, "i-1");
    let ResponseBody::Module(module) = ok(&mut client, load_testmod()) else {
        panic!()
    };
    assert_eq!(module.parameters["produce"], "0");
    assert_eq!(
        ok(&mut client, load_testmod()),
        ResponseBody::Module(module)
    );

    let incarnation = manager.create("A", &[("produce", "1")]);
    let seen = component(&mut client, "A");
    assert_eq!((seen.state.as_str(), seen.rate), ("Inactive", 1000.0));
    assert_eq!(seen.incarnation, incarnation);
    assert_eq!(seen.sets["default"]["produce"], "1");
    assert_eq!(seen.sets["default"]["hang_ms"], "0");
    assert_eq!(seen.defaults["produce"], "0");
    assert_eq!(seen.defaults.len(), 6);
    assert_eq!(seen.busy, None);
    assert_eq!(seen.executions, 0);

    ok(&mut client, activate("A"));
    ok(&mut client, activate("A"));
    until("it executes", || {
        component(&mut client, "A").executions >= 3
    });
    ok(&mut client, deactivate("A"));
    let seen = component(&mut client, "A");
    assert_eq!(seen.state, "Inactive");
    let delete = || RequestBody::Delete {
        instance: "A".to_owned(),
    };
    ok(&mut client, delete());
    ok(&mut client, delete());
    assert!(inventory(&mut client).components.is_empty());

    let log = manager.log("A");
    let words: Vec<_> = log
        .lines()
        .map(|line| line.split_once(' ').unwrap().1)
        .collect();
    assert_eq!(
        words,
        [
            "INFO on_initialize",
            "INFO Created -> Inactive",
            "INFO on_startup",
            "INFO on_activated",
            "INFO Inactive -> Active",
            "INFO on_deactivated",
            "INFO Active -> Inactive",
            "INFO on_shutdown",
            "INFO on_finalize",
            "INFO Inactive -> Created",
            "INFO deleted",
        ]
    );
}

#[test]
fn what_makes_no_sense_is_refused_and_says_why() {
    let manager = start("m");
    let mut client = manager.client();
    let mut refuse = |body| {
        let failure = refused(&mut client, body, SOON);
        (failure.code, failure.message)
    };
    let (code, message) = refuse(manager.testmod("A", &[]));
    assert_eq!(code, FailureCode::NotFound);
    assert_eq!(
        message,
        "the type `Testmod` is not loaded; loaded are: none"
    );

    let (code, message) = refuse(RequestBody::LoadModule {
        type_name: "X".to_owned(),
        path: "/nowhere/libx.so".to_owned(),
        digest: None,
    });
    assert_eq!(code, FailureCode::LoadFailed);
    assert!(message.contains("No such file"), "{message}");

    let RequestBody::LoadModule { path, .. } = load_testmod() else {
        panic!()
    };
    let (code, message) = refuse(RequestBody::LoadModule {
        type_name: "Other".to_owned(),
        path: path.clone(),
        digest: None,
    });
    assert_eq!(code, FailureCode::LoadFailed);
    assert!(
        message.contains("it holds the type `Testmod`, not `Other`"),
        "{message}"
    );

    manager.create("A", &[]);
    let (code, message) = refuse(manager.testmod("A", &[]));
    assert_eq!(code, FailureCode::Conflict);
    assert!(
        message.starts_with("there is a component `A` already"),
        "{message}"
    );

    let (code, message) = refuse(manager.testmod("B", &[("colour", "red")]));
    assert_eq!(code, FailureCode::Invalid);
    assert_eq!(
        message,
        "B: there is no parameter `colour`; the parameters are: code, fail, hang, hang_ms, produce, reason"
    );
    let (code, message) = refuse(manager.testmod("B", &[("produce", "many")]));
    assert_eq!(code, FailureCode::Invalid);
    assert_eq!(
        message,
        "B: parameter `produce` = `many`: it is not a number"
    );
    let (code, message) = refuse(manager.testmod("B", &[("fail", "on_initialize")]));
    assert_eq!(code, FailureCode::ComponentFailed);
    assert_eq!(message, "B: on_initialize returned RTC_ERROR");

    let (code, message) = refuse(RequestBody::UnloadModule {
        type_name: "Testmod".to_owned(),
    });
    assert_eq!(code, FailureCode::Conflict);
    assert!(message.contains("used by A"), "{message}");
    let (code, message) = refuse(activate("Z"));
    assert_eq!(code, FailureCode::NotFound);
    assert_eq!(
        message,
        "there is no component `Z` in the manager m; there are: A"
    );

    let instances: Vec<_> = inventory(&mut client)
        .components
        .into_iter()
        .map(|c| c.instance)
        .collect();
    assert_eq!(instances, ["A"]);
}

#[test]
fn configuration_changes_in_place_all_or_nothing() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[]);
    let configure = |sets: &[(&str, &str)], rate| RequestBody::Configure {
        instance: "A".to_owned(),
        sets: default_set(sets),
        active: None,
        rate,
        on_disconnect: None,
        order: None,
        by_hand: None,
    };
    ok(
        &mut client,
        configure(&[("produce", "2"), ("code", "5")], Some(50.0)),
    );
    let seen = component(&mut client, "A");
    assert_eq!(seen.sets["default"]["produce"], "2");
    assert_eq!(seen.rate, 50.0);
    assert!(manager.log("A").contains("on_rate_changed"));

    // `code` comes before `produce`: it is set, and set back.
    let failure = refused(
        &mut client,
        configure(&[("code", "3"), ("produce", "x")], None),
        SOON,
    );
    assert_eq!(failure.code, FailureCode::Invalid);
    assert_eq!(component(&mut client, "A").sets["default"]["code"], "5");
    let log = manager.log("A");
    assert!(log.contains("configured code = 5"), "{log}");
    assert!(!log.contains("configured code = 3"), "{log}");
    let failure = refused(&mut client, configure(&[], Some(0.0)), SOON);
    assert_eq!(
        failure.message,
        "the rate 0 Hz is refused: a rate is a number of hertz from 0.001 to 1000000"
    );
    ok(&mut client, configure(&[], Some(1_000_000.0)));
    ok(&mut client, activate("A"));
    until("it runs as fast as it can and still obeys", || {
        component(&mut client, "A").executions > 10_000
    });
    ok(&mut client, deactivate("A"));

    ok(&mut client, configure(&[("fail", "on_execute")], None));
    ok(&mut client, activate("A"));
    until("the old code is in force", || {
        component(&mut client, "A").message.as_deref()
            == Some("on_execute returned PRECONDITION_NOT_MET")
    });
}

#[test]
fn a_failure_leads_to_error_with_its_reason_and_reset_leads_out() {
    let manager = start("m");
    let mut client = manager.client();
    let mut events = Listener::connect(&manager);
    manager.create("A", &[("fail", "on_execute"), ("reason", "no oil")]);
    ok(&mut client, activate("A"));
    assert_eq!(
        events.event("component/A"),
        "went to Error: on_execute: no oil"
    );
    let seen = component(&mut client, "A");
    assert_eq!(seen.state, "Error");
    assert_eq!(seen.message.as_deref(), Some("on_execute: no oil"));
    assert!(
        manager
            .log("A")
            .contains("ERROR Active -> Error: on_execute: no oil")
    );

    ok(&mut client, deactivate("A"));
    assert_eq!(component(&mut client, "A").state, "Error");
    let failure = refused(&mut client, activate("A"), SOON);
    assert_eq!(failure.code, FailureCode::ComponentFailed);
    assert_eq!(
        failure.message,
        "A: it is in Error: reset it first (on_execute: no oil)"
    );
    let configure = |value: &str| RequestBody::Configure {
        instance: "A".to_owned(),
        sets: default_set(&[("fail", value)]),
        active: None,
        rate: None,
        on_disconnect: None,
        order: None,
        by_hand: None,
    };
    let reset = || RequestBody::Reset {
        instance: "A".to_owned(),
    };
    ok(&mut client, configure("on_reset"));
    assert_eq!(
        refused(&mut client, reset(), SOON).message,
        "A: on_reset: no oil"
    );
    ok(&mut client, configure(""));
    ok(&mut client, reset());
    let seen = component(&mut client, "A");
    assert_eq!((seen.state.as_str(), seen.message), ("Inactive", None));

    ok(&mut client, configure("on_activated"));
    assert_eq!(
        refused(&mut client, activate("A"), SOON).message,
        "A: on_activated: no oil"
    );
    assert_eq!(component(&mut client, "A").state, "Error");
    assert!(manager.log("A").contains("on_aborting"));
}

#[test]
fn a_rate_that_a_component_cannot_take_holds_and_leads_to_error() {
    let manager = start("m");
    let mut client = manager.client();
    let mut events = Listener::connect(&manager);
    // What it says comes to terminals as one line.
    let fail = [("fail", "on_rate_changed"), ("reason", "too\r\nfast\n")];
    manager.create("A", &fail);
    ok(&mut client, activate("A"));
    let change = RequestBody::Configure {
        instance: "A".to_owned(),
        sets: BTreeMap::new(),
        active: None,
        rate: Some(50.0),
        on_disconnect: None,
        order: None,
        by_hand: None,
    };
    let failure = refused(&mut client, change.clone(), SOON);
    assert_eq!(failure.code, FailureCode::ComponentFailed);
    assert_eq!(failure.message, "A: on_rate_changed: too fast");
    assert_eq!(
        events.event("component/A"),
        "went to Error: on_rate_changed: too fast"
    );
    let seen = component(&mut client, "A");
    assert_eq!((seen.state.as_str(), seen.rate), ("Error", 50.0));
    assert_eq!(seen.message.as_deref(), Some("on_rate_changed: too fast"));
    // The same again is no change; it stays in Error until it is reset.
    ok(&mut client, change);
    assert_eq!(component(&mut client, "A").state, "Error");
    let reset = RequestBody::Reset {
        instance: "A".to_owned(),
    };
    ok(&mut client, reset);
    let seen = component(&mut client, "A");
    assert_eq!((seen.state.as_str(), seen.rate), ("Inactive", 50.0));
}

#[test]
fn one_that_hangs_is_named_and_stops_nobody_else() {
    let mut manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[("hang", "on_activated"), ("hang_ms", "60000")]);
    manager.create("B", &[]);
    let mut events = Listener::connect(&manager);
    let failure = refused(&mut client, activate("A"), Duration::from_millis(500));
    assert_eq!(failure.code, FailureCode::Deadline);
    assert!(
        failure
            .message
            .starts_with("A has been in on_activated for"),
        "{failure}"
    );

    ok(&mut client, activate("B"));
    let start = std::time::Instant::now();
    assert_eq!(component(&mut client, "A").state, "Inactive");
    until("B executes", || component(&mut client, "B").executions > 3);
    let failure = refused(&mut client, deactivate("A"), Duration::from_millis(500));
    assert!(
        failure
            .message
            .starts_with("A has been in on_activated for")
    );
    assert!(start.elapsed() < Duration::from_secs(15));
    until("the hang is shown", || {
        component(&mut client, "A").busy.is_some_and(|busy| {
            assert_eq!(busy.callback, "on_activated");
            busy.milliseconds >= 1000
        })
    });
    assert_eq!(component(&mut client, "B").busy, None);

    // A second component that comes back late says so by itself.
    manager.create("C", &[("hang", "on_activated"), ("hang_ms", "3000")]);
    let failure = refused(&mut client, activate("C"), Duration::from_millis(500));
    assert_eq!(failure.code, FailureCode::Deadline);
    assert_eq!(
        events.event("component/C"),
        "is Active, after its request's deadline"
    );

    // So does one whose creation was given up on; until then its name is taken.
    let slow = || manager.testmod("D", &[("hang", "on_initialize"), ("hang_ms", "3000")]);
    let failure = refused(&mut client, slow(), Duration::from_millis(500));
    assert!(
        failure
            .message
            .starts_with("D has been in on_initialize for"),
        "{failure}"
    );
    assert_eq!(component(&mut client, "D").state, "Created");
    assert_eq!(
        refused(&mut client, slow(), SOON).code,
        FailureCode::Conflict
    );
    assert_eq!(
        events.event("component/D"),
        "was initialised after its deadline"
    );
    assert_eq!(component(&mut client, "D").state, "Inactive");

    // Shutdown does not wait for it beyond its deadline.
    let start = std::time::Instant::now();
    let answer = client.call(RequestBody::Shutdown, Duration::from_millis(600));
    assert!(matches!(answer, Ok(ResponseBody::Done)), "{answer:?}");
    assert!(manager.wait().success());
    assert!(start.elapsed() < Duration::from_secs(15));
    assert!(manager.log("B").contains("on_finalize"));
}

#[test]
fn requests_on_one_connection_do_not_wait_for_each_other() {
    use rts_manager_api::frame;
    let manager = start("m");
    manager.create("A", &[("hang", "on_activated"), ("hang_ms", "60000")]);
    manager.create("B", &[]);
    let mut stream = manager.connect();
    frame::write(&mut stream, &Greeting::Control { version: 1 }).unwrap();
    let _: Hello = frame::read(&mut stream).unwrap();
    for (id, body) in [
        (1, activate("A")),
        (2, activate("B")),
        (3, RequestBody::Inventory),
    ] {
        let request = Request {
            id,
            deadline_ms: 1500,
            body,
        };
        frame::write(&mut stream, &request).unwrap();
    }
    let mut order = Vec::new();
    while order.len() < 3 {
        if let FromManager::Response(response) = frame::read(&mut stream).unwrap() {
            order.push((response.id, response.result.is_ok()));
        }
    }
    assert_eq!(order[2], (1, false));
    assert!(order[..2].contains(&(2, true)) && order[..2].contains(&(3, true)));
}

#[test]
fn a_request_that_came_too_late_is_never_answered_as_if_the_component_were_gone() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[]);
    ok(&mut client, activate("A"));
    for _ in 0..2000 {
        let failure = refused(&mut client, deactivate("A"), Duration::ZERO);
        assert_eq!(failure.code, FailureCode::Deadline, "{failure}");
    }
    assert_eq!(component(&mut client, "A").state, "Active");
}
