//! The launcher of `rts-manager` processes.
//!
//! Without a `pre_exec` hook, so that the standard library can use posix_spawn: fork of this process costs 16 ms more.

use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::os::fd::OwnedFd;
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::net::UnixStream;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{self, Command, Stdio};

use rts_host::process::signal_group;
use rustix::process::Signal;
use tokio::net;

use super::pidfd::PidFd;
use crate::launch::{Exit, ExitFuture, LaunchError, Start};

/// Variables that a manager inherits, besides all that start with `RTS`.
const KEPT: [&str; 5] = ["PATH", "HOME", "LANG", "RUST_BACKTRACE", "LD_LIBRARY_PATH"];

/// What a manager program gets of this process's environment.
pub(super) fn environment() -> impl Iterator<Item = (OsString, OsString)> {
    std::env::vars_os().filter(|(name, _)| {
        name.to_str()
            .is_some_and(|name| KEPT.contains(&name) || name.starts_with("RTS"))
    })
}

/// Starts manager processes.
#[derive(Debug)]
pub(super) struct Launcher {
    program: PathBuf,
}

/// A process that was just started.
pub(super) struct Child {
    /// Its id, also its process group's.
    pub pid: u32,
    /// The first control connection.
    pub control: net::UnixStream,
    /// Its end.
    pub exit: ExitFuture,
}

impl Launcher {
    /// Starts this program.
    pub fn new(program: PathBuf) -> Self {
        Self { program }
    }

    fn command(&self, start: &Start, control: UnixStream, log: File, log2: File) -> Command {
        let mut command = Command::new(&self.program);
        command
            .arg("--dir")
            .arg(&start.folder)
            .args(["--name", &start.key.name]);
        if let Some(system) = &start.key.system {
            command.args(["--system-name", &system.name, "--system-uid", &system.uid]);
        }
        command
            .args(["--incarnation", &start.incarnation])
            .env_clear()
            .envs(environment())
            .current_dir(&start.folder)
            .process_group(0)
            .stdin(Stdio::from(OwnedFd::from(control)))
            .stdout(log)
            .stderr(log2);
        command
    }

    /// Starts one and returns at once.
    pub fn launch(&self, start: &Start) -> Result<Child, LaunchError> {
        let failed = |what: &Path| {
            let what = what.display().to_string();
            move |source| LaunchError { what, source }
        };
        let log = open_log(&start.log).map_err(failed(&start.log))?;
        let log2 = log.try_clone().map_err(failed(&start.log))?;
        let (ours, theirs) = UnixStream::pair().map_err(failed(&self.program))?;
        ours.set_nonblocking(true).map_err(failed(&self.program))?;
        let control = net::UnixStream::from_std(ours).map_err(failed(&self.program))?;
        let mut child = self
            .command(start, theirs, log, log2)
            .spawn()
            .map_err(failed(&self.program))?;
        let pidfd = match PidFd::open(child.id(), None) {
            Ok(pidfd) => pidfd,
            Err(e) => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(failed(&self.program)(e));
            }
        };
        Ok(Child {
            pid: child.id(),
            control,
            exit: Box::pin(end(child, pidfd)),
        })
    }
}

/// Waits for the end of a child, kills what is left of its group, and reaps it. In this order: until it is reaped, its
/// number cannot be given to another process.
async fn end(mut child: process::Child, pidfd: PidFd) -> Exit {
    pidfd.ended().await;
    if let Err(e) = signal_group(child.id(), Signal::KILL) {
        tracing::warn!(pid = child.id(), "cannot kill its process group: {e}");
    }
    match child.wait() {
        Ok(status) => match (status.code(), status.signal()) {
            (Some(code), _) => Exit::Code(code),
            (None, Some(signal)) => Exit::Signal(signal),
            (None, None) => Exit::Unknown,
        },
        Err(e) => {
            tracing::warn!(pid = child.id(), "cannot reap: {e}");
            Exit::Unknown
        }
    }
}

fn open_log(path: &Path) -> std::io::Result<File> {
    OpenOptions::new()
        .append(true)
        .create(true)
        .mode(0o600)
        .open(path)
}
