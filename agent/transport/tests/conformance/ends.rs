//! Connections for tests.

use std::net::{TcpListener, TcpStream};
use std::num::NonZeroUsize;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use rts_transport::{Ended, Kind, Payload, Receiver, Refused, Sample, Sender, inproc};

/// Longer than anything takes.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// Both ends of a connection in this process.
pub fn pair(kind: Kind) -> (Box<dyn Sender>, Box<dyn Receiver>) {
    if kind == Kind::InProcess {
        let (sender, receiver) = inproc::pair(NonZeroUsize::new(16).unwrap());
        return (Box::new(sender), Box::new(receiver));
    }
    let (ours, theirs) = sockets(kind);
    let sender = kind.sender(ours).unwrap();
    (sender, kind.receiver(theirs).unwrap())
}

/// The sockets that a transport between processes begins with.
pub fn sockets(kind: Kind) -> (OwnedFd, OwnedFd) {
    match kind {
        Kind::Tcp => {
            let listener = TcpListener::bind("127.0.0.1:0").unwrap();
            let ours = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
            (ours.into(), listener.accept().unwrap().0.into())
        }
        _ => {
            let (ours, theirs) = UnixStream::pair().unwrap();
            (ours.into(), theirs.into())
        }
    }
}

/// A sample with so many bytes that follow from its number.
pub fn sample(sequence: u64, size: usize) -> Sample {
    static BYTES: LazyLock<Payload> = LazyLock::new(|| {
        let byte = |i: u32| (i.wrapping_mul(0x9e37_79b1) >> 24) as u8;
        (0..(4 << 20) + 1000).map(byte).collect()
    });
    let from = (sequence % 1000) as usize;
    Sample {
        sequence,
        time: sequence * 1_000_000 + 1,
        payload: BYTES.slice(from..from + size),
    }
}

/// Requires that a sample came as it was sent, and says little when not.
pub fn assert_is(got: &Sample, sequence: u64, size: usize) {
    let expected = sample(sequence, size);
    assert_eq!(
        (got.sequence, got.time, got.payload.len()),
        (sequence, expected.time, size)
    );
    assert!(
        got.payload == expected.payload,
        "sample {sequence} came with other bytes"
    );
}

/// The next sample.
pub fn next(receiver: &mut dyn Receiver) -> Sample {
    receiver
        .take(PATIENCE)
        .unwrap_or_else(|ended| panic!("{ended}"))
        .expect("a sample in time")
}

/// How the connection ends for a receiver, after how many samples.
pub fn end(receiver: &mut dyn Receiver) -> (u64, Ended) {
    let mut samples = 0;
    loop {
        match receiver.take(PATIENCE) {
            Ok(Some(_)) => samples += 1,
            Ok(None) => panic!("no end in time, after {samples} samples"),
            Err(ended) => return (samples, ended),
        }
    }
}

/// How the connection ends for a sender that sends nothing.
pub fn end_of_sender(sender: &mut dyn Sender) -> Ended {
    let begin = Instant::now();
    loop {
        if let Some(ended) = sender.ended() {
            return ended;
        }
        assert!(begin.elapsed() < PATIENCE, "no end in time");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Pushes samples from 1 on until there is no room; says how many were taken.
pub fn fill(sender: &mut dyn Sender, size: usize) -> u64 {
    for sequence in 1..1_000_000 {
        match sender.push(sample(sequence, size)) {
            Ok(()) => {}
            Err(Refused::Full(back)) => {
                assert_is(&back, sequence, size);
                return sequence - 1;
            }
            Err(refused) => panic!("{refused}"),
        }
    }
    panic!("it is never full");
}
