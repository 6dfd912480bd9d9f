//! A process that was just started, however that was done: it is this process's child.

use std::os::unix::net::UnixStream;
use std::sync::Arc;

use rts_host::process::signal_group;
use rustix::process::{Signal, WaitId, WaitIdOptions, waitid};

use super::pidfd::PidFd;
use crate::launch::{Exit, ExitFuture};

/// A child with its first connection.
#[derive(Debug)]
pub(super) struct Child {
    /// Its id, also its process group's.
    pub pid: u32,
    /// The first control connection; does not block.
    pub control: UnixStream,
    /// Its handle.
    pub pidfd: Arc<PidFd>,
}

impl Child {
    /// Its end. Whoever drops it unfinished leaves a zombie.
    pub fn exit(&self) -> ExitFuture {
        Box::pin(end(self.pid, self.pidfd.clone()))
    }

    /// Lets a copy go that nobody wants: it ends with its connection, and is reaped.
    pub fn let_go(self) {
        reap(self.pid, self.pidfd);
    }
}

/// Reaps a child as soon as it has ended.
pub(super) fn reap(pid: u32, pidfd: Arc<PidFd>) {
    tokio::spawn(end(pid, pidfd));
}

/// Waits for the end of a child, kills what is left of its group, and reaps it. In this order: until it is reaped, its
/// number cannot be given to another process.
pub(super) async fn end(pid: u32, pidfd: Arc<PidFd>) -> Exit {
    pidfd.ended().await;
    if let Err(e) = signal_group(pid, Signal::KILL) {
        tracing::warn!(pid, "cannot kill its process group: {e}");
    }
    let status = rustix::io::retry_on_intr(|| {
        waitid(
            WaitId::PidFd(pidfd.as_fd()),
            WaitIdOptions::EXITED | WaitIdOptions::NOHANG,
        )
    });
    match status {
        Ok(Some(status)) => match (status.exit_status(), status.terminating_signal()) {
            (Some(code), _) => Exit::Code(code),
            (None, Some(signal)) => Exit::Signal(signal),
            (None, None) => Exit::Unknown,
        },
        Ok(None) => Exit::Unknown,
        Err(e) => {
            tracing::warn!(pid, "cannot reap: {e}");
            Exit::Unknown
        }
    }
}
