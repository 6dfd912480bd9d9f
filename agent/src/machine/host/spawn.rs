//! Spawning programs.
//!
//! Without a `pre_exec` hook, so that the standard library can use posix_spawn: fork of this process costs 16 ms more.

use std::ffi::OsString;
use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;

use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;

use super::child::Child;
use super::pidfd::PidFd;
use crate::launch::Start;

/// Variables that a manager inherits, besides all that start with `RTS`.
const KEPT: [&str; 5] = ["PATH", "HOME", "LANG", "RUST_BACKTRACE", "LD_LIBRARY_PATH"];

/// What a manager program gets of this process's environment.
pub(super) fn environment() -> impl Iterator<Item = (OsString, OsString)> {
    std::env::vars_os().filter(|(name, _)| {
        name.to_str()
            .is_some_and(|name| KEPT.contains(&name) || name.starts_with("RTS"))
    })
}

/// Spawns managers, as many at once as there are processors: each waits for its exec, off the thread that serves.
#[derive(Debug, Clone)]
pub(super) struct Spawner {
    program: Arc<Path>,
    turns: Arc<Semaphore>,
}

impl Spawner {
    /// Spawns this program.
    pub fn new(program: &Path) -> Self {
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        Self {
            program: program.into(),
            turns: Arc::new(Semaphore::new(processors)),
        }
    }

    /// Spawns a manager.
    pub async fn spawn(&self, start: &Start, log: File) -> io::Result<Child> {
        let turn = self.turns.clone().acquire_owned().await;
        let (program, start) = (self.program.clone(), start.clone());
        let spawned = spawn_blocking(move || {
            let spawned = spawn(&program, &start, log);
            drop(turn);
            spawned
        });
        let (mut child, control) = spawned.await.map_err(io::Error::other).flatten()?;
        let pid = child.id();
        match PidFd::open(pid, None) {
            Ok(pidfd) => Ok(Child {
                pid,
                control,
                pidfd: Arc::new(pidfd),
            }),
            Err(e) => {
                let _ = child.kill();
                let _ = child.wait();
                Err(e)
            }
        }
    }
}

fn spawn(
    program: &Path,
    start: &Start,
    log: File,
) -> io::Result<(std::process::Child, UnixStream)> {
    let (ours, theirs) = UnixStream::pair()?;
    ours.set_nonblocking(true)?;
    let mut command = Command::new(program);
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
        .stdin(Stdio::from(OwnedFd::from(theirs)))
        .stdout(log.try_clone()?)
        .stderr(log);
    Ok((command.spawn()?, ours))
}
