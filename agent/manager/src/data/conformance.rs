//! What every connector does, inside a process and over every transport: its subscription types, push policies and buffer policies.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use rts_manager_api::control::{Binding, ConnectRequest};
use rts_transport::Kind;

use super::binding::End;
use super::connector::{Connector, Link};
use super::ends::{agreed, pair};
use super::in_port::InPort;
use super::out_port::OutPort;
use super::receive::receive;
use super::sample::{Read, Written};
use super::sender::Sender;
use super::source::Source;
use super::{Parting, Payload, direct, settings};
use crate::events::Events;
use crate::slots::Slots;

const ALL: [Kind; 4] = Kind::ALL;

/// A connector and its in-port end.
struct Made {
    connector: Arc<Connector>,
    source: Arc<Source>,
}

impl Made {
    /// Samples that found no room at either end.
    fn drops(&self) -> u64 {
        self.connector.info().drops + self.source.counts().drops
    }

    /// Samples that the connector took, and their bytes.
    fn sent(&self) -> (u64, u64) {
        let info = self.connector.info();
        (info.samples_sent, info.bytes)
    }
}

fn make(out: &OutPort, port: &Arc<InPort>, transport: Kind, properties: &[(&str, &str)]) -> Made {
    let own = |(name, value): &(&str, &str)| (format!("dataport.{name}"), (*value).to_owned());
    let properties: BTreeMap<_, _> = properties.iter().map(own).collect();
    let settings = settings(&properties).unwrap();
    let binding = Binding {
        connector: "c".to_owned(),
        instance: "B".to_owned(),
        port: "in".to_owned(),
        source: "A.out".to_owned(),
    };
    let (end, events) = (End::new(binding, "i", port), Events::default());
    let connector = Connector::new(
        ConnectRequest {
            connector: "c".to_owned(),
            instance: "A".to_owned(),
            port: "out".to_owned(),
            target_instance: "B".to_owned(),
            target_port: "in".to_owned(),
            target_socket: None,
            target_incarnation: "i".to_owned(),
            between_nodes: false,
            properties,
            by_hand: None,
        },
        None,
        false,
    );
    let (link, source) = match transport {
        Kind::InProcess => {
            let link = direct::link(&end, settings, &Slots::new(8), &events).unwrap();
            let Link::Direct { source, .. } = &link else {
                panic!("{link:?}");
            };
            let source = Arc::clone(source);
            (link, source)
        }
        kind => {
            let (sending, mut receiver) = pair(kind);
            let handle = Some(receiver.handle());
            let source = end.open(handle, settings.clone(), None, &events).unwrap();
            thread::spawn({
                let (port, source) = (Arc::clone(port), Arc::clone(&source));
                move || {
                    let ended = receive(&mut *receiver, &port, &source, &agreed());
                    port.close(&source, ended.parting());
                }
            });
            let sender = Arc::new(Sender::new(sending, &settings).unwrap());
            (Link::Between(sender), source)
        }
    };
    let sender = match &link {
        Link::Between(sender) => Some(Arc::clone(sender)),
        _ => None,
    };
    assert!(connector.establish(link));
    let connector = Arc::new(connector);
    if let Some(sender) = sender {
        let connector = Arc::clone(&connector);
        thread::spawn(move || connector.close(sender.send().parting()));
    }
    out.add(&connector, || Ok(())).unwrap();
    Made { connector, source }
}

/// One connector between two ports.
fn one(transport: Kind, properties: &[(&str, &str)]) -> (Arc<OutPort>, Arc<InPort>, Made) {
    let (out, port) = ports();
    let made = make(&out, &port, transport, properties);
    (out, port, made)
}

fn ports() -> (Arc<OutPort>, Arc<InPort>) {
    let (out, port) = (OutPort::new("out", "T"), InPort::new("in", "T"));
    (Arc::new(out), Arc::new(port))
}

fn write(out: &OutPort, number: u64) -> Written {
    out.write(&Payload::copy_from_slice(&number.to_be_bytes()))
}

fn write_all(out: &OutPort, numbers: std::ops::RangeInclusive<u64>) -> Vec<Written> {
    numbers.map(|number| write(out, number)).collect()
}

