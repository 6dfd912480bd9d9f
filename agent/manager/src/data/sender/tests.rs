//! What becomes of samples, and of the ends, whatever the transport.

use std::sync::Arc;
use std::thread;

use super::*;
use crate::data::ends::{BETWEEN, agreed, pair};
use crate::data::in_port::InPort;
use crate::data::receive::receive;
use crate::data::source::Source;
use rts_schemas::connector::{LONGEST_BUFFER, PushPolicy};
use rts_transport::Receiver;

/// One whose writer sends, and one whose thread does.
fn both() -> [ConnectorSettings; 2] {
    let published = ConnectorSettings {
        subscription: Subscription::New(PushPolicy::All),
        ..ConnectorSettings::default()
    };
    [ConnectorSettings::default(), published]
}

fn sender(kind: Kind, settings: &ConnectorSettings) -> (Arc<Sender>, Box<dyn Receiver>) {
    let (agreed, receiver) = pair(kind);
    let sender = Sender::new(agreed, settings).unwrap();
    (Arc::new(sender), receiver)
}

/// Its thread.
fn sending(sender: &Arc<Sender>) -> thread::JoinHandle<Ended> {
    let sender = Arc::clone(sender);
    thread::spawn(move || sender.send())
}

/// The thread of the other end.
fn receiving(
    mut receiver: Box<dyn Receiver>,
    port: &Arc<InPort>,
    source: &Arc<Source>,
) -> thread::JoinHandle<Ended> {
    let (port, source) = (Arc::clone(port), Arc::clone(source));
    thread::spawn(move || receive(&mut *receiver, &port, &source, &agreed()))
}

fn push(sender: &Sender, sequence: u64, payload: Payload) -> u64 {
    let (offered, drops) = sender.offer(Sample {
        sequence,
        time: 1,
        payload,
    });
    offered.unwrap();
    drops
}

/// A source whose samples find room, however many come at once.
fn open(port: &InPort) -> Arc<Source> {
    let mut settings = ConnectorSettings::default();
    settings.in_buffer.length = LONGEST_BUFFER;
    let source = Arc::new(Source::new(None, settings, None));
    port.open(&source);
    source
}

#[test]
fn samples_of_all_sizes_pass_and_both_ends_notice_the_end() {
    for (kind, settings) in BETWEEN
        .iter()
        .zip(both())
        .chain([(&Kind::Tcp, both()[0].clone())])
    {
        let (sender, receiver) = sender(*kind, &settings);
        let thread = sending(&sender);
        let port = Arc::new(InPort::new("in", "T"));
        let source = open(&port);
        let receiver = receiving(receiver, &port, &source);
        let sizes = [0, 10, 40_000, 1 << 20, 1, 32_767, 32_768, 65_536];
        for (sequence, size) in (1..).zip(sizes) {
            let payload = vec![size as u8; size];
            assert_eq!(push(&sender, sequence, payload.into()), 0);
        }
        for size in sizes {
            let payload = loop {
                port.begin();
                match port.read().sample() {
                    Some(payload) => break payload,
                    None => thread::yield_now(),
                }
            };
            assert_eq!(payload.len(), size);
            assert!(payload.iter().all(|byte| *byte == size as u8));
        }
        assert_eq!(source.counts().gaps, 0);
        sender.close(Parting::GoodBye);
        assert_eq!(receiver.join().unwrap(), Ended::GoodBye);
        assert_eq!(thread.join().unwrap(), Ended::Here);
    }
}

/// A sender whose receiver ended by `end`, with samples under way that it never read.
fn ended(kind: Kind, end: impl FnOnce(Box<dyn Receiver>)) -> Ended {
    let (sender, receiver) = sender(kind, &both()[0]);
    for sequence in 1..10 {
        push(&sender, sequence, vec![0; 1 << 20].into());
    }
    let thread = sending(&sender);
    thread::sleep(Duration::from_millis(20));
    end(receiver);
    thread.join().unwrap()
}

#[test]
fn a_good_bye_tells_an_end_from_a_loss_also_when_samples_are_under_way() {
    for kind in BETWEEN {
        let good_bye = |receiver: Box<dyn Receiver>| {
            let settings = ConnectorSettings::default();
            let source = Source::new(Some(receiver.handle()), settings, None);
            source.close(Parting::GoodBye);
        };
        assert_eq!(ended(kind, good_bye), Ended::GoodBye, "{kind}");
        assert!(matches!(ended(kind, drop), Ended::Lost(_)), "{kind}");
    }
}

#[test]
fn the_end_of_one_that_says_no_good_bye_is_a_loss_that_says_so() {
    let (mut agreed, receiver) = pair(Kind::Unix);
    agreed.is_version_1 = true;
    let sender = Sender::new(agreed, &both()[0]).unwrap();
    drop(receiver);
    let Ended::Lost(reason) = sender.send() else {
        panic!("a loss");
    };
    assert!(reason.contains("speaks version 1"), "{reason}");
}

#[test]
fn one_that_is_closed_does_not_wait_for_a_receiver_that_stalls() {
    for kind in BETWEEN {
        let (sender, _receiver) = sender(kind, &both()[0]);
        for sequence in 1..10 {
            push(&sender, sequence, vec![0; 1 << 22].into());
        }
        let thread = sending(&sender);
        thread::sleep(Duration::from_millis(20));
        let begin = Instant::now();
        sender.close(Parting::GoodBye);
        assert_eq!(thread.join().unwrap(), Ended::Here);
        assert!(begin.elapsed() < Duration::from_secs(10));
    }
}

#[test]
fn what_is_queued_while_the_last_write_waits_for_room_is_sent() {
    for kind in BETWEEN {
        let (sender, receiver) = sender(kind, &both()[1]);
        let thread = sending(&sender);
        // Nobody reads: each is taken from the queue before the next comes, until one finds no room, as the last of its
        // write. Then one more comes.
        let mut sent = 0;
        let taken = |sender: &Sender| {
            let begin = Instant::now();
            while begin.elapsed() < Duration::from_millis(100) {
                if sender.outbox.is_empty() {
                    return true;
                }
                thread::sleep(Duration::from_millis(1));
            }
            false
        };
        while taken(&sender) {
            sent += 1;
            assert_eq!(push(&sender, sent, vec![0; 30_000].into()), 0);
        }
        let port = Arc::new(InPort::new("in", "T"));
        let source = open(&port);
        let receiver = receiving(receiver, &port, &source);
        let begin = Instant::now();
        while source.counts().received < sent {
            port.begin();
            port.read();
            let received = source.counts().received;
            assert!(
                begin.elapsed() < Duration::from_secs(10),
                "{kind}: {received} of {sent}"
            );
            thread::yield_now();
        }
        sender.close(Parting::GoodBye);
        assert_eq!(receiver.join().unwrap(), Ended::GoodBye);
        assert_eq!(thread.join().unwrap(), Ended::Here);
    }
}

#[test]
fn a_stalled_receiver_costs_the_oldest_samples_and_blocks_nobody() {
    for kind in BETWEEN {
        let (sender, receiver) = sender(kind, &both()[0]);
        let thread = sending(&sender);
        let payload = Payload::from(vec![0; 1 << 20]);
        let drops: u64 = (1..200)
            .map(|sequence| push(&sender, sequence, payload.clone()))
            .sum();
        assert!(drops > 100, "{kind}: {drops}");
        drop(receiver);
        assert!(matches!(thread.join().unwrap(), Ended::Lost(_)));
    }
}
