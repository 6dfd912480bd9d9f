//! Taps: looking at ports and writing to them, and what is left of that: nothing.

#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;

use rts_manager_api::OLDEST_PROTOCOL_VERSION;
use rts_manager_api::control::*;
use rts_manager_api::frame;
use rts_manager_api::tap::{END, TapEnd, TapHello, TapOpened, TapReply, TapSample, TapWay};

use crate::support::*;

const NUMBER: &str = "IDL:RTC/TimedDouble:1.0";

/// Opens a tap.
fn tap(manager: &Running, port: &str, way: TapWay) -> (UnixStream, Result<TapOpened, Failure>) {
    let (instance, port) = port.split_once('.').unwrap();
    let hello = TapHello {
        version: OLDEST_PROTOCOL_VERSION,
        instance: instance.to_owned(),
        port: port.to_owned(),
        way,
    };
    let mut stream = manager.connect();
    frame::write(&mut stream, &Greeting::Tap(hello)).unwrap();
    let reply: TapReply = frame::read_answer(&mut stream).unwrap();
    (stream, reply.result)
}

fn inject(data_type: &str, wait_ms: u64, linger_ms: u64) -> TapWay {
    TapWay::Inject {
        data_type: data_type.to_owned(),
        wait_ms,
        linger_ms,
    }
}

/// The next sample, and the number in it; none at the end.
fn next(stream: &mut UnixStream) -> Option<(TapSample, u64)> {
    let mut length = [0; 4];
    stream.read_exact(&mut length).unwrap();
    let mut bytes = vec![0; TapSample::announced(length).unwrap()?];
    stream.read_exact(&mut bytes).unwrap();
    let (sample, payload) = TapSample::split(&bytes).unwrap();
    let number = payload.try_into().unwrap();
    Some((sample, u64::from_le_bytes(number)))
}

/// Writes numbers as samples.
fn send(stream: &mut UnixStream, numbers: std::ops::RangeInclusive<u64>) {
    for number in numbers {
        let payload = number.to_le_bytes();
        let head = TapSample {
            length: payload.len(),
            time: 0,
            missed: 0,
        };
        stream.write_all(&head.head()).unwrap();
        stream.write_all(&payload).unwrap();
    }
}

fn end(stream: &mut UnixStream) -> TapEnd {
    frame::read_answer(stream).unwrap()
}

fn taps(manager: &Running) -> Vec<String> {
    let taps = inventory(&mut manager.client()).taps.into_iter();
    taps.map(|tap| format!("{} {}", tap.port, tap.way))
        .collect()
}

#[test]
fn a_reader_that_reads_nothing_holds_up_nobody_and_is_told_what_it_missed() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[("produce", "5")]);
    let (mut stream, opened) = tap(&manager, "A.out", TapWay::Print);
    assert_eq!(opened.unwrap().data_type, NUMBER);
    assert_eq!(taps(&manager), ["A.out print"]);
    ok(&mut client, activate("A"));
    // Far more than the socket and the queue hold.
    until("it goes on", || {
        component(&mut client, "A").executions >= 1000
    });
    ok(&mut client, deactivate("A"));
    assert!(component(&mut client, "A").connectors.is_empty());
    let (mut last, mut missed) = (0, 0);
    let mut seen = 0;
    // Those that were newest when it stopped have come to it, however late.
    while seen + missed < component(&mut client, "A").executions * 5 {
        let (sample, number) = next(&mut stream).unwrap();
        assert!(number > last && sample.missed >= missed);
        assert!(sample.time > 1_000_000_000_000_000_000);
        (last, missed, seen) = (number, sample.missed, seen + 1);
    }
    assert!(missed > 0, "{seen} were seen");
    drop(stream);
    until("nothing is left", || taps(&manager).is_empty());
}

