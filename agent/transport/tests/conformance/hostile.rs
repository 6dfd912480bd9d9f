//! The other end is not what it should be.

use std::fs::File;
use std::io::Write;
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use rts_transport::frame::{HEADER, Header};
use rts_transport::{Ended, Kind, MAX_SAMPLE, Receiver};

use crate::ends::{assert_is, end, end_of_sender, next, sample, sockets};

/// A receiver, and what its sender writes to.
fn receiver(kind: Kind) -> (File, Box<dyn Receiver>) {
    let (ours, theirs) = sockets(kind);
    (File::from(theirs), kind.receiver(ours).unwrap())
}

fn header(sequence: u64, size: usize) -> [u8; HEADER] {
    let time = sample(sequence, 0).time;
    Header::Sample {
        size,
        sequence,
        time,
    }
    .encode()
}

fn shut_writing(socket: &OwnedFd) {
    rustix::net::shutdown(socket, rustix::net::Shutdown::Write).unwrap();
}

pub fn a_receiver_that_sends_nothing_any_more_is_a_loss(kind: Kind) {
    let (ours, theirs) = sockets(kind);
    let mut sender = kind.sender(ours).unwrap();
    shut_writing(&theirs);
    assert!(matches!(end_of_sender(&mut *sender), Ended::Lost(_)));
}

pub fn a_sender_that_sends_nothing_any_more_is_a_loss(kind: Kind) {
    let (mut raw, mut receiver) = receiver(kind);
    raw.write_all(&header(1, 3)).unwrap();
    raw.write_all(&sample(1, 3).payload).unwrap();
    shut_writing(&raw.try_clone().unwrap().into());
    assert_is(&next(&mut *receiver), 1, 3);
    assert!(matches!(end(&mut *receiver), (0, Ended::Lost(_))));
}

pub fn what_is_no_frame_is_refused(kind: Kind) {
    let mut large = header(1, 0);
    large[..4].copy_from_slice(&(MAX_SAMPLE as u32 + 1).to_be_bytes());
    let mut longest = header(1, 0);
    longest[..4].fill(0xff);
    let mut talkative = Header::GoodBye.encode();
    talkative[8] = 1;
    for (bytes, said) in [
        (&[0; HEADER][..], "no frame"),
        (&[0xff; HEADER], "no frame"),
        (b"GET / HTTP/1.1\r\nHost: robot\r\n\r\n", "no frame"),
        (&large, "at most"),
        (&longest, "at most"),
        (&talkative, "good-bye with something in it"),
    ] {
        let (mut raw, mut receiver) = receiver(kind);
        raw.write_all(&header(1, 0)).unwrap();
        raw.write_all(bytes).unwrap();
        assert_is(&next(&mut *receiver), 1, 0);
        let (0, Ended::Lost(reason)) = end(&mut *receiver) else {
            panic!("{bytes:?} was taken");
        };
        assert!(reason.contains(said), "{bytes:?}: {reason}");
        // It is not listened to any more.
        let _ = raw.write_all(&header(2, 0));
        assert!(matches!(end(&mut *receiver), (0, Ended::Lost(_))));
    }
}

pub fn a_sample_that_trickles_is_waited_for_no_longer_than_asked(kind: Kind) {
    let (mut raw, mut receiver) = receiver(kind);
    raw.write_all(&header(1, 100_000)).unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = Arc::clone(&stop);
    let trickle = thread::spawn(move || {
        let mut sent = 0;
        while !stopped.load(Ordering::Relaxed) {
            raw.write_all(&[7]).unwrap();
            sent += 1;
            thread::sleep(Duration::from_millis(5));
        }
        raw.write_all(&vec![7; 100_000 - sent]).unwrap();
        raw
    });
    assert_eq!(receiver.take(Duration::from_millis(50)), Ok(None));
    assert!(!trickle.is_finished(), "it came all the while");
    stop.store(true, Ordering::Relaxed);
    let taken = next(&mut *receiver);
    assert_eq!((taken.sequence, &*taken.payload), (1, &[7; 100_000][..]));
    drop(trickle.join().unwrap());
}

pub fn a_cut_sample_is_a_loss(kind: Kind) {
    for (size, sent) in [(10, 9), (100_000, 99_999), (100_000, 10), (5, 0)] {
        let (mut raw, mut receiver) = receiver(kind);
        raw.write_all(&header(1, size)).unwrap();
        raw.write_all(&vec![0; sent]).unwrap();
        drop(raw);
        let (0, Ended::Lost(reason)) = end(&mut *receiver) else {
            panic!("a cut sample was taken");
        };
        assert!(reason.contains("within a sample"), "{reason}");
    }
}