fn number(payload: &Payload) -> u64 {
    u64::from_be_bytes(payload[..8].try_into().unwrap())
}

/// What one callback reads in a loop.
fn callback(port: &InPort) -> Vec<u64> {
    port.begin();
    std::iter::from_fn(|| port.read().sample())
        .map(|payload| number(&payload))
        .collect()
}

fn until(what: &str, mut done: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !done() {
        assert!(begin.elapsed() < Duration::from_secs(10), "{what}");
        thread::sleep(Duration::from_millis(1));
    }
}

/// Callbacks until so many samples were read.
fn read(port: &InPort, count: usize) -> Vec<u64> {
    let mut read = Vec::new();
    until("samples are read", || {
        read.extend(callback(port));
        read.len() >= count
    });
    read
}

/// Callbacks until this sample was read.
fn read_to(port: &InPort, last: u64) -> Vec<u64> {
    let mut read = Vec::new();
    until("the last sample is read", || {
        read.extend(callback(port));
        read.last() == Some(&last)
    });
    read
}

/// Waits until so many samples were taken in or refused.
fn arrived(port: &InPort, refused: impl Fn() -> u64, count: u64) {
    until("samples arrive", || port.arrivals() + refused() >= count);
}

fn joins(thread: JoinHandle<Written>) -> Written {
    until("the thread is let go", || thread.is_finished());
    thread.join().unwrap()
}

fn background(
    out: &Arc<OutPort>,
    write: impl FnOnce(&OutPort) -> Written + Send + 'static,
) -> JoinHandle<Written> {
    let out = Arc::clone(out);
    thread::spawn(move || write(&out))
}

#[test]
fn without_a_word_samples_come_in_order_and_the_oldest_of_64_goes() {
    for transport in ALL {
        let (out, port, made) = one(transport, &[]);
        // No more at once than find room at the out-port, should its thread be late.
        for half in [1..=35, 36..=70] {
            let last = *half.end();
            assert!(write_all(&out, half).iter().all(|w| *w == Written::Taken));
            arrived(&port, || 0, last);
        }
        assert_eq!(
            callback(&port),
            (7..=70).collect::<Vec<_>>(),
            "{transport:?}"
        );
        let counts = made.source.counts();
        assert_eq!((counts.received, counts.drops, counts.gaps), (64, 6, 1));
        let latency = counts.latency.unwrap();
        assert_eq!(latency.count, 64);
        assert!(latency.min_ns > 0 && latency.p99_ns <= latency.max_ns);
        let info = made.connector.info();
        assert_eq!((info.samples_sent, info.bytes, info.drops), (70, 560, 0));
    }
}

#[test]
fn a_full_in_port_overwrites_or_refuses() {
    for transport in ALL {
        let length = ("inport.buffer.length", "3");
        for (policy, expected) in [("overwrite", [8, 9, 10]), ("do_nothing", [1, 2, 3])] {
            let policy = ("inport.buffer.write.full_policy", policy);
            let (out, port, made) = one(transport, &[length, policy]);
            let written = write_all(&out, 1..=10);
            until("all have arrived", || made.drops() == 7);
            assert_eq!(callback(&port), expected, "{transport:?} {policy:?}");
            // The writer hears of it when the buffer is in its own process.
            let refused = policy.1 == "do_nothing" && transport == Kind::InProcess;
            let count = written
                .iter()
                .filter(|w| **w == Written::BufferFull)
                .count();
            assert_eq!(count, if refused { 7 } else { 0 });
            assert_eq!(made.sent(), if refused { (3, 24) } else { (10, 80) });
            write(&out, 11);
            assert_eq!(read(&port, 1), [11]);
            assert_eq!(made.source.counts().gaps, 1, "{transport:?} {policy:?}");
        }
    }
}

#[test]
fn with_block_at_both_ends_nothing_is_lost() {
    let blocking = [
        ("buffer.length", "2"),
        ("buffer.write.full_policy", "block"),
        ("buffer.write.timeout", "0"),
    ];
    for transport in ALL {
        for subscription in ["flush", "new"] {
            let how = [
                ("subscription_type", subscription),
                ("publisher.push_policy", "all"),
            ];
            let (out, port, made) = one(transport, &[&blocking[..], &how].concat());
            let writer = background(&out, |out| {
                write_all(out, 1..=200).into_iter().max().unwrap()
            });
            assert_eq!(read(&port, 200), (1..=200).collect::<Vec<_>>());
            assert_eq!(joins(writer), Written::Taken);
            let (info, counts) = (made.connector.info(), made.source.counts());
            assert_eq!((info.drops, counts.drops, counts.gaps), (0, 0, 0));
        }
    }
}

