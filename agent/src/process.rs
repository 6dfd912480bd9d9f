//! Ending whole process groups.

use std::time::Duration;

use rts_host::process::group_lives;
use rustix::process::Signal;
use tokio::time::{Instant, sleep};

/// Sends a signal to a whole process group; an empty one is fine, a refusal is logged.
pub(crate) fn signal_group(pid: u32, signal: Signal) {
    if let Err(e) = rts_host::process::signal_group(pid, signal) {
        tracing::warn!(pid, "cannot send {signal:?} to the process group: {e}");
    }
}

/// Kills a process group and waits until it is gone; false when it still lives at the end of the time.
pub(crate) async fn kill_group(pid: u32, limit: Duration) -> bool {
    let end = Instant::now() + limit;
    let mut pause = Duration::from_millis(1);
    while lives(pid).await {
        signal_group(pid, Signal::KILL);
        if Instant::now() >= end {
            return false;
        }
        sleep(pause).await;
        pause = (pause * 2).min(Duration::from_millis(50));
    }
    true
}

/// A look at all processes, off the thread that serves.
async fn lives(pid: u32) -> bool {
    tokio::task::spawn_blocking(move || group_lives(pid))
        .await
        .unwrap_or(true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pidfd::PidFd;
    use rts_host::identity::start_ticks;
    use std::os::unix::process::CommandExt;
    use std::process::Command;

    #[tokio::test]
    async fn a_group_is_killed_with_its_grandchildren() {
        let mut child = Command::new("/bin/sh")
            .args(["-c", "sleep 1000 & wait"])
            .process_group(0)
            .spawn()
            .unwrap();
        let pid = child.id();
        let pidfd = PidFd::open(pid, start_ticks(pid)).unwrap();
        assert!(PidFd::open(pid, Some(1)).is_err());
        assert!(group_lives(pid));
        assert!(kill_group(pid, Duration::from_secs(5)).await);
        pidfd.ended().await;
        child.wait().unwrap();
        assert!(!group_lives(pid));
    }
}
