//! Samples between two processes, over every transport.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::os::unix::net::UnixListener;

use rts_manager_api::control::*;
use rts_manager_api::data::DataReply;
use rts_manager_api::frame;

use rts_runtime::types::{DataType, Endian, TimedShort};
use rts_transport::Kind;

use crate::stand_ins::{make, stand_in};
use crate::support::*;
use crate::{BETWEEN, C, bound, connector, pair, with};

#[test]
fn between_processes_samples_arrive_in_order_and_are_counted() {
    for transport in BETWEEN {
        let (_left, mut l, _right, mut r) = pair(transport);
        until("samples flow", || bound(&mut r).samples_received >= 50);
        ok(&mut l, deactivate("A"));
        until("all is read", || {
            bound(&mut r).samples_received == connector(&mut l).samples_sent
        });
        let (sent, received) = (connector(&mut l), bound(&mut r));
        assert_eq!(
            (sent.state.as_str(), sent.transport.as_str()),
            ("Connected", transport)
        );
        assert_eq!((sent.drops, received.drops, received.gaps), (0, 0, 0));
        assert_eq!(component(&mut r, "B").state, "Active");
    }
}

#[test]
fn the_death_of_the_target_is_noticed_and_a_new_one_connected() {
    BETWEEN.iter().for_each(|transport| target_dies(transport));
}

fn target_dies(transport: &str) {
    let (left, mut l, right, mut r) = pair(transport);
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
    ok(&mut l, with(&request, &[("interface_type", transport)]));
    ok(&mut r, activate("B"));
    ok(&mut l, activate("A"));
    until("samples flow again", || bound(&mut r).samples_received >= 3);
    assert_eq!(bound(&mut r).gaps, 0);
    assert_eq!(component(&mut l, "A").connectors.len(), 1);
}

#[test]
fn the_death_of_the_source_is_noticed_and_a_new_one_starts_without_a_gap() {
    BETWEEN.iter().for_each(|transport| source_dies(transport));
}

fn source_dies(transport: &str) {
    let (left, _, right, mut r) = pair(transport);
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
    ok(&mut l, with(&request, &[("interface_type", transport)]));
    ok(&mut l, activate("A"));
    until("samples flow again", || bound(&mut r).samples_received >= 3);
    let (seen, sent) = (bound(&mut r), connector(&mut l));
    assert_eq!(seen.gaps, 0);
    assert!(seen.samples_received <= sent.samples_sent);
}