#[test]
fn a_wait_for_room_ends_at_its_time_out() {
    let blocking = [
        ("buffer.length", "1"),
        ("buffer.write.full_policy", "block"),
        ("buffer.write.timeout", "0.01"),
    ];
    for transport in ALL {
        let (out, port, made) = one(transport, &blocking);
        let written = write_all(&out, 1..=3);
        arrived(&port, || made.drops(), 3);
        assert_eq!(made.drops(), 2, "{transport:?}");
        assert_eq!(callback(&port), [1]);
        if transport == Kind::InProcess {
            let expected = [Written::Taken, Written::TimedOut, Written::TimedOut];
            assert_eq!(written, expected);
        }
    }
}

/// So many of them are more than a kernel keeps on the way.
const MANY: u64 = 40;

/// Samples too large for a transport to take many of.
fn large(number: u64) -> Payload {
    let mut payload = vec![0; 1 << 20];
    payload[..8].copy_from_slice(&number.to_be_bytes());
    payload.into()
}

#[test]
fn a_blocked_writer_is_let_go_by_the_end_and_holds_no_other_connector() {
    let blocking = [
        ("buffer.length", "1"),
        ("buffer.write.full_policy", "block"),
        ("buffer.write.timeout", "0"),
    ];
    for transport in ALL {
        let (out, stuck) = ports();
        let (_, free) = ports();
        let first = make(&out, &stuck, transport, &blocking);
        let second = make(&out, &free, transport, &[]);
        let writer = background(&out, |out| {
            let writes = (1..=MANY).map(|number| out.write(&large(number)));
            writes.max().unwrap()
        });
        until("the writer waits", || first.connector.holds_its_writer());
        until("the other connector has more than fits here", || {
            free.arrivals() > stuck.arrivals()
        });
        assert!(!writer.is_finished());
        // Its port can be changed meanwhile.
        let third = make(&out, &free, transport, &[]);
        assert_eq!(out.connectors().len(), 3);
        first.connector.close(Parting::GoodBye);
        assert_eq!(joins(writer), Written::Taken);
        read_to(&free, MANY);
        for made in [second, third] {
            made.connector.close(Parting::GoodBye);
            until("its end is seen", || !made.source.is_open());
        }
    }
}

#[test]
fn an_empty_in_port_gives_nothing_the_last_sample_or_waits() {
    let policy = "inport.buffer.read.empty_policy";
    for transport in ALL {
        let (out, port, _made) = one(transport, &[(policy, "do_nothing")]);
        write(&out, 1);
        assert_eq!(read(&port, 1), [1]);
        assert!(callback(&port).is_empty());

        let (out, port, made) = one(transport, &[(policy, "readback")]);
        assert!(callback(&port).is_empty(), "nothing was read yet");
        write(&out, 1);
        assert_eq!(read(&port, 1), [1]);
        // Once a callback, so that a loop ends; and it is no sample that was received.
        assert_eq!(callback(&port), [1]);
        assert_eq!(callback(&port), [1]);
        assert_eq!(made.source.counts().received, 1);
        write(&out, 2);
        assert_eq!(read_to(&port, 2).last(), Some(&2));

        let wait = ("inport.buffer.read.timeout", "0");
        let (out, port, _made) = one(transport, &[(policy, "block"), wait]);
        let reader = thread::spawn({
            let port = Arc::clone(&port);
            move || callback(&port)
        });
        until("the reader waits", || port.has_sleepers());
        write(&out, 1);
        until("the reader has it", || reader.is_finished());
        assert_eq!(reader.join().unwrap(), [1]);
    }
}

