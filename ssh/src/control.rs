//! The folder in which the socket of a session lies: private, locked for as long as the session lives, and removed with it. What a
//! process has left that was killed is removed by whoever makes the next.

use std::fs::{File, Metadata};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};
use tempfile::TempDir;

use crate::error::SshError;

/// Longest path of a Unix socket on Linux, and what `ssh` puts behind a path for a moment.
const MAX_SOCKET: usize = 107 - 18;
/// Beginning of the names in a folder of ours, where no node and no manager has a name with a dot before it, and in the one for
/// temporary files, which others use too.
const PREFIXES: [&str; 2] = [".ssh.", "rtsctl-ssh."];
/// Folders that are made until one stays.
const TRIES: u32 = 5;

/// The folder of one session.
#[derive(Debug)]
pub(crate) struct Folder {
    folder: TempDir,
    _lock: File,
}

impl Folder {
    /// Makes one below `above`, or below the folder for temporary files if paths would be too long.
    pub fn make(above: &Path) -> Result<Self, SshError> {
        let long = above.as_os_str().len() + "/.ssh.XXXXXX/s".len() > MAX_SOCKET;
        let temporary = std::env::temp_dir();
        let above = if long { temporary.as_path() } else { above };
        let prefix = PREFIXES[usize::from(above == temporary)];
        sweep(above, prefix);
        Self::new(above, prefix).map_err(|source| SshError::Folder {
            path: above.to_owned(),
            source,
        })
    }

    fn new(above: &Path, prefix: &str) -> io::Result<Self> {
        for _ in 0..TRIES {
            let folder = tempfile::Builder::new().prefix(prefix).tempdir_in(above)?;
            // Between these two somebody who sweeps may have found it.
            if let Some(lock) = locked(folder.path()) {
                let _lock = lock;
                return Ok(Self { folder, _lock });
            }
        }
        Err(io::Error::other("each that was made was removed at once"))
    }

    /// Where the socket is to be.
    pub fn socket(&self) -> PathBuf {
        self.folder.path().join("s")
    }
}

/// The lock of a folder that is there; none when somebody else has it.
fn locked(folder: &Path) -> Option<File> {
    let file = File::open(folder).ok()?;
    flock(&file, FlockOperation::NonBlockingLockExclusive).ok()?;
    let number = |file: io::Result<Metadata>| file.ok().map(|file| (file.dev(), file.ino()));
    let there = number(folder.symlink_metadata());
    (number(file.metadata()) == there && there.is_some()).then_some(file)
}

/// Removes the folders of this user whose sessions have ended without removing them.
fn sweep(above: &Path, prefix: &str) {
    let own = rustix::process::geteuid().as_raw();
    let entries = std::fs::read_dir(above).into_iter().flatten().flatten();
    for entry in entries {
        let name = entry.file_name();
        let is_ours = |file: Metadata| file.is_dir() && file.uid() == own;
        if name.as_encoded_bytes().starts_with(prefix.as_bytes())
            && entry.metadata().is_ok_and(is_ours)
            && let Some(_lock) = locked(&entry.path())
        {
            // It is only litter: the next one tries again.
            let _ = std::fs::remove_dir_all(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_process_has_left_goes_and_a_session_that_lives_stays() {
        let temp = tempfile::tempdir().unwrap();
        let above = temp.path();
        let names = || {
            let entries = above.read_dir().unwrap();
            let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
            names.collect::<Vec<_>>()
        };
        // A process that is killed drops its lock, and removes nothing.
        let Folder { folder, _lock } = Folder::make(above).unwrap();
        std::fs::write(folder.path().join("s"), "").unwrap();
        let left = folder.keep();
        drop(_lock);
        // The folder of a node may have such a name.
        std::fs::create_dir(above.join("ssh.arm")).unwrap();
        let lives = Folder::make(above).unwrap();
        assert!(!left.exists());
        let other = Folder::make(above).unwrap();
        assert_ne!(lives.socket(), other.socket());
        assert_eq!(names().len(), 3, "{:?}", names());
        drop((lives, other));
        assert_eq!(names(), ["ssh.arm"]);
    }

    #[test]
    fn a_folder_too_deep_for_a_socket_gives_way_to_the_one_for_temporary_files() {
        let deep = Path::new("/").join("x".repeat(MAX_SOCKET));
        let folder = Folder::make(&deep).unwrap();
        let socket = folder.socket();
        let name = socket.parent().unwrap().strip_prefix(std::env::temp_dir());
        assert!(name.unwrap().to_str().unwrap().starts_with("rtsctl-ssh."));
    }
}
