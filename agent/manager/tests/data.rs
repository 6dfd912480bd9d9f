//! Samples between components of one and of two real manager processes.

mod support;

use std::collections::BTreeMap;
use std::os::unix::net::UnixStream;

use rts_manager_api::PROTOCOL_VERSION;
use rts_manager_api::client::Client;
use rts_manager_api::control::*;
use rts_manager_api::data::{DataHello, DataReply};
use rts_manager_api::frame;
use support::*;

const C: &str = "A.out-B.in";

fn connector(client: &mut Client) -> ConnectorInfo {
    component(client, "A").connectors.remove(0)
}

fn bound(client: &mut Client) -> BindingInfo {
    component(client, "B").bindings.remove(0)
}

/// A in one manager, B in another, connected, both active.
fn pair() -> (Running, Client, Running, Client) {
    let (left, right) = (start("left"), start("right"));
    let (mut l, mut r) = (left.client(), right.client());
    left.create("A", &[("produce", "1")]);
    let incarnation = right.create("B", &[]);
    let answer = ok(&mut r, binding(C, "B", "in", "A.out"));
    assert_eq!(
        answer,
        ResponseBody::Bound {
            incarnation: incarnation.clone()
        }
    );
    let request = connection("A", "B", &incarnation, Some(&right.socket()));
    ok(&mut l, RequestBody::Connect(request));
    ok(&mut r, activate("B"));
    ok(&mut l, activate("A"));
    (left, l, right, r)
}

#[test]
fn inside_a_process_samples_arrive_in_order_and_are_counted() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[("produce", "1")]);
    let incarnation = manager.create("B", &[]);
    ok(&mut client, binding(C, "B", "in", "A.out"));
    let request = connection("A", "B", &incarnation, None);
    ok(&mut client, RequestBody::Connect(request.clone()));
    ok(&mut client, activate("B"));
    ok(&mut client, activate("A"));
    until("samples flow", || {
        let inventory = inventory(&mut client);
        let (a, b) = (&inventory.components[0], &inventory.components[1]);
        assert!(b.bindings[0].samples_received <= a.connectors[0].samples_sent);
        b.bindings[0].samples_received >= 50
    });
    // Again is no change; and nothing of it counts as a loss.
    ok(&mut client, RequestBody::Connect(request));
    ok(&mut client, deactivate("A"));
    until("all is read", || {
        bound(&mut client).samples_received == connector(&mut client).samples_sent
    });
    let (sent, received) = (connector(&mut client), bound(&mut client));
    assert_eq!(
        (sent.state.as_str(), sent.transport.as_str()),
        ("Connected", "direct")
    );
    assert_eq!((sent.drops, received.drops, received.gaps), (0, 0, 0));
    assert_eq!(sent.bytes, 8 * sent.samples_sent);
    assert_eq!(sent.properties["k"], "v");
    assert!(received.connected);
    assert_eq!(component(&mut client, "B").state, "Active");

    let mut events = Listener::connect(&manager);
    ok(
        &mut client,
        RequestBody::Delete {
            instance: "B".to_owned(),
        },
    );
    assert_eq!(
        events.event("connector/A.out-B.in"),
        "its target B.in has gone"
    );
    assert_eq!(connector(&mut client).state, "Disconnected");
    ok(
        &mut client,
        RequestBody::Disconnect {
            instance: "A".to_owned(),
            connector: C.to_owned(),
            by_hand: None,
        },
    );
    assert!(component(&mut client, "A").connectors.is_empty());
}

#[test]
fn between_processes_samples_arrive_in_order_and_are_counted() {
    let (_left, mut l, _right, mut r) = pair();
    until("samples flow", || bound(&mut r).samples_received >= 50);
    ok(&mut l, deactivate("A"));
    until("all is read", || {
        bound(&mut r).samples_received == connector(&mut l).samples_sent
    });
    let (sent, received) = (connector(&mut l), bound(&mut r));
    assert_eq!(
        (sent.state.as_str(), sent.transport.as_str()),
        ("Connected", "uds")
    );
    assert_eq!((sent.drops, received.drops, received.gaps), (0, 0, 0));
    assert_eq!(component(&mut r, "B").state, "Active");
}

