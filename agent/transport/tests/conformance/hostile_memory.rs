//! The other end of shared memory writes there what it likes.

use std::io::IoSlice;
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use proptest::prelude::*;
use rts_transport::frame::Header;
use rts_transport::shm::{self, layout};
use rts_transport::{Ended, MAX_SAMPLE, Parting, Receiver, Refused, Sender};
use rustix::fs::{MemfdFlags, SealFlags};
use rustix::net::{SendAncillaryBuffer, SendAncillaryMessage, SendFlags};

use crate::ends::{PATIENCE, assert_is, end, next, sample};

const RING: usize = *layout::SIZES.start();

/// Memory as a sender makes it.
fn memory(size: usize, seals: SealFlags) -> OwnedFd {
    let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
    let memory = rustix::fs::memfd_create("forged", flags).unwrap();
    rustix::fs::ftruncate(&memory, size as u64).unwrap();
    rustix::fs::fcntl_add_seals(&memory, seals).unwrap();
    memory
}

fn sealed() -> OwnedFd {
    memory(layout::DATA + RING, SEALS)
}

const SEALS: SealFlags = SealFlags::SHRINK
    .union(SealFlags::GROW)
    .union(SealFlags::SEAL);

fn pass(control: &UnixStream, byte: u8, memories: &[BorrowedFd<'_>]) {
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(8))];
    let mut message = SendAncillaryBuffer::new(&mut space);
    if !memories.is_empty() {
        message.push(SendAncillaryMessage::ScmRights(memories));
    }
    let parts = [IoSlice::new(std::slice::from_ref(&byte))];
    rustix::net::sendmsg(control, &parts, &mut message, SendFlags::empty()).unwrap();
}

/// A receiver, with its sender's socket and memory in hand.
fn receiver() -> (UnixStream, OwnedFd, impl Receiver) {
    let (ours, theirs) = UnixStream::pair().unwrap();
    let memory = sealed();
    pass(&theirs, layout::PASSES, &[memory.as_fd()]);
    (theirs, memory, shm::receiver(ours).unwrap())
}

/// A sender, with its receiver's socket and memory in hand.
fn sender() -> (UnixStream, OwnedFd, impl Sender) {
    let (ours, theirs) = UnixStream::pair().unwrap();
    let sender = shm::sender_with(ours, RING).unwrap();
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut message = rustix::net::RecvAncillaryBuffer::new(&mut space);
    let mut byte = [0];
    let mut parts = [std::io::IoSliceMut::new(&mut byte)];
    let flags = rustix::net::RecvFlags::empty();
    rustix::net::recvmsg(&theirs, &mut parts, &mut message, flags).unwrap();
    let memory = message.drain().find_map(|message| match message {
        rustix::net::RecvAncillaryMessage::ScmRights(mut fds) => fds.next(),
        _ => None,
    });
    (theirs, memory.unwrap(), sender)
}

fn put(memory: &OwnedFd, at: usize, bytes: &[u8]) {
    rustix::io::pwrite(memory, bytes, at as u64).unwrap();
}

fn put_count(memory: &OwnedFd, at: usize, count: u64) {
    put(memory, at, &count.to_ne_bytes());
}

#[test]
fn only_memory_that_cannot_shrink_is_mapped() {
    let whole = layout::DATA + RING;
    let file = tempfile();
    let none = SealFlags::empty();
    for (memories, byte) in [
        (vec![], layout::PASSES),
        (vec![sealed()], b'2'),
        (vec![sealed(), sealed()], layout::PASSES),
        (
            vec![sealed(), sealed(), sealed(), sealed(), sealed(), sealed()],
            layout::PASSES,
        ),
        (vec![memory(whole, none)], layout::PASSES),
        (vec![memory(whole, SealFlags::GROW)], layout::PASSES),
        (vec![memory(whole - 1, SEALS)], layout::PASSES),
        (vec![memory(layout::DATA, SEALS)], layout::PASSES),
        (vec![memory(0, SEALS)], layout::PASSES),
        (vec![memory(layout::DATA + 3 * RING, SEALS)], layout::PASSES),
        (vec![memory(layout::DATA + RING / 2, SEALS)], layout::PASSES),
        (vec![file], layout::PASSES),
    ] {
        let (ours, theirs) = UnixStream::pair().unwrap();
        let fds: Vec<_> = memories.iter().map(AsFd::as_fd).collect();
        pass(&theirs, byte, &fds);
        assert!(shm::receiver(ours).is_err(), "{memories:?} {byte}");
    }
    let (ours, theirs) = UnixStream::pair().unwrap();
    drop(theirs);
    assert!(shm::receiver(ours).is_err());
    for ring in [0, 1, RING + 1, RING / 2, 1 << 40] {
        assert!(shm::sender_with(UnixStream::pair().unwrap().0, ring).is_err());
    }
}

/// Something that can be mapped, and is no sealed memory.
fn tempfile() -> OwnedFd {
    let path = std::env::current_exe().unwrap();
    std::fs::File::open(path).unwrap().into()
}

