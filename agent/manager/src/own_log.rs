//! The files behind standard output and standard error. They are exchanged here when they grow too long, as those of
//! components are, and opened anew when somebody else has moved them away and says so.

use std::fs::{self, OpenOptions};
use std::io;
use std::os::fd::{AsFd, AsRawFd};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use rustix::fs::{FileType, Stat};
use rustix::stdio;

use crate::log_file::{MAX_LENGTH, former};

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

    /// Renames a file that has grown too long to `NAME.1` and goes on in a new one; true when it did.
    pub fn rotate(&self) -> io::Result<bool> {
        let full = is_full(&self.stdout, stdio::stdout()) || is_full(&self.stderr, stdio::stderr());
        if full {
            self.reopen()?;
        }
        Ok(full)
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

/// Whether a file has grown too long; it is then moved away, if it is still at its place.
fn is_full(place: &Option<PathBuf>, fd: impl AsFd) -> bool {
    let Some(path) = place else {
        return false;
    };
    let full = |stat: &Stat| u64::try_from(stat.st_size).is_ok_and(|size| size >= MAX_LENGTH);
    let Some(stat) = rustix::fs::fstat(fd).ok().filter(full) else {
        return false;
    };
    !is_at(path, &stat) || fs::rename(path, former(path)).is_ok()
}

fn is_at(path: &Path, stat: &Stat) -> bool {
    rustix::fs::lstat(path)
        .is_ok_and(|there| (there.st_dev, there.st_ino) == (stat.st_dev, stat.st_ino))
}

fn place(fd: impl AsFd) -> Option<PathBuf> {
    let fd = fd.as_fd();
    let stat = rustix::fs::fstat(fd).ok()?;
    if FileType::from_raw_mode(stat.st_mode) != FileType::RegularFile {
        return None;
    }
    let path = fs::read_link(format!("/proc/self/fd/{}", fd.as_raw_fd())).ok()?;
    // One that was removed already has no place.
    is_at(&path, &stat).then_some(path)
}
