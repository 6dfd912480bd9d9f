//! Memory that a program which does nothing does not keep.

// Two calls of the C library that have no safe wrapper.
#![allow(unsafe_code)]

use std::time::Duration;

/// Heaps of a program: each thread that allocates gets one of its own, and what is freed in one is of no use to another.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const HEAPS: libc::c_int = 2;
/// Until what a start has freed is given back: it is over then.
const SOON: Duration = Duration::from_secs(1);
/// Time between two looks for more.
const LATER: Duration = Duration::from_secs(60);

/// Keeps the heaps few. To be called before there are threads.
pub fn few_heaps() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: it sets a number of the allocator, and touches nothing that was allocated.
    unsafe {
        libc::mallopt(libc::M_ARENA_MAX, HEAPS);
    }
}

/// Gives what was freed back to the system.
pub fn give_back() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: it gives back what nobody has allocated, under the allocator's own locks.
    unsafe {
        libc::malloc_trim(0);
    }
}

/// Gives back what was freed: soon, and now and then, for ever.
pub async fn keep_small() {
    let mut pause = SOON;
    loop {
        tokio::time::sleep(pause).await;
        give_back();
        pause = LATER;
    }
}
