//! Floor: two rings in shared memory with a futex each way, for two processes that trust each other.

#![allow(unsafe_code)]

use std::os::fd::OwnedFd;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering, fence};

use rustix::event::Timespec;
use rustix::mm::{MapFlags, ProtFlags};
use rustix::thread::futex;

use crate::bytes_of::{expected, fill, sum};
use crate::link::Link;

/// Bytes of one ring: room for two of the largest samples.
const RING: usize = 2 * 1024 * 1024;
/// Where its bytes begin.
const DATA: usize = 4096;
/// Looks as often as the transport does before it sleeps.
const SPINS: u32 = rts_transport::SPINS;

/// Memory for both ways.
pub fn memory() -> OwnedFd {
    let memory = rustix::fs::memfd_create("floor", rustix::fs::MemfdFlags::CLOEXEC).unwrap();
    rustix::fs::ftruncate(&memory, 2 * (DATA + RING) as u64).unwrap();
    memory
}

#[derive(Clone, Copy)]
struct Ring(NonNull<u8>);

impl Ring {
    fn count(&self, at: usize) -> &AtomicU64 {
        // SAFETY: within the first page of the mapping, which is never undone.
        unsafe { self.0.add(at).cast().as_ref() }
    }

    fn word(&self, at: usize) -> &AtomicU32 {
        // SAFETY: as above.
        unsafe { self.0.add(at).cast().as_ref() }
    }

    fn wait(&self, word: usize, ready: impl Fn() -> bool) -> bool {
        for _ in 0..SPINS {
            if ready() {
                return true;
            }
            std::hint::spin_loop();
        }
        let word = self.word(word);
        for _ in 0..100 {
            word.store(1, Ordering::SeqCst);
            fence(Ordering::SeqCst);
            if ready() {
                word.store(0, Ordering::SeqCst);
                return true;
            }
            let patience = Timespec {
                tv_sec: 1,
                tv_nsec: 0,
            };
            let _ = futex::wait(word, futex::Flags::empty(), 1, Some(&patience));
        }
        false
    }

    fn wake(&self, word: usize) {
        fence(Ordering::SeqCst);
        let word = self.word(word);
        if word.load(Ordering::Relaxed) != 0 {
            word.store(0, Ordering::SeqCst);
            let _ = futex::wake(word, futex::Flags::empty(), 1);
        }
    }

    fn write(&self, bytes: &[u8]) {
        let written = self.count(0).load(Ordering::Relaxed);
        let room = || {
            let taken = self.count(128).load(Ordering::Acquire);
            RING - (written - taken) as usize >= bytes.len()
        };
        self.wait(384, room);
        // SAFETY: sizes are powers of two, so that no sample goes over the end of the ring.
        unsafe {
            let to = self.0.as_ptr().add(DATA + written as usize % RING);
            to.copy_from_nonoverlapping(bytes.as_ptr(), bytes.len());
        }
        let written = written + bytes.len() as u64;
        self.count(0).store(written, Ordering::Release);
        self.wake(256);
    }

    fn read(&self, bytes: &mut [u8]) -> bool {
        let taken = self.count(128).load(Ordering::Relaxed);
        let there = || self.count(0).load(Ordering::Acquire) - taken >= bytes.len() as u64;
        if !self.wait(256, there) {
            return false;
        }
        // SAFETY: as above.
        unsafe {
            let from = self.0.as_ptr().add(DATA + taken as usize % RING);
            bytes
                .as_mut_ptr()
                .copy_from_nonoverlapping(from, bytes.len());
        }
        let taken = taken + bytes.len() as u64;
        self.count(128).store(taken, Ordering::Release);
        self.wake(384);
        true
    }
}

/// One end of both rings.
pub struct Rings {
    out: Ring,
    back: Ring,
    buffer: Vec<u8>,
}

impl Rings {
    pub fn new(memory: &OwnedFd, size: usize, is_child: bool) -> Self {
        let (protection, flags) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::SHARED);
        let (anywhere, all) = (std::ptr::null_mut(), 2 * (DATA + RING));
        // SAFETY: a new mapping at an address of the kernel's choice; both processes are this program.
        let base = unsafe { rustix::mm::mmap(anywhere, all, protection, flags, memory, 0) };
        let base = NonNull::new(base.unwrap().cast()).unwrap();
        // SAFETY: within the mapping.
        let other = unsafe { base.add(DATA + RING) };
        let (out, back) = if is_child {
            (other, base)
        } else {
            (base, other)
        };
        Self {
            out: Ring(out),
            back: Ring(back),
            buffer: vec![0; size],
        }
    }
}

impl Link for Rings {
    fn send(&mut self, sequence: u64) {
        fill(&mut self.buffer, sequence);
        self.out.write(&self.buffer);
    }

    fn receive(&mut self, sequence: u64) -> bool {
        if !self.back.read(&mut self.buffer) {
            return false;
        }
        assert_eq!(sum(&self.buffer), expected(self.buffer.len(), sequence));
        true
    }
}
