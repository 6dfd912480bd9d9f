//! Processes by number: who they are, when they end, and how to end their whole group.

use std::fs;
use std::io;
use std::time::Duration;

use rustix::process::{Pid, Signal};
use serde::{Deserialize, Serialize};
use tokio::time::{Instant, sleep};

/// What names one process for good: a pid alone is used again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct ProcessFile {
    /// Process id.
    pub pid: u32,
    /// Field 22 of `/proc/PID/stat`.
    pub start_ticks: u64,
    /// `/proc/sys/kernel/random/boot_id`.
    pub boot_id: String,
    /// Program version.
    pub version: String,
}

impl ProcessFile {
    /// This process.
    pub fn own() -> io::Result<Self> {
        let pid = std::process::id();
        let start_ticks = start_ticks(pid).ok_or_else(|| io::Error::other("cannot read /proc"))?;
        Ok(Self {
            pid,
            start_ticks,
            boot_id: boot_id()?,
            version: env!("CARGO_PKG_VERSION").to_owned(),
        })
    }
}

/// Id of the present boot.
pub(crate) fn boot_id() -> io::Result<String> {
    Ok(fs::read_to_string("/proc/sys/kernel/random/boot_id")?
        .trim()
        .to_owned())
}

/// When a process started, in clock ticks since boot; none when it does not exist.
pub(crate) fn start_ticks(pid: u32) -> Option<u64> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    stat_fields(&stat)?.nth(19)?.parse().ok()
}

/// Fields of a stat file from the third (state) on; the second, the name, may hold blanks and parentheses.
fn stat_fields(stat: &str) -> Option<impl Iterator<Item = &str>> {
    Some(stat.rsplit_once(") ")?.1.split(' '))
}

/// Sends a signal to a whole process group; an empty one is fine.
pub(crate) fn signal_group(pid: u32, signal: Signal) {
    if let Ok(group) = number(pid)
        && let Err(e) = rustix::process::kill_process_group(group, signal)
        && e != rustix::io::Errno::SRCH
    {
        tracing::warn!(pid, "cannot send {signal:?} to the process group: {e}");
    }
}

/// True while a process of the group lives. Zombies do not count: their parent may never reap them.
pub(crate) fn group_lives(pid: u32) -> bool {
    let Ok(group) = number(pid) else { return false };
    if rustix::process::test_kill_process_group(group) == Err(rustix::io::Errno::SRCH) {
        return false;
    }
    let Ok(processes) = fs::read_dir("/proc") else {
        return true;
    };
    processes.flatten().any(|entry| {
        let is_process = entry
            .file_name()
            .to_str()
            .is_some_and(|n| n.bytes().all(|b| b.is_ascii_digit()));
        is_process && fs::read_to_string(entry.path().join("stat")).is_ok_and(|s| in_group(&s, pid))
    })
}

fn in_group(stat: &str, group: u32) -> bool {
    let Some(mut fields) = stat_fields(stat) else {
        return false;
    };
    let state = fields.next();
    !matches!(state, Some("Z" | "X")) && fields.nth(1) == Some(group.to_string().as_str())
}

/// Kills a process group and waits until it is gone; false when it still lives at the end of the time.
pub(crate) async fn kill_group(pid: u32, limit: Duration) -> bool {
    let end = Instant::now() + limit;
    let mut pause = Duration::from_millis(1);
    while group_lives(pid) {
        signal_group(pid, Signal::KILL);
        if Instant::now() >= end {
            return false;
        }
        sleep(pause).await;
        pause = (pause * 2).min(Duration::from_millis(50));
    }
    true
}

/// A process number that may be given to the kernel.
pub(crate) fn number(pid: u32) -> io::Result<Pid> {
    i32::try_from(pid)
        .ok()
        // 0 is our own group, 1 is everybody.
        .filter(|pid| *pid > 1)
        .and_then(Pid::from_raw)
        .ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::InvalidInput,
                format!("pid {pid} is not usable"),
            )
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pidfd::PidFd;
    use std::os::unix::process::CommandExt;
    use std::process::Command;

    #[test]
    fn a_name_with_parentheses_does_not_hide_the_fields() {
        let stat = "42 (a) b) S 7 42 42 0";
        assert!(in_group(stat, 42));
        assert!(!in_group(stat, 7));
        assert!(!in_group("42 (x) Z 7 42 42 0", 42));
        assert!(!in_group("rubbish", 42));
    }

    #[test]
    fn dangerous_numbers_are_refused() {
        for pid in [0, 1, u32::MAX] {
            assert!(number(pid).is_err());
            assert!(!group_lives(pid));
        }
    }

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
