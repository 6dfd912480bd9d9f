//! Live processes, held by pidfd, and their groups.

use std::io;
use std::os::fd::OwnedFd;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process_group, pidfd_open, pidfd_send_signal};

use crate::identity::{Identity, boot_id, start_ticks, stat_fields};

/// Time between two looks at a group.
const PAUSE: Duration = Duration::from_millis(2);

/// A live process. The handle never comes to mean another one.
#[derive(Debug)]
pub struct Process {
    pid: Pid,
    fd: OwnedFd,
}

impl Process {
    /// Whoever has this pid now.
    pub fn open(pid: u32) -> Option<Self> {
        let pid = number(pid).ok()?;
        let fd = pidfd_open(pid, PidfdFlags::empty()).ok()?;
        Some(Self { pid, fd })
    }

    /// The very process that is meant, if it still lives.
    pub fn identified(identity: &Identity) -> Option<Self> {
        let process = Self::open(identity.pid)?;
        // Compared after the pidfd was opened: if it is right now, the pidfd is of the process that is meant. A zombie
        // has a pid and a start time, but nothing that could be stopped.
        (identity.is_now() && !process.ended(Duration::ZERO)).then_some(process)
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

/// Sends a signal to a whole process group; an empty one is fine.
pub fn signal_group(leader: u32, signal: Signal) -> io::Result<()> {
    match kill_process_group(number(leader)?, signal) {
        Ok(()) | Err(rustix::io::Errno::SRCH) => Ok(()),
        Err(e) => Err(e.into()),
    }
}

/// True while a process of the group lives. Zombies do not count: their parent may never reap them.
pub fn group_lives(leader: u32) -> bool {
    let Ok(group) = number(leader) else {
        return false;
    };
    if rustix::process::test_kill_process_group(group) == Err(rustix::io::Errno::SRCH) {
        return false;
    }
    let Ok(processes) = std::fs::read_dir("/proc") else {
        return true;
    };
    processes.flatten().any(|entry| {
        let name = entry.file_name();
        let is_process = name
            .to_str()
            .is_some_and(|n| n.bytes().all(|b| b.is_ascii_digit()));
        is_process
            && std::fs::read_to_string(entry.path().join("stat"))
                .is_ok_and(|s| in_group(&s, leader))
    })
}

/// True when there is no such group any more, not even a zombie in it. Told without a look at any process.
pub fn group_is_gone(leader: u32) -> bool {
    let is_gone =
        |group| rustix::process::test_kill_process_group(group) == Err(rustix::io::Errno::SRCH);
    number(leader).is_ok_and(is_gone)
}

/// True while somebody lives in the group that a process leads or led. A number of another boot names nobody.
pub fn group_of_lives(leader: &Identity) -> bool {
    boot_id().is_some_and(|boot| boot == leader.boot_id.trim())
        // While the group has members, its number is given to no new process.
        && start_ticks(leader.pid).is_none_or(|ticks| ticks == leader.start_ticks)
        && group_lives(leader.pid)
}

/// Sends a signal to the group that a process leads or led; one in which nobody lives any more is fine.
pub fn signal_group_of(leader: &Identity, signal: Signal) -> io::Result<()> {
    if group_of_lives(leader) {
        signal_group(leader.pid, signal)
    } else {
        Ok(())
    }
}

/// Kills the group that a process leads or led, until nobody is left; false when somebody is at the end of the time.
pub fn end_group_of(leader: &Identity, limit: Duration) -> bool {
    let end = Instant::now() + limit;
    while group_of_lives(leader) {
        if Instant::now() >= end {
            return false;
        }
        // One that may not be killed is there at the end of the time.
        let _ = signal_group(leader.pid, Signal::KILL);
        std::thread::sleep(PAUSE);
    }
    true
}

fn in_group(stat: &str, group: u32) -> bool {
    let Some(mut fields) = stat_fields(stat) else {
        return false;
    };
    let state = fields.next();
    !matches!(state, Some("Z" | "X")) && fields.nth(1) == Some(group.to_string().as_str())
}

/// A process number that may be given to the kernel: 0 is one's own group, 1 and -1 are everybody.
pub fn number(pid: u32) -> io::Result<Pid> {
    let usable = i32::try_from(pid)
        .ok()
        .filter(|pid| *pid > 1)
        .and_then(Pid::from_raw);
    usable.ok_or_else(|| {
        io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("pid {pid} is not usable"),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::process::CommandExt;
    use std::process::Command;

    #[test]
    fn a_zombie_and_another_group_do_not_count() {
        assert!(in_group("42 (a) b) S 7 42 42 0", 42));
        assert!(!in_group("42 (a) b) S 7 42 42 0", 7));
        assert!(!in_group("42 (x) Z 7 42 42 0", 42));
        assert!(!in_group("rubbish", 42));
    }

    #[test]
    fn dangerous_numbers_are_refused() {
        for pid in [0, 1, u32::MAX] {
            assert!(number(pid).is_err());
            assert!(!group_lives(pid));
            assert!(signal_group(pid, Signal::TERM).is_err());
        }
    }

    #[test]
    fn a_group_is_ended_after_its_leader_but_not_one_of_another_boot() {
        let script = "trap '' TERM; sleep 1000 & read go";
        let mut leader = Command::new("/bin/sh");
        leader.args(["-c", script]).process_group(0);
        let mut leader = leader.stdin(std::process::Stdio::piped()).spawn().unwrap();
        let identity = Identity::of(leader.id()).unwrap();
        drop(leader.stdin.take());
        leader.wait().unwrap();
        let before = Identity {
            boot_id: "before".to_owned(),
            ..identity.clone()
        };
        assert!(end_group_of(&before, Duration::ZERO));
        assert!(!end_group_of(&identity, Duration::ZERO), "a child is left");
        assert!(end_group_of(&identity, Duration::from_secs(10)));
        assert!(!group_lives(identity.pid));
    }

    #[test]
    fn a_process_is_held_by_its_identity() {
        let mut child = Command::new("sleep")
            .arg("60")
            .process_group(0)
            .spawn()
            .unwrap();
        let right = Identity::of(child.id()).unwrap();
        let late = Identity {
            start_ticks: right.start_ticks + 1,
            ..right.clone()
        };
        assert!(Process::identified(&late).is_none());
        let process = Process::identified(&right).unwrap();
        assert!(group_lives(child.id()));
        process.signal_group(Signal::KILL);
        assert!(process.ended(Duration::from_secs(10)));
        assert!(Process::identified(&right).is_none(), "a zombie is nobody");
        assert!(!group_lives(child.id()), "a zombie is nobody");
        child.wait().unwrap();
    }
}
