//! One thread of this process waits until another has done something.

use std::sync::atomic::{AtomicU32, Ordering, fence};
use std::time::{Duration, Instant};

use rustix::event::Timespec;
use rustix::thread::futex;

use crate::spin::Spin;

/// As the system calls want it; none is for ever.
pub(crate) fn timespec(patience: Duration) -> Option<Timespec> {
    Timespec::try_from(patience).ok()
}

/// For one waiter at a time.
#[derive(Debug, Default)]
pub(crate) struct Signal {
    /// 1 while somebody sleeps, or is about to.
    asleep: AtomicU32,
    spin: Spin,
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
        if self.spin.until(&ready) {
            return true;
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
