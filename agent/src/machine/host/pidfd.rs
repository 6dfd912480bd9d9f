//! A handle of a process that becomes readable when the process ends.
#![allow(unsafe_code)]

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use rts_host::identity::start_ticks;
use rts_host::process::number;
use rustix::process::PidfdFlags;
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;

/// An open process.
#[derive(Debug)]
pub(super) struct PidFd(AsyncFd<OwnedFd>);

impl PidFd {
    /// Opens a process. With `started` it must be the one that started then.
    pub fn open(pid: u32, started: Option<u64>) -> io::Result<Self> {
        let fd = rustix::process::pidfd_open(number(pid)?, PidfdFlags::NONBLOCK)?;
        if started.is_some() && start_ticks(pid) != started {
            return Err(io::Error::from(io::ErrorKind::NotFound));
        }
        Self::of(fd)
    }

    /// Watches a process that is open already.
    pub fn of(fd: OwnedFd) -> io::Result<Self> {
        // SAFETY: an `OwnedFd` is open and always the same descriptor until it is dropped, and it is never lent out mutably.
        let fd = unsafe { AsyncFd::register_with_interest(fd, Interest::READABLE) }?;
        Ok(Self(fd))
    }

    /// Waits for the end of the process.
    pub async fn ended(&self) {
        // An error here means that the reactor is gone, and with it the agent.
        let _ = self.0.readable().await;
    }

    /// The handle itself.
    pub fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.get_ref().as_fd()
    }
}
