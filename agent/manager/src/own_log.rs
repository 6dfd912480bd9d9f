//! The files behind standard output and standard error, opened anew when somebody has moved them away.

use std::fs::{self, OpenOptions};
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::PathBuf;

use rustix::fs::FileType;
use rustix::stdio;

/// Where this process writes its own log to.
pub struct OwnLog {
    stdout: Option<PathBuf>,
    stderr: Option<PathBuf>,
}

impl OwnLog {
    /// As it was started. Terminals and pipes have no place.
    pub fn of_this_process() -> Self {
        Self {
            stdout: place(stdio::stdout()),
            stderr: place(stdio::stderr()),
        }
    }

    /// Goes on in the files that are at these places now, or makes them.
    pub fn reopen(&self) -> io::Result<()> {
        let open = |path| {
            let mut options = OpenOptions::new();
            options.append(true).create(true).mode(0o600).open(path)
        };
        if let Some(path) = &self.stdout {
            stdio::dup2_stdout(open(path)?)?;
        }
        if let Some(path) = &self.stderr {
            stdio::dup2_stderr(open(path)?)?;
        }
        Ok(())
    }
}

fn place(fd: impl std::os::fd::AsFd) -> Option<PathBuf> {
    let fd = fd.as_fd();
    let stat = rustix::fs::fstat(fd).ok()?;
    if FileType::from_raw_mode(stat.st_mode) != FileType::RegularFile {
        return None;
    }
    fs::read_link(format!("/proc/self/fd/{}", fd.as_raw_fd())).ok()
}