#[test]
fn a_wait_for_a_sample_ends_at_its_time_out_or_with_the_connector() {
    let policy = ("inport.buffer.read.empty_policy", "block");
    for transport in ALL {
        let short = ("inport.buffer.read.timeout", "0.01");
        let (_out, port, _made) = one(transport, &[policy, short]);
        port.begin();
        assert_eq!(port.read(), Read::TimedOut);
        assert_eq!(port.read(), Read::Empty, "only the first waits");

        let long = ("inport.buffer.read.timeout", "0");
        let (_out, port, made) = one(transport, &[policy, long]);
        let reader = thread::spawn({
            let port = Arc::clone(&port);
            move || callback(&port)
        });
        until("the reader waits", || port.has_sleepers());
        made.connector.close(Parting::GoodBye);
        until("the reader is let go", || reader.is_finished());
        assert!(reader.join().unwrap().is_empty());
    }
}

#[test]
fn push_policies_choose_what_is_sent() {
    for transport in ALL {
        for rate in [None, Some("1000")] {
            for (policy, expected) in [
                ("all", Some(vec![1, 2, 3, 4, 5, 6, 7, 8, 9])),
                ("fifo", Some(vec![1, 2, 3, 4, 5, 6, 7, 8, 9])),
                ("skip", Some(vec![3, 6, 9])),
                ("new", None),
            ] {
                let mut properties = vec![
                    (
                        "subscription_type",
                        if rate.is_some() { "periodic" } else { "new" },
                    ),
                    ("publisher.push_policy", policy),
                    ("publisher.skip_count", "2"),
                ];
                properties.extend(rate.map(|rate| ("publisher.push_rate", rate)));
                let (out, port, made) = one(transport, &properties);
                assert!(write_all(&out, 1..=9).iter().all(|w| *w == Written::Taken));
                let read = read_to(&port, 9);
                let what = format!("{transport:?} {properties:?}: {read:?}");
                assert!(read.is_sorted(), "{what}");
                assert!(expected.is_none_or(|expected| read == expected), "{what}");
                // What is passed over by choice is neither lost nor a gap.
                let (counts, info) = (made.source.counts(), made.connector.info());
                assert_eq!(
                    (info.samples_sent, info.drops, counts.drops),
                    (9, 0, 0),
                    "{what}"
                );
                assert_eq!(
                    (counts.received, counts.gaps),
                    (read.len() as u64, 0),
                    "{what}"
                );
            }
        }
    }
}

#[test]
fn a_full_out_port_overwrites_refuses_or_waits() {
    use Written::{BufferFull, Taken, TimedOut};
    for transport in ALL {
        for (policy, expected, sent) in [
            ("overwrite", [Taken, Taken, Taken], 3),
            ("do_nothing", [Taken, Taken, BufferFull], 2),
            ("block", [Taken, Taken, TimedOut], 2),
        ] {
            let properties = [
                ("subscription_type", "periodic"),
                // No tick comes in the time of this test.
                ("push_rate", "0.001"),
                ("outport.buffer.length", "2"),
                ("outport.buffer.write.full_policy", policy),
                ("outport.buffer.write.timeout", "0.01"),
            ];
            let (out, port, made) = one(transport, &properties);
            assert_eq!(write_all(&out, 1..=3), expected, "{transport:?} {policy}");
            assert_eq!((made.connector.info().drops, port.arrivals()), (1, 0));
            assert_eq!(made.sent(), (sent, 8 * sent));
        }
    }
}

#[test]
fn a_reader_that_pulls_fetches_what_waits_at_the_out_port() {
    let pull = ("dataflow_type", "pull");
    for transport in ALL {
        let (out, port, made) = one(transport, &[pull]);
        write_all(&out, 1..=5);
        assert_eq!(port.arrivals(), 0, "nothing comes by itself");
        port.begin();
        assert!(port.is_new());
        assert_eq!(callback(&port), [1, 2, 3, 4, 5], "{transport:?}");
        assert!(callback(&port).is_empty());
        port.begin();
        assert_eq!(port.is_new(), transport != Kind::InProcess, "may be");
        let counts = made.source.counts();
        assert_eq!((counts.received, counts.drops, counts.gaps), (5, 0, 0));

        let length = ("outport.buffer.length", "2");
        for (policy, expected) in [("overwrite", [4, 5]), ("do_nothing", [1, 2])] {
            let policy = ("outport.buffer.write.full_policy", policy);
            let (out, port, made) = one(transport, &[pull, length, policy]);
            write_all(&out, 1..=5);
            assert_eq!(callback(&port), expected, "{transport:?}");
            assert_eq!(made.connector.info().drops, 3);
        }

        let block = [
            ("outport.buffer.write.full_policy", "block"),
            ("outport.buffer.write.timeout", "0"),
        ];
        let (out, port, _made) = one(transport, &[&[pull, length], &block[..]].concat());
        let writer = background(&out, |out| {
            write_all(out, 1..=50).into_iter().max().unwrap()
        });
        assert_eq!(read(&port, 50), (1..=50).collect::<Vec<_>>());
        assert_eq!(joins(writer), Written::Taken);
    }
}

