//! Connections that are refused, and sources that send what they should not.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::collections::BTreeMap;
use std::os::unix::net::UnixStream;

use rts_manager_api::PROTOCOL_VERSION;
use rts_manager_api::control::*;
use rts_manager_api::data::{DataHello, DataReply};
use rts_manager_api::frame;
use rts_transport::{Ended, Kind, Sender};

use crate::support::*;
use crate::{C, bound, connector};

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

    let interface = |word: &str, between_nodes: bool| {
        let properties = [("dataport.interface_type".to_owned(), word.to_owned())];
        ConnectRequest {
            properties: properties.into(),
            between_nodes,
            ..good.clone()
        }
    };
    for (word, between_nodes, why) in [
        (
            "direct",
            false,
            "needs both components in one process: place both in one manager",
        ),
        (
            "direct",
            true,
            "needs both components in one process: place both in one manager",
        ),
        (
            "shm",
            true,
            "needs both components on one node: place both on one node",
        ),
        (
            "uds",
            true,
            "needs both components on one node: place both on one node",
        ),
    ] {
        let (code, message) = refuse(&interface(word, between_nodes));
        assert_eq!(code, FailureCode::Invalid);
        let said = format!(
            "the connector A.out-B.in: `dataport.interface_type` is {word}, which {why}, or choose "
        );
        assert!(message.starts_with(&said), "{message}");
    }

    let incarnation = left.create("B", &[]);
    wrong.target_socket = None;
    wrong.target_incarnation = incarnation;
    let (code, message) = refuse(&wrong);
    assert_eq!((code, message.as_str()), (FailureCode::Invalid, types));
    assert!(component(&mut l, "B").bindings.is_empty());
}

/// Greets as the source of the connector, one of version 1 unless that is changed, and returns the answer.
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
        properties: BTreeMap::new(),
        transport: None,
        clock: None,
    };
    change(&mut hello);
    let mut stream = target.connect();
    let greeted = frame::write(&mut stream, &Greeting::Data(Box::new(hello)));
    greeted.expect("the greeting is taken");
    let reply = frame::read(&mut stream).expect("it answers");
    (stream, reply)
}

/// The sending end over a Unix socket, with its own frames.
fn agreed(target: &Running, incarnation: &str) -> Box<dyn Sender> {
    let (mut stream, reply) = greet(target, incarnation, |hello| {
        hello.transport = Some("uds".to_owned());
    });
    reply.result.unwrap();
    assert_eq!(reply.transport.as_deref(), Some("uds"));
    let ready: DataReply = frame::read_answer(&mut stream).unwrap();
    ready.result.unwrap();
    Kind::Unix.sender(stream.into()).unwrap()
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
    for (name, known) in [
        ("pigeon", "there is no transport"),
        ("inproc", "has no socket"),
    ] {
        let (mut stream, first) = greet(&manager, &incarnation, |hello| {
            hello.transport = Some(name.to_owned());
        });
        // The second one of those that have agreed.
        let refusal = first.result.and_then(|()| {
            let reply: DataReply = frame::read_answer(&mut stream).unwrap();
            reply.result
        });
        let message = refusal.unwrap_err().message;
        assert!(message.contains(known), "{message}");
    }

    let (mut stream, reply) = greet(&manager, &incarnation, |_| ());
    reply.result.unwrap();
    assert!(bound(&mut client).connected);
    stream.write_all(&u32::MAX.to_be_bytes()).unwrap();
    stream.write_all(&[0; 8]).unwrap();
    assert_eq!(stream.read(&mut [0; 8]).unwrap(), 0);
    until("it shows", || !bound(&mut client).connected);

    // The newest connection wins, and samples that a sender lost are a gap.
    let mut first = agreed(&manager, &incarnation);
    let (mut second, reply) = greet(&manager, &incarnation, |_| ());
    reply.result.unwrap();
    until("the first is told", || {
        first.ended() == Some(Ended::GoodBye)
    });
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
    let kinds = [
        None,
        Some(Kind::SharedMemory),
        Some(Kind::Unix),
        Some(Kind::Tcp),
        Some(Kind::SharedMemory),
    ];
    for number in 0..20 {
        let name = format!("c{number}");
        ok(&mut client, binding(&name, "B", "in", "A.out"));
        let (mut stream, reply) = greet(&manager, &incarnation, |hello| {
            hello.connector = name;
            hello.transport = kinds[number % kinds.len()].map(|kind| kind.to_string());
        });
        reply.result.unwrap();
        if let Some(kind) = kinds[number % kinds.len()] {
            // Also of those that say nothing more, or make no end of their own.
            let sender = (number % 2 == 0 && kind != Kind::Tcp)
                .then(|| kind.sender(stream.try_clone().unwrap().into()).unwrap());
            if sender.is_some() {
                let ready: DataReply = frame::read_answer(&mut stream).unwrap();
                ready.result.unwrap();
            }
        }
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
