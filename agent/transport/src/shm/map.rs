//! The shared memory, mapped.

#![allow(unsafe_code)]

use std::io;
use std::os::fd::OwnedFd;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, AtomicU64};

use bytes::{BufMut, BytesMut};
use rustix::fs::{MemfdFlags, SealFlags};
use rustix::mm::{MapFlags, ProtFlags};

use super::layout::{DATA, SIZES};

/// What keeps the size as it was checked: a mapping beyond the end of its memory would kill this process.
const SEALS: SealFlags = SealFlags::SHRINK
    .union(SealFlags::GROW)
    .union(SealFlags::SEAL);

/// File system of a memfd of ordinary pages. Huge ones can run out, which would kill this process as well.
const TMPFS: u64 = 0x0102_1994;

/// Counts, sleep words and the ring.
#[derive(Debug)]
pub struct Map {
    base: NonNull<u8>,
    ring: usize,
}

// SAFETY: the memory is reached by atomics and by copies to and from it only, from any thread.
unsafe impl Send for Map {}
// SAFETY: as above.
unsafe impl Sync for Map {}

impl Map {
    /// New memory with a ring of so many bytes, and the descriptor to pass on.
    pub fn create(ring: usize) -> io::Result<(Self, OwnedFd)> {
        let size = checked((DATA + ring) as u64)?;
        let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
        let memory = rustix::fs::memfd_create("rts-ring", flags)?;
        rustix::fs::ftruncate(&memory, (DATA + size) as u64)?;
        rustix::fs::fcntl_add_seals(&memory, SEALS)?;
        Ok((Self::of(&memory, size)?, memory))
    }

    /// Memory that the other end passed.
    pub fn open(memory: &OwnedFd) -> io::Result<Self> {
        let refused = |text: &str| io::Error::new(io::ErrorKind::InvalidData, text);
        let seals = rustix::fs::fcntl_get_seals(memory)
            .map_err(|_| refused("the other end passed something that is no shared memory"))?;
        if !seals.contains(SEALS) {
            return Err(refused(
                "the other end passed memory whose size is not sealed",
            ));
        }
        if rustix::fs::fstatfs(memory)?.f_type as u64 != TMPFS {
            return Err(refused(
                "the other end passed memory that is not of ordinary pages",
            ));
        }
        let size = u64::try_from(rustix::fs::fstat(memory)?.st_size).unwrap_or(0);
        Self::of(memory, checked(size)?)
    }

    fn of(memory: &OwnedFd, ring: usize) -> io::Result<Self> {
        let (protection, flags) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::SHARED);
        let anywhere = std::ptr::null_mut();
        // SAFETY: a new mapping at an address of the kernel's choice, of a file whose size is sealed.
        let base =
            unsafe { rustix::mm::mmap(anywhere, DATA + ring, protection, flags, memory, 0)? };
        let base = NonNull::new(base.cast()).ok_or(io::ErrorKind::OutOfMemory)?;
        Ok(Self { base, ring })
    }

    /// Bytes of the ring.
    pub fn ring(&self) -> usize {
        self.ring
    }

    /// A count.
    pub fn count(&self, at: usize) -> &AtomicU64 {
        assert!(at < DATA && at.is_multiple_of(align_of::<AtomicU64>()));
        // SAFETY: within the mapping, which lives as long as `self`, and aligned, as it begins with a page. Every
        // bit pattern is a number, and other processes change it only as an atomic may change.
        unsafe { self.base.add(at).cast().as_ref() }
    }

    /// A sleep word.
    pub fn word(&self, at: usize) -> &AtomicU32 {
        assert!(at < DATA && at.is_multiple_of(align_of::<AtomicU32>()));
        // SAFETY: as for a count.
        unsafe { self.base.add(at).cast().as_ref() }
    }

    /// Copies bytes into the ring, from this count on. No more than the ring has.
    pub fn copy_in(&self, count: u64, bytes: &[u8]) {
        assert!(bytes.len() <= self.ring);
        let (at, first) = self.place(count, bytes.len());
        // SAFETY: `at + first` and the rest are at most `ring`, so both copies are within the mapping. It is no part
        // of any Rust object, so `bytes` does not overlap it; what the other process writes there meanwhile spoils
        // its own samples only.
        unsafe {
            let data = self.base.as_ptr().add(DATA);
            data.add(at).copy_from_nonoverlapping(bytes.as_ptr(), first);
            data.copy_from_nonoverlapping(bytes.as_ptr().add(first), bytes.len() - first);
        }
    }

    /// Appends bytes of the ring, from this count on. No more than the ring has, or there is room for.
    pub fn copy_out(&self, count: u64, length: usize, into: &mut BytesMut) {
        let spare = into.spare_capacity_mut();
        assert!(length <= self.ring && length <= spare.len());
        let (at, first) = self.place(count, length);
        let spare: *mut u8 = spare.as_mut_ptr().cast();
        // SAFETY: as for `copy_in`; `spare` has room for `length`. What the other process writes there meanwhile
        // gives bytes of one time or the other, and bytes are all that they are until they are checked here.
        unsafe {
            let data = self.base.as_ptr().add(DATA);
            spare.copy_from_nonoverlapping(data.add(at), first);
            spare
                .add(first)
                .copy_from_nonoverlapping(data, length - first);
            into.advance_mut(length);
        }
    }

    /// Where a count is in the ring, and how much of a length is there before the ring begins again.
    fn place(&self, count: u64, length: usize) -> (usize, usize) {
        let at = (count & (self.ring as u64 - 1)) as usize;
        (at, length.min(self.ring - at))
    }
}

impl Drop for Map {
    fn drop(&mut self) {
        // SAFETY: mapped by `of` with this length; all references into it have ended with `self`.
        let _ = unsafe { rustix::mm::munmap(self.base.as_ptr().cast(), DATA + self.ring) };
    }
}

/// Bytes of the ring in memory of so many.
fn checked(size: u64) -> io::Result<usize> {
    let ring = usize::try_from(size).ok().and_then(|s| s.checked_sub(DATA));
    ring.filter(|ring| SIZES.contains(ring) && ring.is_power_of_two())
        .ok_or_else(|| {
            let text = format!("a ring cannot have {size} bytes with its {DATA} of counts");
            io::Error::new(io::ErrorKind::InvalidData, text)
        })
}
