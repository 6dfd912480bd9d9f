//! The other end is a process that is killed.

use std::time::Duration;

use rts_transport::{Ended, Kind, Refused};

use crate::child::start;
use crate::ends::{PATIENCE, end, end_of_sender, next, sample, sockets};

/// What is sent to the other process.
pub fn samples() -> impl Iterator<Item = (u64, usize)> {
    (1..=300).map(|sequence| (sequence, (sequence as usize * 7919) % 100_000))
}

pub fn another_process_gets_what_is_sent_and_answers(kind: Kind) {
    let (ours, theirs) = sockets(kind);
    let mut child = start("take all", kind, Some(theirs));
    let mut sender = kind.sender(ours).unwrap();
    for (sequence, size) in samples() {
        sender
            .push_within(sample(sequence, size), PATIENCE)
            .unwrap();
    }
    assert_eq!(end_of_sender(&mut *sender), Ended::GoodBye);
    assert!(child.wait().unwrap().success());
}

pub fn a_killed_sender_is_a_loss(kind: Kind) {
    for (role, at_least) in [("send one", 1), ("send until full", 2)] {
        let (ours, theirs) = sockets(kind);
        let mut child = start(role, kind, Some(theirs));
        let mut receiver = kind.receiver(ours).unwrap();
        next(&mut *receiver);
        // One waits for it when it dies, the other has samples to take first.
        let killing = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(100));
            child.kill().unwrap();
            child.wait().unwrap();
        });
        if at_least > 1 {
            killing.join().unwrap();
        }
        let (samples, ended) = end(&mut *receiver);
        assert!(samples + 1 >= at_least, "{samples}");
        assert!(matches!(ended, Ended::Lost(_)), "{ended:?}");
    }
}

pub fn a_killed_receiver_is_a_loss(kind: Kind) {
    for waits in [false, true] {
        let (ours, theirs) = sockets(kind);
        let mut sender = kind.sender(ours).unwrap();
        sender.push(sample(1, 10)).unwrap();
        let mut child = start("take one", kind, Some(theirs));
        let killing = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(300));
            child.kill().unwrap();
            child.wait().unwrap();
        });
        let ended = if waits {
            loop {
                match sender.push_within(sample(1, 10_000), PATIENCE) {
                    Ok(()) => {}
                    Err(Refused::Ended(ended)) => break ended,
                    Err(refused) => panic!("{refused}"),
                }
            }
        } else {
            end_of_sender(&mut *sender)
        };
        assert!(matches!(ended, Ended::Lost(_)), "{ended:?}");
        killing.join().unwrap();
    }
}
