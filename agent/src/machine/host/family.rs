//! Ending whole process groups and control groups.

use std::time::Duration;

use futures_util::future::BoxFuture;
use rts_host::cgroup::{Cgroup, Version};
use rts_host::identity::Identity;
use rts_host::process::{Process, group_is_gone, group_of_lives, signal_group_of};
use rts_host::usage::usage;
use rts_plan::observed::Usage;
use rustix::process::{self, Pid, getpgid};
use tokio::task::spawn_blocking;
use tokio::time::{Instant, sleep};

use crate::machine::{self, Signal};

/// A process that leads its group, and all that it started. Without a control group, one that has left the process
/// group is not found.
#[derive(Debug, Clone)]
pub(super) struct Family {
    /// Never its number alone: that may be given to somebody else once it was reaped.
    pub leader: Identity,
    pub cgroup: Option<Cgroup>,
}

impl Family {
    /// That of a process.
    pub fn new(leader: Identity, cgroup: Option<Cgroup>) -> Self {
        Self { leader, cgroup }
    }

    /// That of a child that was not reaped yet.
    pub fn of_child(pid: u32, cgroup: Option<Cgroup>) -> Self {
        // Who has no `/proc` knows no process, and signals none by a mere number.
        let leader = Identity::of(pid).unwrap_or(Identity {
            pid,
            start_ticks: 0,
            boot_id: String::new(),
            version: String::new(),
        });
        Self::new(leader, cgroup)
    }

    fn signal_now(&self, signal: process::Signal) {
        let pid = self.leader.pid;
        if let Err(e) = signal_group_of(&self.leader, signal) {
            tracing::warn!(pid, "cannot send {signal:?} to the process group: {e}");
        }
        let Some(cgroup) = &self.cgroup else { return };
        if signal == process::Signal::KILL {
            return cgroup.kill();
        }
        for process in cgroup.processes() {
            let group = getpgid(Pid::from_raw(process.pid()));
            let had_it = |group: Pid| u32::try_from(group.as_raw_nonzero().get()) == Ok(pid);
            if !group.is_ok_and(had_it) {
                process.signal(signal);
            }
        }
    }

    async fn end_within(&self, limit: Duration) -> bool {
        if self.is_gone() {
            self.free().await;
            return true;
        }
        let end = Instant::now() + limit;
        let mut pause = Duration::from_millis(1);
        while self.lives().await {
            machine::Family::signal(self, Signal::Kill).await;
            if Instant::now() >= end {
                return false;
            }
            sleep(pause).await;
            pause = (pause * 2).min(Duration::from_millis(50));
        }
        self.free().await;
        true
    }

    /// True when all are gone, as far as a moment tells: most often its end was orderly.
    fn is_gone(&self) -> bool {
        let empty = |group: &Cgroup| group.version() == Version::V2 && !group.is_populated();
        group_is_gone(self.leader.pid) && self.cgroup.as_ref().is_none_or(empty)
    }

    /// Removes the control group, in which nobody lives any more.
    async fn free(&self) {
        let Some(cgroup) = self.cgroup.clone() else {
            return;
        };
        // Another thread is asked only where the kernel has not let go of it yet.
        if cgroup.remove_now().is_err() {
            let _ = spawn_blocking(move || remove(&cgroup)).await;
        }
    }

    /// A look at all processes, off the thread that serves.
    async fn lives(&self) -> bool {
        let family = self.clone();
        let lives = move || {
            group_of_lives(&family.leader)
                || family.cgroup.as_ref().is_some_and(Cgroup::is_populated)
        };
        spawn_blocking(lives).await.unwrap_or(true)
    }
}

impl machine::Family for Family {
    fn pid(&self) -> u32 {
        self.leader.pid
    }

    fn has_ended(&self) -> bool {
        Process::identified(&self.leader).is_none()
    }

    fn usage(&self) -> Option<Usage> {
        let used = usage(&self.leader)?;
        Some(Usage {
            cpu_ms: used.cpu.as_millis().try_into().unwrap_or(u64::MAX),
            memory: used.memory,
        })
    }

    fn signal(&self, signal: Signal) -> BoxFuture<'_, ()> {
        let family = self.clone();
        let signal = match signal {
            Signal::Term => process::Signal::TERM,
            Signal::Cont => process::Signal::CONT,
            Signal::Kill => process::Signal::KILL,
        };
        Box::pin(async move {
            // It cannot panic.
            let _ = spawn_blocking(move || family.signal_now(signal)).await;
        })
    }

    fn end(&self, limit: Duration) -> BoxFuture<'_, bool> {
        Box::pin(self.end_within(limit))
    }
}

/// Removes a control group in which nobody lives; what stands against it is logged.
pub(super) fn remove(cgroup: &Cgroup) {
    if let Err(e) = cgroup.remove() {
        tracing::warn!("cannot remove {}: {e}", cgroup.path().display());
    }
}

#[cfg(test)]
mod tests {
    use super::super::pidfd::PidFd;
    use super::*;
    use crate::machine::Family as _;
    use rts_host::identity::start_ticks;
    use rts_host::process::group_lives;
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
        // Somebody who had the number before.
        let mut other = Family::of_child(pid, None);
        other.leader.start_ticks -= 1;
        assert!(other.has_ended());
        assert!(other.end(Duration::ZERO).await);
        other.signal(Signal::Kill).await;
        sleep(Duration::from_millis(50)).await;
        assert!(group_lives(pid));
        let family = Family::of_child(pid, None);
        assert!(!family.has_ended());
        assert!(family.end(Duration::from_secs(5)).await);
        pidfd.ended().await;
        assert!(family.has_ended());
        child.wait().unwrap();
        assert!(!group_lives(pid));
    }
}