#[test]
fn a_writer_that_says_what_cannot_be_is_lost() {
    for written in [RING as u64 + 1, u64::MAX, 1 << 63] {
        let (_control, memory, mut receiver) = receiver();
        put_count(&memory, layout::WRITTEN, written);
        let (0, Ended::Lost(reason)) = end(&mut receiver) else {
            panic!("{written} was believed");
        };
        assert!(reason.contains("more than the ring holds"), "{reason}");
    }
    // It takes back what was read already.
    let (_control, memory, mut receiver) = receiver();
    let header = Header::Sample {
        size: 3,
        sequence: 1,
        time: sample(1, 0).time,
    };
    put(&memory, layout::DATA, &header.encode());
    put(&memory, layout::DATA + 24, &sample(1, 3).payload);
    put_count(&memory, layout::WRITTEN, 27);
    assert_is(&next(&mut receiver), 1, 3);
    put_count(&memory, layout::WRITTEN, 26);
    assert!(matches!(end(&mut receiver), (0, Ended::Lost(_))));
}

#[test]
fn a_reader_that_says_what_cannot_be_is_lost() {
    for taken in [70_000, u64::MAX, 1 << 63] {
        let (_control, memory, mut sender) = sender();
        put_count(&memory, layout::TAKEN, taken);
        // The first are written on what was known before.
        let refused = loop {
            match sender.push_within(sample(1, 60_000), Duration::from_secs(1)) {
                Ok(()) => {}
                Err(refused) => break refused,
            }
        };
        let Refused::Ended(Ended::Lost(reason)) = refused else {
            panic!("{taken} was believed: {refused}");
        };
        assert!(reason.contains("what was not written"), "{reason}");
    }
}

#[test]
fn a_sample_that_changes_while_it_is_read_is_only_a_wrong_sample() {
    let (control, memory, mut receiver) = receiver();
    let done = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            // Frames of any size that the header happens to have when it is read.
            let mut count: u64 = 0;
            let mut size: usize = 0;
            while !done.load(Ordering::Relaxed) {
                size = (size * 31 + 17) % 50_000;
                let header = Header::Sample {
                    size,
                    sequence: count,
                    time: 0,
                };
                put(
                    &memory,
                    layout::DATA + (count as usize * 24) % RING,
                    &header.encode(),
                );
                count += 24;
                put_count(&memory, layout::WRITTEN, count);
                put(&memory, layout::READER, &[(count % 5) as u8, 0, 0, 0]);
            }
        });
        let mut taken = 0;
        while taken < 2000 {
            match receiver.take(PATIENCE) {
                Ok(Some(sample)) => {
                    assert!(sample.payload.len() <= MAX_SAMPLE);
                    taken += 1;
                }
                Ok(None) => panic!("it waits for ever"),
                Err(Ended::Lost(_)) => break,
                Err(ended) => panic!("{ended}"),
            }
        }
        done.store(true, Ordering::Relaxed);
    });
    drop(control);
    assert!(matches!(end(&mut receiver).1, Ended::Lost(_)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn whatever_a_writer_writes_its_reader_lives(
        steps in prop::collection::vec(
            (prop_oneof![any::<u64>(), 0..200_000_u64], 0..RING, prop::collection::vec(any::<u8>(), 0..64), any::<bool>()),
            1..12,
        ),
    ) {
        let (control, memory, mut receiver) = receiver();
        for (count, at, bytes, is_frame) in steps {
            let header = Header::Sample { size: at, sequence: count, time: 0 };
            let bytes = if is_frame { header.encode().to_vec() } else { bytes };
            put(&memory, layout::DATA + at.min(RING - 64), &bytes);
            put_count(&memory, layout::WRITTEN, count);
            for _ in 0..4 {
                if let Ok(Some(sample)) = receiver.try_take() {
                    prop_assert!(sample.payload.len() <= RING);
                }
            }
        }
        drop(control);
        let ended = end(&mut receiver).1;
        prop_assert!(matches!(ended, Ended::Lost(_) | Ended::GoodBye), "{:?}", ended);
    }

    #[test]
    fn whatever_a_reader_writes_its_writer_lives(
        counts in prop::collection::vec((prop_oneof![any::<u64>(), 0..200_000_u64], any::<u32>()), 1..12),
    ) {
        let (control, memory, mut sender) = sender();
        for (count, word) in counts {
            put_count(&memory, layout::TAKEN, count);
            put(&memory, layout::READER, &word.to_ne_bytes());
            put(&memory, layout::WRITER, &word.to_ne_bytes());
            let _ = sender.push(sample(1, 30_000));
            let _ = sender.push_within(sample(2, 10), Duration::from_millis(1));
        }
        drop(control);
        sender.close(Parting::Loss);
        prop_assert!(sender.ended().is_some());
    }
}

/// Threads that run over each other in every way that the machine offers.
#[test]
fn samples_are_whole_under_stress_in_a_small_ring() {
    let (ours, theirs) = UnixStream::pair().unwrap();
    let mut sender = shm::sender_with(ours, RING).unwrap();
    let mut receiver = shm::receiver(theirs).unwrap();
    let size = |sequence: u64| match sequence % 7 {
        0 => 0,
        1 => 200_000 + sequence as usize,
        2 => RING - 24,
        _ => (sequence as usize * 131) % 3000,
    };
    let sending = thread::spawn(move || {
        for sequence in 1..=3000 {
            if sequence % 97 == 0 {
                thread::yield_now();
            }
            sender
                .push_within(sample(sequence, size(sequence)), PATIENCE)
                .unwrap();
        }
        sender.close(Parting::GoodBye);
    });
    for sequence in 1..=3000 {
        if sequence % 89 == 0 {
            thread::yield_now();
        }
        assert_is(&next(&mut receiver), sequence, size(sequence));
    }
    assert_eq!(end(&mut receiver), (0, Ended::GoodBye));
    sending.join().unwrap();
}
