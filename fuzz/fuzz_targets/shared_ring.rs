//! Another process writes anything into the memory that it shares with a receiver.
#![no_main]

use std::io::IoSlice;
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;

use libfuzzer_sys::fuzz_target;
use rts_transport::shm::{self, layout};
use rts_transport::{Receiver, MAX_SAMPLE};
use rustix::fs::{MemfdFlags, SealFlags};
use rustix::net::{SendAncillaryBuffer, SendAncillaryMessage, SendFlags};

const RING: usize = *layout::SIZES.start();

fuzz_target!(|steps: Vec<(u32, u16, &[u8])>| {
    let (control, theirs) = UnixStream::pair().expect("a pair of sockets");
    let memory = memory();
    pass(&theirs, &memory);
    let mut receiver = shm::receiver(control).expect("the memory is as it should be");
    for (count, at, bytes) in steps {
        let at = layout::DATA + usize::from(at).min(RING - bytes.len().min(RING));
        let _ = rustix::io::pwrite(&memory, bytes, at as u64);
        // Small steps are likely to be believed.
        let count = u64::from(count % (2 * RING as u32));
        let _ = rustix::io::pwrite(&memory, &count.to_ne_bytes(), layout::WRITTEN as u64);
        for _ in 0..3 {
            if let Ok(Some(sample)) = receiver.try_take() {
                assert!(sample.payload.len() <= MAX_SAMPLE);
            }
        }
    }
});

fn memory() -> OwnedFd {
    let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
    let memory = rustix::fs::memfd_create("fuzz", flags).expect("memory");
    rustix::fs::ftruncate(&memory, (layout::DATA + RING) as u64).expect("its size");
    let seals = SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL;
    rustix::fs::fcntl_add_seals(&memory, seals).expect("its seals");
    memory
}

fn pass(control: &UnixStream, memory: &OwnedFd) {
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut message = SendAncillaryBuffer::new(&mut space);
    let passed = [memory.as_fd()];
    message.push(SendAncillaryMessage::ScmRights(&passed));
    let parts = [IoSlice::new(&[layout::PASSES])];
    rustix::net::sendmsg(control, &parts, &mut message, SendFlags::empty()).expect("room");
}