#[test]
fn a_tap_ends_with_its_component_and_does_not_hold_it() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("A", &[("produce", "1")]);
    let (mut print, _) = tap(&manager, "A.out", TapWay::Print);
    let (mut write, opened) = tap(&manager, "A.in", inject(NUMBER, 0, 0));
    assert_eq!(opened.unwrap().data_type, NUMBER);
    assert_eq!(taps(&manager), ["A.out print", "A.in inject"]);
    let delete = RequestBody::Delete {
        instance: "A".to_owned(),
    };
    ok(&mut client, delete);
    assert!(inventory(&mut client).components.is_empty());
    assert_eq!(next(&mut print), None);
    for stream in [&mut print, &mut write] {
        let why = end(stream).failure.unwrap();
        assert_eq!(why.code, FailureCode::NotFound);
        assert!(why.message.contains("was deleted"), "{}", why.message);
    }
    until("nothing is left", || taps(&manager).is_empty());
}

#[test]
fn what_is_written_is_read_or_told_as_lost() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("B", &[]);
    // Nobody reads yet: the oldest go, or the newest find no room.
    for (wait, lost) in [(0, 6), (1, 6)] {
        let (mut stream, _) = tap(&manager, "B.in", inject(NUMBER, wait, 0));
        send(&mut stream, 1..=70);
        stream.write_all(&END).unwrap();
        let end = end(&mut stream);
        assert_eq!((end.taken, end.read, end.dropped), (70, 0, lost));
        assert_eq!(end.failure, None);
    }
    ok(&mut client, activate("B"));
    let (mut stream, _) = tap(&manager, "B.in", inject(NUMBER, 10_000, 10_000));
    send(&mut stream, 1..=200);
    stream.write_all(&END).unwrap();
    let told = end(&mut stream);
    assert_eq!((told.taken, told.read, told.dropped), (200, 200, 0));
    assert!(component(&mut client, "B").bindings.is_empty());
    assert_eq!(component(&mut client, "B").state, "Active");
    until("nothing is left", || taps(&manager).is_empty());
}

#[test]
fn who_makes_no_sense_or_goes_is_let_go_alone() {
    let manager = start("m");
    let mut client = manager.client();
    manager.create("B", &[]);
    ok(&mut client, activate("B"));
    let why = |port, way| tap(&manager, port, way).1.unwrap_err().message;
    let other = why("B.in", inject("IDL:RTC/TimedLong:1.0", 0, 0));
    assert_eq!(
        other,
        "B.in takes IDL:RTC/TimedDouble:1.0, not IDL:RTC/TimedLong:1.0"
    );
    assert!(why("B.in", TapWay::Print).contains("B has no out-port `in`; its out-ports are: out"));
    assert!(why("C.out", TapWay::Print).contains("no component `C`"));

    let (mut nonsense, _) = tap(&manager, "B.in", inject(NUMBER, 0, 0));
    nonsense.write_all(&3u32.to_be_bytes()).unwrap();
    let told = end(&mut nonsense).failure.unwrap();
    assert_eq!(told.code, FailureCode::Invalid);
    // In the middle of a sample.
    let (mut cut, _) = tap(&manager, "B.in", inject(NUMBER, 0, 0));
    cut.write_all(&[0, 0, 0, 32, 1]).unwrap();
    drop(cut);
    until("nothing is left", || taps(&manager).is_empty());
    assert_eq!(component(&mut client, "B").state, "Active");
}

#[test]
fn there_is_a_bound_on_taps() {
    let manager = start("m");
    manager.create("A", &[]);
    let mut open = Vec::new();
    let refused = loop {
        match tap(&manager, "A.out", TapWay::Print) {
            (stream, Ok(_)) => open.push(stream),
            (_, Err(failure)) => break failure,
        }
        assert!(open.len() < 1000);
    };
    assert_eq!((open.len(), refused.code), (64, FailureCode::Conflict));
    drop(open);
    until("nothing is left", || taps(&manager).is_empty());
}
