//! One process waits until the other has done something in the shared memory.
//!
//! First it looks for a while, then it sleeps on its word, as that is quick to wake. Who has slept for long sleeps on
//! the socket, so that an idle connection costs nothing, and the death of the other process wakes it.

use std::io;
use std::os::fd::BorrowedFd;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering, fence};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::net::SendFlags;
use rustix::thread::futex;

use super::layout::{AWAKE, ON_SOCKET, ON_WORD, WAKE};
use crate::signal::timespec;
use crate::spin::Spin;

/// A process that dies wakes nobody who sleeps on a word.
const ON_WORD_FOR: Duration = Duration::from_millis(50);

/// The sleep word of one side, and the socket of this one.
#[derive(Debug, Clone, Copy)]
pub struct Sleep<'a> {
    /// The word of who sleeps.
    pub word: &'a AtomicU32,
    /// To the other process.
    pub control: BorrowedFd<'a>,
    /// What was learned of earlier waits.
    pub spin: &'a Spin,
}

impl Sleep<'_> {
    /// Tells the other side a count, and wakes it if it sleeps.
    pub fn tell(self, count: &AtomicU64, value: u64) {
        // In one order with the sleeper's: either it sees the count, or it is seen to sleep.
        count.swap(value, Ordering::SeqCst);
        if self.word.load(Ordering::SeqCst) != AWAKE {
            self.ring();
        }
    }

    #[cold]
    fn ring(self) {
        match self.word.swap(AWAKE, Ordering::SeqCst) {
            ON_WORD => {
                let _ = futex::wake(self.word, futex::Flags::empty(), 1);
            }
            ON_SOCKET => {
                // When there is no room there are bytes that wake it.
                let flags = SendFlags::DONTWAIT | SendFlags::NOSIGNAL;
                let _ = rustix::net::send(self.control, &[WAKE], flags);
            }
            _ => {}
        }
    }

    /// This side is to look at what has happened in this process.
    pub fn wake_here(self) {
        self.word.store(AWAKE, Ordering::SeqCst);
        let _ = futex::wake(self.word, futex::Flags::empty(), 1);
    }

    /// Waits until `ready`, or something is on the socket, or until then at the latest; or for no reason.
    pub fn wait(self, patience: Duration, ready: impl Fn() -> bool) -> io::Result<()> {
        if self.spin.until(&ready) {
            return Ok(());
        }
        let nap = timespec(patience.min(ON_WORD_FOR));
        let word_changed = self.sleep(ON_WORD, &ready, || {
            match futex::wait(self.word, futex::Flags::empty(), ON_WORD, nap.as_ref()) {
                Err(Errno::TIMEDOUT) => Ok(false),
                _ => Ok(true),
            }
        })?;
        if word_changed || patience <= ON_WORD_FOR {
            return Ok(());
        }
        let timeout = timespec(patience - ON_WORD_FOR);
        self.sleep(ON_SOCKET, &ready, || {
            let mut fds = [PollFd::from_borrowed_fd(self.control, PollFlags::IN)];
            match poll(&mut fds, timeout.as_ref()) {
                Ok(_) | Err(Errno::INTR) => Ok(true),
                Err(error) => Err(error.into()),
            }
        })?;
        Ok(())
    }

    /// Sleeps in this way, unless it is ready.
    fn sleep(
        self,
        how: u32,
        ready: &impl Fn() -> bool,
        sleep: impl FnOnce() -> io::Result<bool>,
    ) -> io::Result<bool> {
        self.word.store(how, Ordering::SeqCst);
        fence(Ordering::SeqCst);
        let woken = if ready() { Ok(true) } else { sleep() };
        self.word.store(AWAKE, Ordering::SeqCst);
        woken
    }
}