#[test]
fn connectors_go_by_their_properties_over_every_transport() {
    let (left, right) = (start("left"), start("right"));
    let (mut l, mut r) = (left.client(), right.client());
    left.create("A", &[("produce", "1")]);
    // Of A's connector to it, whether it is in A's manager or in the other.
    let (near, far) = (left.create("B", &[]), right.create("B", &[]));
    ok(&mut r, binding(C, "B", "in", "A.out"));
    ok(&mut l, activate("B"));
    ok(&mut r, activate("B"));
    let near = connection("A", "B", &near, None);
    let far = connection("A", "B", &far, Some(&right.socket()));
    let beyond = ConnectRequest {
        between_nodes: true,
        ..far.clone()
    };
    let cases = [
        (&near, "corba_cdr", "direct"),
        (&near, "shm", "shm"),
        (&near, "tcp", "tcp"),
        (&far, "corba_cdr", "shm"),
        (&far, "uds", "uds"),
        (&beyond, "data_service", "tcp"),
    ];
    let rate = ("publisher.push_rate", "500");
    let all = ("publisher.push_policy", "all");
    for (request, word, transport) in cases {
        let interface = ("interface_type", word);
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
            ok(&mut l, with(request, &[properties, &[interface]].concat()));
            ok(&mut l, activate("A"));
            until("samples flow", || bound(other).samples_received >= 20);
            ok(&mut l, deactivate("A"));
            until("all is read", || {
                bound(other).samples_received == connector(&mut l).samples_sent
            });
            let (sent, received) = (connector(&mut l), bound(other));
            let what = format!("{word} {properties:?}: {sent:?} {received:?}");
            assert_eq!(sent.transport, transport, "{what}");
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
    assert_eq!(component(&mut l, "A").state, "Inactive");
}

#[test]
fn samples_travel_with_either_byte_first() {
    let (left, right) = (start("left"), start("right"));
    let (mut l, mut r) = (left.client(), right.client());
    make(&mut l, stand_in(&left, "A", "IDL:RTC/TimedShort:1.0"));
    let incarnation = make(&mut r, stand_in(&right, "B", "IDL:RTC/TimedShort:1.0"));
    ok(&mut r, binding(C, "B", "in", "A.out"));
    let request = connection("A", "B", &incarnation, Some(&right.socket()));
    for (interface, endian) in [("shm", "big"), ("tcp", "big,little"), ("uds", "little,big")] {
        let properties = [
            ("interface_type", interface),
            ("serializer.cdr.endian", endian),
        ];
        ok(&mut l, with(&request, &properties));
        ok(&mut r, activate("B"));
        ok(&mut l, activate("A"));
        until("samples flow", || bound(&mut r).samples_received >= 10);
        ok(&mut l, deactivate("A"));
        until("all is read", || {
            bound(&mut r).samples_received == connector(&mut l).samples_sent
        });
        ok(&mut r, deactivate("B"));
        let (sent, received) = (connector(&mut l), bound(&mut r));
        assert_eq!((sent.drops, received.drops, received.gaps), (0, 0, 0));
    }
    let log = right.log("B");
    assert!(!log.contains("samples, 0 gaps, 0 out of order, 1"), "{log}");
    assert_eq!(
        log.matches(" 0 gaps, 0 out of order, 0 faulty").count(),
        3,
        "{log}"
    );

    // On the way it is as it was said: a peer that takes them as they come.
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let socket = home.path().join("control.sock");
    let listener = UnixListener::bind(&socket).unwrap();
    let peer = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let Greeting::Data(hello) = frame::read(&mut stream).unwrap() else {
            panic!("it is no control connection");
        };
        let reply = DataReply {
            transport: hello.transport.clone(),
            ..DataReply::default()
        };
        frame::write_answer(&mut stream, &reply).unwrap();
        frame::write_answer(&mut stream, &reply).unwrap();
        let mut receiver = Kind::Unix.receiver(stream.into()).unwrap();
        let sample = receiver.take(SOON).unwrap().expect("a sample");
        (hello.encoding, sample.payload)
    });
    let request = connection("A", "B", "i", Some(&socket));
    let properties = [("interface_type", "uds"), ("serializer.cdr.endian", "big")];
    ok(&mut l, with(&request, &properties));
    ok(&mut l, activate("A"));
    let (encoding, payload) = peer.join().unwrap();
    assert_eq!(encoding, "cdr-be");
    let sample = TimedShort::decode_as(Endian::Big, &payload).unwrap();
    let before = TimedShort::decode_as(Endian::Little, &payload).unwrap();
    assert!(
        sample.tm.sec < 1 << 31 && before.tm.nsec != sample.tm.nsec,
        "{sample:?}"
    );

    let unknown = stand_in(&left, "Z", "IDL:Img/TimedCameraImage:1.0");
    make(&mut l, unknown);
    let request = connection("Z", "B", &incarnation, Some(&right.socket()));
    let refusal = refused(&mut l, with(&request, &properties), SOON).message;
    assert!(
        refusal.contains("needs the IDL of IDL:Img/TimedCameraImage:1.0"),
        "{refusal}"
    );
}

#[test]
fn what_has_no_shared_memory_goes_over_a_unix_socket_unless_it_is_asked_for() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[]);
    let home = tempfile::tempdir_in("/tmp").unwrap();
    let socket = home.path().join("control.sock");
    let listener = UnixListener::bind(&socket).unwrap();
    // It agrees to everything, and then has no shared memory.
    let peer = std::thread::spawn(move || {
        let greeted = || {
            let (mut stream, _) = listener.accept().unwrap();
            let Greeting::Data(hello) = frame::read(&mut stream).unwrap() else {
                panic!("it is no control connection");
            };
            let mut reply = DataReply {
                transport: hello.transport.clone(),
                ..DataReply::default()
            };
            frame::write_answer(&mut stream, &reply).unwrap();
            if hello.transport.as_deref() == Some("shm") {
                reply.result = Err(Failure {
                    code: FailureCode::Internal,
                    message: "no memory".to_owned(),
                });
            }
            frame::write_answer(&mut stream, &reply).unwrap();
            (stream, hello.transport.unwrap())
        };
        (0..3).map(|_| greeted()).collect::<Vec<_>>()
    });
    let request = connection("A", "B", "i", Some(&socket));
    let asked = with(&request, &[("interface_type", "shared_memory")]);
    assert_eq!(refused(&mut client, asked, SOON).message, "no memory");
    ok(&mut client, RequestBody::Connect(request));
    assert_eq!(connector(&mut client).transport, "uds");
    let greeted = peer.join().unwrap();
    let kinds: Vec<_> = greeted.iter().map(|(_, kind)| kind.as_str()).collect();
    assert_eq!(kinds, ["shm", "shm", "uds"]);
}