#[test]
fn a_reader_that_is_too_slow_loses_the_oldest_and_sees_gaps() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[("produce", "200")]);
    let incarnation = manager.create("B", &[("hang", "on_execute"), ("hang_ms", "200")]);
    ok(
        &mut client,
        RequestBody::Connect(connection("A", "B", &incarnation, None)),
    );
    ok(&mut client, activate("B"));
    ok(&mut client, activate("A"));
    until("samples are lost", || bound(&mut client).drops > 0);
    ok(&mut client, deactivate("A"));
    until("the rest is read", || {
        let (sent, received) = (connector(&mut client), bound(&mut client));
        received.samples_received + received.drops == sent.samples_sent
    });
    let received = bound(&mut client);
    assert!(received.samples_received >= 64 && received.gaps >= 1);
    assert_eq!(component(&mut client, "B").state, "Active");
}

#[test]
fn what_was_sent_before_the_reader_was_active_is_never_read() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[("produce", "1")]);
    let incarnation = manager.create("B", &[]);
    ok(
        &mut client,
        RequestBody::Connect(connection("A", "B", &incarnation, None)),
    );
    ok(&mut client, activate("A"));
    until("samples wait", || connector(&mut client).samples_sent >= 5);
    ok(&mut client, deactivate("A"));
    let early = connector(&mut client).samples_sent;
    ok(&mut client, activate("B"));
    until("B executes", || component(&mut client, "B").executions > 2);
    let seen = bound(&mut client);
    assert_eq!((seen.samples_received, seen.drops), (0, early));

    ok(&mut client, activate("A"));
    until("samples flow", || bound(&mut client).samples_received >= 3);
    ok(&mut client, deactivate("A"));
    until("all is read", || {
        bound(&mut client).samples_received + early == connector(&mut client).samples_sent
    });
    assert_eq!(bound(&mut client).gaps, 0);
}

#[test]
fn a_connection_that_was_not_agreed_is_refused() {
    let (left, right) = (start("left"), start("right"));
    let (mut l, mut r) = (left.client(), right.client());
    left.create("A", &[]);
    let incarnation = right.create("B", &[]);
    let good = connection("A", "B", &incarnation, Some(&right.socket()));
    let mut refuse = |request: &ConnectRequest| {
        let failure = refused(&mut l, RequestBody::Connect(request.clone()), SOON);
        assert!(component(&mut l, "A").connectors.is_empty());
        (failure.code, failure.message)
    };
    let (code, message) = refuse(&good);
    assert_eq!(code, FailureCode::NotFound);
    assert_eq!(
        message,
        "B.in does not expect the connector A.out-B.in: it must be bound first"
    );
    ok(&mut r, binding(C, "B", "in", "Z.out"));
    let (code, message) = refuse(&good);
    assert_eq!(code, FailureCode::Conflict);
    assert!(
        message.contains("is bound from Z.out to B.in, not from A.out"),
        "{message}"
    );

    ok(&mut r, binding(C, "B", "in", "A.out"));
    let mut restarted = good.clone();
    restarted.target_incarnation = "other".to_owned();
    let (code, message) = refuse(&restarted);
    assert_eq!(code, FailureCode::Conflict);
    assert!(message.contains("was started again"), "{message}");

    ok(&mut r, binding(C, "B", "text", "A.out"));
    let mut wrong = good.clone();
    wrong.target_port = "text".to_owned();
    let types = "A.out sends IDL:RTC/TimedDouble:1.0, but B.text takes IDL:RTC/TimedString:1.0";
    let (code, message) = refuse(&wrong);
    assert_eq!((code, message.as_str()), (FailureCode::Invalid, types));

    let mut nowhere = good.clone();
    nowhere.target_socket = Some("/nowhere/control.sock".to_owned());
    let (code, message) = refuse(&nowhere);
    assert_eq!(code, FailureCode::PeerFailed);
    assert!(message.contains("cannot be reached"), "{message}");

    let incarnation = left.create("B", &[]);
    wrong.target_socket = None;
    wrong.target_incarnation = incarnation;
    let (code, message) = refuse(&wrong);
    assert_eq!((code, message.as_str()), (FailureCode::Invalid, types));
    assert!(component(&mut l, "B").bindings.is_empty());
}

