//! Processes by identity: pid, start time and boot together name one process, and a pidfd holds it.

use std::os::fd::OwnedFd;
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process_group, pidfd_open, pidfd_send_signal};
use serde::{Deserialize, Serialize};

/// Who a daemon is: contents of `controller.json` and `agent.json`, and a part of `manager.json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Identity {
    /// Process id.
    pub pid: u32,
    /// Field 22 of `/proc/PID/stat`.
    pub start_ticks: u64,
    /// `/proc/sys/kernel/random/boot_id`.
    pub boot_id: String,
    /// Program version.
    #[serde(default)]
    pub version: String,
}

impl Identity {
    /// Reads it from a file; `None` when there is none or it makes no sense.
    pub fn read(path: &Path) -> Option<Self> {
        serde_json::from_slice(&std::fs::read(path).ok()?).ok()
    }

    /// Of the process that has this pid now.
    pub fn of(pid: u32) -> Option<Self> {
        Some(Self {
            pid,
            start_ticks: start_ticks(pid)?,
            boot_id: boot_id()?,
            version: String::new(),
        })
    }

    /// A handle on the process if it still lives.
    pub fn open(&self) -> Option<Process> {
        if self.boot_id.trim() != boot_id()? {
            return None;
        }
        let process = Process::open(self.pid)?;
        // Read after the pidfd was opened: if the time is right, the pidfd is of the process that is meant.
        let same = start_ticks(self.pid)? == self.start_ticks;
        // A zombie has a pid and a start time, but nothing that could be stopped.
        (same && !process.ended(Duration::ZERO)).then_some(process)
    }
}

/// A live process. The handle never comes to mean another one.
#[derive(Debug)]
pub struct Process {
    pid: Pid,
    fd: OwnedFd,
}

impl Process {
    /// Whoever has this pid now.
    pub fn open(pid: u32) -> Option<Self> {
        let pid = Pid::from_raw(pid.try_into().ok()?)?;
        let fd = pidfd_open(pid, PidfdFlags::empty()).ok()?;
        Some(Self { pid, fd })
    }

    /// Its number.
    pub fn pid(&self) -> i32 {
        self.pid.as_raw_nonzero().get()
    }

    /// Sends a signal to it alone. One that has ended is no error.
    pub fn signal(&self, signal: Signal) {
        let _ = pidfd_send_signal(&self.fd, signal);
    }

    /// Sends a signal to its process group, if it leads one and still lives.
    pub fn signal_group(&self, signal: Signal) {
        let leads = rustix::process::getpgid(Some(self.pid)).is_ok_and(|group| group == self.pid);
        if leads && !self.ended(Duration::ZERO) {
            let _ = kill_process_group(self.pid, signal);
        } else {
            self.signal(signal);
        }
    }

    /// Waits for its end; true when it has ended. A zombie has ended.
    pub fn ended(&self, patience: Duration) -> bool {
        let end = Instant::now() + patience;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let timeout = Timespec {
                tv_sec: left.as_secs().try_into().unwrap_or(i64::MAX),
                tv_nsec: left.subsec_nanos().into(),
            };
            let mut fds = [PollFd::new(&self.fd, PollFlags::IN)];
            match poll(&mut fds, Some(&timeout)) {
                Ok(0) => return false,
                Ok(_) => return true,
                Err(rustix::io::Errno::INTR) => {}
                Err(_) => return false,
            }
        }
    }
}

/// Kills what is left of a process group whose leader has ended.
pub fn kill_rest_of_group(leader: i32) {
    if let Some(pid) = Pid::from_raw(leader) {
        let _ = kill_process_group(pid, Signal::KILL);
    }
}

fn boot_id() -> Option<String> {
    let text = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    Some(text.trim().to_owned())
}

fn start_ticks(pid: u32) -> Option<u64> {
    start_ticks_of(&std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?)
}

/// Field 22; field 2, the name, may contain blanks and brackets.
fn start_ticks_of(stat: &str) -> Option<u64> {
    let (_, after_name) = stat.rsplit_once(')')?;
    after_name.split_whitespace().nth(22 - 3)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_with_blanks_and_brackets_does_not_shift_the_fields() {
        let stat = "7 (a) b) (c) S 1 7 7 0 -1 4194560 1 0 0 0 0 0 0 0 20 0 1 0 4711 8 9";
        assert_eq!(start_ticks_of(stat), Some(4711));
        assert_eq!(start_ticks_of("7 (a) S 1"), None);
    }

    #[test]
    fn a_process_is_known_by_pid_start_time_and_boot() {
        let mut child = std::process::Command::new("sleep")
            .arg("60")
            .spawn()
            .unwrap();
        let right = Identity::of(child.id()).unwrap();
        let late = Identity {
            start_ticks: right.start_ticks + 1,
            ..right.clone()
        };
        let other_boot = Identity {
            boot_id: "x".to_owned(),
            ..right.clone()
        };
        assert!(late.open().is_none());
        assert!(other_boot.open().is_none());
        let process = right.open().unwrap();
        assert!(!process.ended(Duration::ZERO));
        process.signal(Signal::KILL);
        assert!(process.ended(Duration::from_secs(10)));
        assert!(right.open().is_none(), "a zombie counts as alive");
        child.wait().unwrap();
        assert!(right.open().is_none());
    }
}
