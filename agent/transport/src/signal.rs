//! One thread of this process waits until another has done something.

use std::sync::atomic::{AtomicU32, Ordering, fence};
use std::time::{Duration, Instant};

use rustix::event::Timespec;
use rustix::thread::futex;

/// Looks at a state so often before it sleeps: waking a thread costs more than most waits are long.
pub const SPINS: u32 = 200;

/// Times that a wait looks before it sleeps; none where nobody else could run meanwhile.
pub(crate) fn spins() -> u32 {
    static ALONE: std::sync::OnceLock<bool> = std::sync::OnceLock::new();
    let alone = || std::thread::available_parallelism().is_ok_and(|n| n.get() == 1);
    if *ALONE.get_or_init(alone) { 0 } else { SPINS }
}

/// As the system calls want it; none is for ever.
pub(crate) fn timespec(patience: Duration) -> Option<Timespec> {
    Timespec::try_from(patience).ok()
}

/// For one waiter at a time.
#[derive(Debug, Default)]
pub(crate) struct Signal {
    /// 1 while somebody sleeps, or is about to.
    asleep: AtomicU32,
}

impl Signal {
    /// Something was done. Costs a fence when nobody waits.
    pub fn notify(&self) {
        // What was done must be seen by a waiter that is not seen here.
        fence(Ordering::SeqCst);
        if self.asleep.load(Ordering::Relaxed) != 0 {
            self.wake();
        }
    }

    #[cold]
    fn wake(&self) {
        self.asleep.store(0, Ordering::SeqCst);
        let _ = futex::wake(&self.asleep, futex::Flags::PRIVATE, 1);
    }

    /// Waits until `ready`, that long; false when it is not.
    pub fn wait(&self, patience: Duration, ready: impl Fn() -> bool) -> bool {
        for _ in 0..spins() {
            if ready() {
                return true;
            }
            std::hint::spin_loop();
        }
        let until = Instant::now().checked_add(patience);
        loop {
            self.asleep.store(1, Ordering::SeqCst);
            fence(Ordering::SeqCst);
            let left = until.map_or(Duration::MAX, |until| {
                until.saturating_duration_since(Instant::now())
            });
            if ready() || left.is_zero() {
                self.asleep.store(0, Ordering::SeqCst);
                return ready();
            }
            let timeout = timespec(left);
            let _ = futex::wait(&self.asleep, futex::Flags::PRIVATE, 1, timeout.as_ref());
        }
    }
}