#[test]
fn the_death_of_the_target_is_noticed_and_a_new_one_connected() {
    let (left, mut l, right, mut r) = pair();
    until("samples flow", || bound(&mut r).samples_received >= 3);
    let mut events = Listener::connect(&left);
    ok(&mut l, deactivate("A"));
    right.signal("-KILL");
    let message = events.event("connector/A.out-B.in");
    assert!(message.starts_with("disconnected: "), "{message}");
    let seen = connector(&mut l);
    assert_eq!(seen.state, "Disconnected");
    assert!(seen.samples_sent >= 3);

    let again = start("right");
    let mut r = again.client();
    let incarnation = again.create("B", &[]);
    ok(&mut r, binding(C, "B", "in", "A.out"));
    let request = connection("A", "B", &incarnation, Some(&again.socket()));
    ok(&mut l, RequestBody::Connect(request));
    ok(&mut r, activate("B"));
    ok(&mut l, activate("A"));
    until("samples flow again", || bound(&mut r).samples_received >= 3);
    assert_eq!(bound(&mut r).gaps, 0);
    assert_eq!(component(&mut l, "A").connectors.len(), 1);
}

#[test]
fn the_death_of_the_source_is_noticed_and_a_new_one_starts_without_a_gap() {
    let (left, _, right, mut r) = pair();
    until("samples flow", || bound(&mut r).samples_received >= 3);
    let mut events = Listener::connect(&right);
    left.signal("-KILL");
    assert_eq!(
        events.event("connector/A.out-B.in"),
        "its source A.out has gone"
    );
    assert!(!bound(&mut r).connected);

    // Numbers start again with the source, so its reader must as well.
    ok(
        &mut r,
        RequestBody::Delete {
            instance: "B".to_owned(),
        },
    );
    let incarnation = right.create("B", &[]);
    ok(&mut r, binding(C, "B", "in", "A.out"));
    ok(&mut r, activate("B"));
    let again = start("left");
    let mut l = again.client();
    again.create("A", &[("produce", "1")]);
    let request = connection("A", "B", &incarnation, Some(&right.socket()));
    ok(&mut l, RequestBody::Connect(request));
    ok(&mut l, activate("A"));
    until("samples flow again", || bound(&mut r).samples_received >= 3);
    let (seen, sent) = (bound(&mut r), connector(&mut l));
    assert_eq!(seen.gaps, 0);
    assert!(seen.samples_received <= sent.samples_sent);
}

#[test]
fn unbinding_ends_the_connection_and_disconnecting_is_idempotent() {
    let (left, mut l, _right, mut r) = pair();
    let mut events = Listener::connect(&left);
    let unbind = || RequestBody::Unbind {
        connector: C.to_owned(),
    };
    ok(&mut r, unbind());
    ok(&mut r, unbind());
    events.event("connector/A.out-B.in");
    assert_eq!(connector(&mut l).state, "Disconnected");
    assert_eq!(component(&mut l, "A").state, "Active");
    for _ in 0..2 {
        ok(
            &mut l,
            RequestBody::Disconnect {
                instance: "A".to_owned(),
                connector: C.to_owned(),
                by_hand: None,
            },
        );
    }
}

