//! The daemons of a stack, seen and ended from outside.

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use crate::{Stack, alive, kill, processes_of, program, programs};

/// Sends a signal. A process that is gone is no error.
pub fn signal(pid: u32, signal: Signal) {
    if let Some(pid) = i32::try_from(pid).ok().and_then(Pid::from_raw) {
        let _ = kill_process(pid, signal);
    }
}

/// SIGKILL, and waits for the end, at most 5 s.
#[track_caller]
pub fn kill_9(pid: u32) {
    kill(pid);
    let deadline = Instant::now() + Duration::from_secs(5);
    while alive(pid) {
        assert!(Instant::now() < deadline, "{pid} outlives SIGKILL");
        std::thread::sleep(Duration::from_millis(5));
    }
}

impl Stack {
    /// Live processes of this stack with this program name (`rts-agent`).
    pub fn daemons(&self, program: &str) -> Vec<u32> {
        let named = |pid: &u32| {
            std::fs::read_to_string(format!("/proc/{pid}/comm"))
                .is_ok_and(|comm| comm.trim() == program)
        };
        processes_of(&self.home())
            .into_iter()
            .filter(named)
            .collect()
    }

    /// SIGKILL for every process of this stack with this program name. Gives how many there were.
    #[track_caller]
    pub fn kill_9(&self, program: &str) -> usize {
        let pids = self.daemons(program);
        pids.iter().copied().for_each(kill_9);
        pids.len()
    }

    /// Starts the agent of this home by itself.
    pub fn agent_alone(&self) -> Child {
        let mut command = Command::new(program("rts-agent"));
        command
            .arg("--home")
            .arg(self.home())
            .env("RTSCTL_MODULE_PATH", programs())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        command.spawn().expect("rts-agent starts")
    }
}