#[test]
fn an_empty_out_port_gives_a_puller_nothing_the_last_sample_or_lets_it_wait() {
    let pull = ("dataflow_type", "pull");
    let policy = "outport.buffer.read.empty_policy";
    for transport in ALL {
        let (out, port, _made) = one(transport, &[pull, (policy, "readback")]);
        assert!(callback(&port).is_empty());
        write(&out, 1);
        assert_eq!(callback(&port), [1]);
        assert_eq!(callback(&port), [1]);

        let long = ("buffer.read.timeout", "0");
        let (out, port, made) = one(transport, &[pull, long, (policy, "block")]);
        let reading = || {
            let port = Arc::clone(&port);
            thread::spawn(move || callback(&port))
        };
        let reader = reading();
        thread::sleep(Duration::from_millis(5));
        assert!(!reader.is_finished(), "{transport:?}");
        write(&out, 1);
        until("the reader has it", || reader.is_finished());
        assert_eq!(reader.join().unwrap(), [1]);
        let reader = reading();
        thread::sleep(Duration::from_millis(5));
        made.connector.close(Parting::GoodBye);
        until("the reader is let go", || reader.is_finished());
        assert!(reader.join().unwrap().is_empty());

        // A reader waits no longer than its own end says.
        let short = ("inport.buffer.read.timeout", "0.01");
        let long = ("outport.buffer.read.timeout", "0");
        let (out, port, _made) = one(transport, &[pull, short, long, (policy, "block")]);
        assert!(callback(&port).is_empty());
        write(&out, 1);
        assert_eq!(read(&port, 1), [1]);
    }
}

#[test]
fn a_loop_that_reads_all_ends_though_the_writer_is_faster() {
    for transport in ALL {
        let (out, port, _made) = one(
            transport,
            &[("dataflow_type", "pull"), ("outport.buffer.length", "4")],
        );
        write_all(&out, 1..=4);
        port.begin();
        let mut reads = 0;
        while let Some(_sample) = port.read().sample() {
            reads += 1;
            write(&out, 4 + reads);
            assert!(reads <= 4, "{transport:?}");
        }
        assert_eq!(reads, 4);
    }
}

#[test]
fn many_sources_come_to_one_port_each_with_its_own_policies() {
    for transport in ALL {
        let (left, port) = ports();
        let (right, _) = ports();
        let length = ("inport.buffer.length", "2");
        let policy = ("inport.buffer.write.full_policy", "do_nothing");
        let overwrites = make(&left, &port, transport, &[length]);
        let refuses = make(&right, &port, transport, &[length, policy]);
        write_all(&left, 1..=4);
        until("they arrive", || overwrites.source.counts().drops == 2);
        write_all(&right, 11..=14);
        until("they arrive", || refuses.drops() == 2);
        assert_eq!(callback(&port), [3, 4, 11, 12], "{transport:?}");
        overwrites.connector.close(Parting::GoodBye);
        write(&right, 15);
        assert_eq!(read(&port, 1), [15]);
        // What has ended takes nothing, and counts nothing.
        write(&left, 5);
        port.close(&refuses.source, Parting::Loss);
        until("the end is seen", || {
            let sent = refuses.connector.info().samples_sent;
            write(&right, 16);
            refuses.connector.info().samples_sent == sent
        });
        assert_eq!(overwrites.connector.info().samples_sent, 4);
        assert!(callback(&port).is_empty());
    }
}