/// Greets as the source of the connector and returns the answer.
fn greet(
    target: &Running,
    incarnation: &str,
    change: impl FnOnce(&mut DataHello),
) -> (UnixStream, DataReply) {
    let mut hello = DataHello {
        version: PROTOCOL_VERSION,
        connector: C.to_owned(),
        source: "A.out".to_owned(),
        instance: "B".to_owned(),
        port: "in".to_owned(),
        incarnation: incarnation.to_owned(),
        data_type: "IDL:RTC/TimedDouble:1.0".to_owned(),
        encoding: "cdr-le".to_owned(),
        good_bye: true,
        properties: BTreeMap::new(),
        stamped: false,
    };
    change(&mut hello);
    let mut stream = target.connect();
    let greeted = frame::write(&mut stream, &Greeting::Data(hello));
    greeted.expect("the greeting is taken");
    let reply = frame::read(&mut stream).expect("it answers");
    (stream, reply)
}

#[test]
fn a_source_that_sends_nonsense_is_dropped_alone() {
    use std::io::{Read, Write};
    let manager = start("m");
    let mut client = manager.client();
    let incarnation = manager.create("B", &[]);
    ok(&mut client, binding(C, "B", "in", "A.out"));
    ok(&mut client, activate("B"));

    let (_, reply) = greet(&manager, &incarnation, |hello| hello.version = u32::MAX);
    assert!(
        reply
            .result
            .unwrap_err()
            .message
            .contains("the manager of B.in: the other side speaks version 4294967295")
    );
    let (_, reply) = greet(&manager, &incarnation, |hello| {
        hello.encoding = "xml".to_owned();
    });
    assert!(reply.result.unwrap_err().message.contains("xml"));

    let (mut stream, reply) = greet(&manager, &incarnation, |_| ());
    reply.result.unwrap();
    assert!(bound(&mut client).connected);
    stream.write_all(&u32::MAX.to_be_bytes()).unwrap();
    stream.write_all(&[0; 8]).unwrap();
    assert_eq!(stream.read(&mut [0; 8]).unwrap(), 0);
    until("it shows", || !bound(&mut client).connected);

    // The newest connection wins, and samples that a sender lost are a gap.
    let (mut first, reply) = greet(&manager, &incarnation, |_| ());
    reply.result.unwrap();
    let (mut second, reply) = greet(&manager, &incarnation, |_| ());
    reply.result.unwrap();
    let mut good_bye = Vec::new();
    first.read_to_end(&mut good_bye).unwrap();
    assert_eq!(good_bye.len(), 1);
    for sequence in [1_u64, 2, 5, 6] {
        second.write_all(&16_u32.to_be_bytes()).unwrap();
        second.write_all(&sequence.to_be_bytes()).unwrap();
        second.write_all(&sequence.to_ne_bytes()).unwrap();
    }
    until("all is read", || bound(&mut client).samples_received == 4);
    assert_eq!(bound(&mut client).gaps, 1);
    assert_eq!(component(&mut client, "B").state, "Active");
}

#[test]
fn a_source_in_this_process_is_told_when_another_takes_its_place() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[]);
    let incarnation = manager.create("B", &[]);
    let request = connection("A", "B", &incarnation, None);
    ok(&mut client, RequestBody::Connect(request));
    assert_eq!(connector(&mut client).state, "Connected");
    let mut events = Listener::connect(&manager);
    let (_stream, reply) = greet(&manager, &incarnation, |_| ());
    reply.result.unwrap();
    assert_eq!(
        events.event("connector/A.out-B.in"),
        "another source took its place"
    );
    assert_eq!(connector(&mut client).state, "Disconnected");
    assert!(bound(&mut client).connected);
}

#[test]
fn connections_that_ended_hold_no_file_descriptors() {
    let manager = start("m");
    let mut client = manager.client();
    let incarnation = manager.create("B", &[]);
    ok(&mut client, binding(C, "B", "in", "A.out"));
    let descriptors = || {
        let folder = format!("/proc/{}/fd", manager.child.id());
        std::fs::read_dir(folder).unwrap().count()
    };
    let before = descriptors();
    for number in 0..20 {
        let name = format!("c{number}");
        ok(&mut client, binding(&name, "B", "in", "A.out"));
        let (_, reply) = greet(&manager, &incarnation, |hello| hello.connector = name);
        reply.result.unwrap();
    }
    // Fewer, when the probe of the start was still open before.
    until("all are closed", || descriptors() <= before);
}

