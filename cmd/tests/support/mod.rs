//! A local stack of one test, and what `rtsctl` says with it.

#![allow(dead_code, reason = "each test program uses a part")]
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::path::PathBuf;
use std::process::{Command, Stdio};

use rustix::process::{Pid, Signal, kill_process};

/// A local stack in a folder of its own, ended with its value.
pub struct Stack {
    /// Working folder of the commands.
    pub folder: tempfile::TempDir,
}

impl Stack {
    /// Starts it.
    pub fn up() -> Self {
        let folder = tempfile::Builder::new().prefix("rts").tempdir_in("/tmp");
        let stack = Self {
            folder: folder.unwrap(),
        };
        assert_eq!(stack.run(&["up"]).0, 0);
        stack
    }

    /// Its `RTSCTL_HOME`.
    pub fn home(&self) -> PathBuf {
        self.folder.path().join("h")
    }

    /// `rtsctl` with these arguments, in the stack's folder.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rtsctl"));
        command
            .args(args)
            .env_clear()
            .env("RTSCTL_HOME", self.home())
            .current_dir(self.folder.path())
            .stdin(Stdio::null());
        command
    }

    /// Runs; gives exit code, stdout and stderr.
    pub fn run(&self, args: &[&str]) -> (i32, String, String) {
        let output = self.command(args).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (
            output.status.code().unwrap(),
            text(&output.stdout),
            text(&output.stderr),
        )
    }

    /// Kills the agent of the node local.
    pub fn kill_agent(&self) {
        let text = std::fs::read(self.home().join("run/local/agent.json")).unwrap();
        let identity: serde_json::Value = serde_json::from_slice(&text).unwrap();
        let pid = i32::try_from(identity["pid"].as_i64().unwrap()).unwrap();
        kill_process(Pid::from_raw(pid).unwrap(), Signal::KILL).unwrap();
    }
}

impl Drop for Stack {
    fn drop(&mut self) {
        let _ = self.command(&["down", "--purge", "--yes"]).output();
    }
}
