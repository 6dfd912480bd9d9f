//! Folders of `RTSCTL_HOME`, the lock that makes this the only controller in it, and the file that says who runs.

use std::fs::{DirBuilder, File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};
use serde::Serialize;

/// A home that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum HomeError {
    /// Another controller runs.
    #[error(
        "another controller already runs in {} ({holder}); stop it with `rtsctl down`, or set RTSCTL_HOME to another folder", home.display()
    )]
    Held {
        /// The home.
        home: PathBuf,
        /// Who, as far as known.
        holder: String,
    },
    /// A folder or file failed.
    #[error("cannot {what} {}", path.display())]
    Io {
        /// What was being tried.
        what: &'static str,
        /// Where.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
}

/// A home that is ours until this is dropped.
#[derive(Debug)]
pub struct Home {
    root: PathBuf,
    /// Its flock ends with the descriptor.
    _lock: File,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Process {
    pid: u32,
    start_ticks: u64,
    boot_id: String,
    version: &'static str,
}

impl Home {
    /// Makes the folders (mode 0700) and takes the lock.
    pub fn take(root: &Path) -> Result<Self, HomeError> {
        for folder in [
            root.to_owned(),
            root.join("run"),
            root.join("state"),
            root.join("logs"),
        ] {
            DirBuilder::new()
                .recursive(true)
                .mode(0o700)
                .create(&folder)
                .map_err(|source| failed("make the folder", &folder, source))?;
        }
        let path = root.join("run/controller.lock");
        let lock = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            .open(&path)
            .map_err(|source| failed("open", &path, source))?;
        match flock(&lock, FlockOperation::NonBlockingLockExclusive) {
            Ok(()) => Ok(Self {
                root: root.to_owned(),
                _lock: lock,
            }),
            Err(rustix::io::Errno::WOULDBLOCK) => Err(HomeError::Held {
                home: root.to_owned(),
                holder: holder(&root.join("run/controller.json")),
            }),
            Err(e) => Err(failed("lock", &path, e.into())),
        }
    }

    /// The controller's socket.
    pub fn socket(&self) -> PathBuf {
        self.root.join("run/controller.sock")
    }

    /// The store's file.
    pub fn store(&self) -> PathBuf {
        self.root.join("state/controller.redb")
    }

    /// Says who runs here. Replaced as a whole, so that nobody reads half of it.
    pub fn announce(&self) -> Result<(), HomeError> {
        let path = self.json();
        let new = path.with_extension("json.new");
        let text = serde_json::to_vec(&Process {
            pid: std::process::id(),
            start_ticks: start_ticks(),
            boot_id: boot_id(),
            version: env!("CARGO_PKG_VERSION"),
        })
        .map_err(|e| failed("write", &path, e.into()))?;
        let write = || {
            let mut file = OpenOptions::new()
                .write(true)
                .create(true)
                .truncate(true)
                .mode(0o600)
                .open(&new)?;
            file.write_all(&text)?;
            std::fs::rename(&new, &path)
        };
        write().map_err(|source| failed("write", &path, source))
    }

    /// Takes the socket and the file away. The lock goes with this value.
    pub fn leave(&self) {
        for path in [self.json(), self.socket()] {
            if let Err(e) = std::fs::remove_file(&path)
                && e.kind() != io::ErrorKind::NotFound
            {
                tracing::warn!(path = %path.display(), error = %e, "cannot be removed");
            }
        }
    }

    fn json(&self) -> PathBuf {
        self.root.join("run/controller.json")
    }
}

fn failed(what: &'static str, path: &Path, source: io::Error) -> HomeError {
    HomeError::Io {
        what,
        path: path.to_owned(),
        source,
    }
}

fn holder(json: &Path) -> String {
    let text = std::fs::read(json).unwrap_or_default();
    let value: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
    match value.get("pid").and_then(serde_json::Value::as_u64) {
        Some(pid) => format!("pid {pid}"),
        None => "it is starting".to_owned(),
    }
}

/// Field 22 of `/proc/self/stat`; 0 when there is no such file.
fn start_ticks() -> u64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The second field is the program's name in parentheses and may contain blanks.
    let rest = stat.rsplit_once(')').map_or("", |(_, rest)| rest);
    let field = rest.split_whitespace().nth(19);
    field.and_then(|field| field.parse().ok()).unwrap_or(0)
}

fn boot_id() -> String {
    let id = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    id.trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_home_has_one_controller() {
        let folder = tempfile::tempdir().unwrap();
        let home = Home::take(folder.path()).unwrap();
        home.announce().unwrap();
        let error = Home::take(folder.path()).unwrap_err().to_string();
        let error = error
            .replace(&folder.path().display().to_string(), "HOME")
            .replace(&std::process::id().to_string(), "PID");
        insta::assert_snapshot!(error, @"another controller already runs in HOME (pid PID); stop it with `rtsctl down`, or set RTSCTL_HOME to another folder");
        home.leave();
        drop(home);
        Home::take(folder.path()).unwrap();
    }

    #[test]
    fn the_start_of_this_process_is_known() {
        assert!(start_ticks() > 0);
    }
}