#[test]
fn it_may_open_as_many_files_as_the_system_lets_it() {
    let manager = start("m");
    let limits = format!("/proc/{}/limits", manager.child.id());
    let limits = std::fs::read_to_string(limits).unwrap();
    let line = limits.lines().find(|l| l.starts_with("Max open files"));
    let words: Vec<_> = line.unwrap().split_whitespace().collect();
    assert_eq!(words[3], words[4], "{words:?}");
}

/// A request for a stand-in with an in-port and an out-port of a type.
fn stand_in(manager: &Running, instance: &str, data_type: &str) -> CreateRequest {
    let port = |name: &str, data_type: &str| PortInfo {
        name: name.to_owned(),
        direction: name.to_owned(),
        data_type: data_type.to_owned(),
    };
    let RequestBody::Create(mut request) = manager.testmod(instance, &[("gain", "2")]) else {
        panic!("no Create");
    };
    request.type_name = "Camera".to_owned();
    request.rate = Some(200.0);
    request.stand_in = Some(StandInShape {
        ports: vec![
            port("in", data_type),
            port("out", data_type),
            port("service", ""),
        ],
        parameters: [("gain".to_owned(), String::new())].into(),
        ..StandInShape::default()
    });
    request
}

/// Creates it; its incarnation.
fn make(client: &mut Client, request: CreateRequest) -> String {
    match ok(client, RequestBody::Create(request)) {
        ResponseBody::Created { incarnation } => incarnation,
        other => panic!("{other:?}"),
    }
}

#[test]
fn stand_ins_of_any_type_send_to_each_other_and_count() {
    for data_type in ["IDL:Img/TimedCameraImage:1.0", "IDL:RTC/TimedShort:1.0"] {
        let (left, right) = (start("left"), start("right"));
        let (mut l, mut r) = (left.client(), right.client());
        make(&mut l, stand_in(&left, "A", data_type));
        let incarnation = make(&mut r, stand_in(&right, "B", data_type));
        ok(&mut r, binding(C, "B", "in", "A.out"));
        let request = connection("A", "B", &incarnation, Some(&right.socket()));
        ok(&mut l, RequestBody::Connect(request));
        ok(&mut r, activate("B"));
        ok(&mut l, activate("A"));
        until("samples flow", || bound(&mut r).samples_received >= 20);
        ok(&mut l, deactivate("A"));
        until("all is read", || {
            bound(&mut r).samples_received == connector(&mut l).samples_sent
        });
        ok(&mut r, deactivate("B"));
        let received = bound(&mut r).samples_received;
        let log = right.log("B");
        let line = format!("port in: {received} samples, 0 gaps, 0 out of order, 0 faulty");
        assert!(log.contains(&line), "{log}");
        let info = component(&mut r, "B");
        assert!(info.stand_in && info.sets["default"]["gain"] == "2");
        let ports: Vec<_> = info.ports.iter().map(|port| port.name.as_str()).collect();
        assert_eq!(ports, ["in", "out", "service"]);
        assert!(inventory(&mut r).modules.is_empty());
    }
}

#[test]
fn a_stand_in_fails_and_crashes_when_it_is_told_to() {
    let mut manager = start("m");
    let mut client = manager.client();
    let told = |instance: &str, tell: &dyn Fn(&mut StandInShape)| {
        let mut request = stand_in(&manager, instance, "IDL:RTC/TimedLong:1.0");
        request.stand_in.as_mut().map(tell);
        request
    };
    let initialize = told("I", &|shape| shape.fail = Some("initialize".to_owned()));
    let activated = told("A", &|shape| shape.fail = Some("activate".to_owned()));
    let execute = told("E", &|shape| shape.fail = Some("execute".to_owned()));
    let slow = told("S", &|shape| shape.startup_ms = Some(600_000));
    let crash = told("C", &|shape| shape.crash_after_ms = Some(100));
    let failure = refused(&mut client, RequestBody::Create(initialize), SOON);
    assert_eq!(
        (failure.code, failure.message.as_str()),
        (
            FailureCode::ComponentFailed,
            "I: on_initialize: fails as its stand-in was told to"
        )
    );
    make(&mut client, activated);
    refused(&mut client, activate("A"), SOON);
    assert_eq!(component(&mut client, "A").state, "Error");
    make(&mut client, execute);
    ok(&mut client, activate("E"));
    until("it is in Error", || {
        component(&mut client, "E").state == "Error"
    });
    let failure = refused(
        &mut client,
        RequestBody::Create(slow),
        std::time::Duration::from_millis(50),
    );
    assert_eq!(failure.code, FailureCode::Deadline);
    make(&mut client, crash);
    ok(&mut client, activate("C"));
    assert!(!manager.wait().success());
    assert!(
        manager
            .log("C")
            .contains("crashes 100 ms after its activation")
    );
}

fn with(request: &ConnectRequest, properties: &[(&str, &str)]) -> RequestBody {
    let own = |(name, value): &(&str, &str)| (format!("dataport.{name}"), (*value).to_owned());
    RequestBody::Connect(ConnectRequest {
        properties: properties.iter().map(own).collect(),
        ..request.clone()
    })
}

#[test]
fn connectors_go_by_their_properties_inside_a_process_and_between_two() {
    let (left, right) = (start("left"), start("right"));
    let (mut l, mut r) = (left.client(), right.client());
    left.create("A", &[("produce", "1")]);
    // Of A's connector to it, whether it is in A's manager or in the other.
    let (near, far) = (left.create("B", &[]), right.create("B", &[]));
    ok(&mut r, binding(C, "B", "in", "A.out"));
    ok(&mut l, activate("B"));
    ok(&mut r, activate("B"));
    let requests = [
        connection("A", "B", &near, None),
        connection("A", "B", &far, Some(&right.socket())),
    ];
    let rate = ("publisher.push_rate", "500");
    let all = ("publisher.push_policy", "all");
    for request in &requests {
        let other = if request.target_socket.is_some() {
            &mut r
        } else {
            &mut left.client()
        };
        for properties in [
            &[("subscription_type", "flush")][..],
            &[("subscription_type", "new"), all],
            &[("subscription_type", "periodic"), rate, all],
            &[("dataflow_type", "pull")],
        ] {
            ok(&mut l, with(request, properties));
            ok(&mut l, activate("A"));
            until("samples flow", || bound(other).samples_received >= 20);
            ok(&mut l, deactivate("A"));
            until("all is read", || {
                bound(other).samples_received == connector(&mut l).samples_sent
            });
            let (sent, received) = (connector(&mut l), bound(other));
            let what = format!("{properties:?}: {sent:?} {received:?}");
            assert_eq!(
                (sent.drops, received.drops, received.gaps),
                (0, 0, 0),
                "{what}"
            );
            assert_eq!(
                received.latency.unwrap().count,
                received.samples_received,
                "{what}"
            );
        }
        // What is wrong is refused by its name, and the connector stays as it is.
        let wrong = with(request, &[("inport.buffer.length", "0")]);
        let refusal = refused(&mut l, wrong, SOON).message;
        let said = "`dataport.inport.buffer.length`: `0` is no length of a buffer; write a whole number from 1 to 65536";
        assert_eq!(refusal, said);
        let still = connector(&mut l);
        assert_eq!(still.state, "Connected");
        assert_eq!(still.properties["dataport.dataflow_type"], "pull");
    }
    let across = with(&requests[1], &[("interface_type", "direct")]);
    let refusal = refused(&mut l, across, SOON).message;
    assert!(
        refusal.contains("needs both components in one process"),
        "{refusal}"
    );
    assert_eq!(component(&mut l, "A").state, "Inactive");
}
