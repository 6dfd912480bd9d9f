//! The lock on the home folder itself, so that ten rtsctl at once start one controller; and the daemons' own locks.

use std::fs::File;
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::time::{Duration, Instant};

use rustix::fs::{FlockOperation, flock};

use super::LocalError;
use super::home::{Home, make_private};

/// Longest wait for another rtsctl.
const PATIENCE: Duration = Duration::from_secs(30);
/// Time between two tries.
const PAUSE: Duration = Duration::from_millis(10);

/// The home is ours until this is dropped. The kernel drops it when the process ends, however it ends.
#[derive(Debug)]
pub struct HomeLock {
    _folder: File,
}

impl HomeLock {
    /// Takes the lock, making the home when it is not there.
    pub fn take(home: &Home) -> Result<Self, LocalError> {
        Self::take_within(home, PATIENCE, true)?.ok_or_else(|| LocalError::Locked {
            home: home.path().to_owned(),
            seconds: PATIENCE.as_secs(),
        })
    }

    /// Takes the lock of a home that is there; `None` when there is none.
    pub fn take_existing(home: &Home) -> Result<Option<Self>, LocalError> {
        match Self::take_within(home, PATIENCE, false) {
            Ok(Some(lock)) => Ok(Some(lock)),
            Ok(None) => Err(LocalError::Locked {
                home: home.path().to_owned(),
                seconds: PATIENCE.as_secs(),
            }),
            Err(LocalError::File { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                Ok(None)
            }
            Err(e) => Err(e),
        }
    }

    fn take_within(
        home: &Home,
        patience: Duration,
        make: bool,
    ) -> Result<Option<Self>, LocalError> {
        let end = Instant::now() + patience;
        loop {
            if make {
                make_private(home.path())?;
            }
            let folder = match File::open(home.path()) {
                // Another rtsctl removed it since it was made.
                Err(e) if make && e.kind() == io::ErrorKind::NotFound && Instant::now() < end => {
                    continue;
                }
                other => other.map_err(LocalError::file("open", home.path()))?,
            };
            while let Err(e) = flock(&folder, FlockOperation::NonBlockingLockExclusive) {
                if e != rustix::io::Errno::WOULDBLOCK && e != rustix::io::Errno::INTR {
                    return Err(LocalError::file("lock", home.path())(e.into()));
                }
                if Instant::now() >= end {
                    return Ok(None);
                }
                std::thread::sleep(PAUSE);
            }
            // A `down --purge` may have removed the folder between open and lock: then this lock guards nothing.
            if same_file(&folder, home.path()) {
                return Ok(Some(Self { _folder: folder }));
            }
        }
    }
}

fn same_file(open: &File, path: &Path) -> bool {
    match (open.metadata(), std::fs::metadata(path)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

/// True when a live process holds an exclusive lock on a file.
pub fn is_held(path: &Path) -> Result<bool, LocalError> {
    let file = match File::open(path) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(false),
        Err(e) => return Err(LocalError::file("open", path)(e)),
    };
    match flock(&file, FlockOperation::NonBlockingLockShared) {
        Ok(()) => Ok(false),
        Err(rustix::io::Errno::WOULDBLOCK) => Ok(true),
        Err(e) => Err(LocalError::file("test the lock", path)(e.into())),
    }
}

/// Makes the folders that the daemons write to, for the user alone.
pub fn make_folders(home: &Home, node: &str) -> Result<(), LocalError> {
    rts_host::home::claim(home.path())?;
    make_private(&home.logs().join(node))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn home(folder: &Path) -> Home {
        Home::settle(Some(folder.join("home"))).unwrap()
    }

    #[test]
    fn only_one_holds_the_home_and_the_next_gets_it_after() {
        let temp = tempfile::tempdir().unwrap();
        let home = home(temp.path());
        let first = HomeLock::take(&home).unwrap();
        let none = HomeLock::take_within(&home, Duration::ZERO, true).unwrap();
        assert!(none.is_none());
        drop(first);
        HomeLock::take(&home).unwrap();
    }

    #[test]
    fn a_lock_on_a_folder_that_was_removed_is_not_taken_for_a_lock_on_its_successor() {
        let temp = tempfile::tempdir().unwrap();
        let home = home(temp.path());
        let _first = HomeLock::take(&home).unwrap();
        std::fs::remove_dir(home.path()).unwrap();
        let _second = HomeLock::take(&home).unwrap();
        let third = HomeLock::take_within(&home, Duration::ZERO, true).unwrap();
        assert!(third.is_none());
    }

    #[test]
    fn a_home_that_is_not_there_is_not_made_to_lock_it() {
        let temp = tempfile::tempdir().unwrap();
        let home = home(temp.path());
        assert!(HomeLock::take_existing(&home).unwrap().is_none());
        assert!(!home.path().exists());
    }

    #[test]
    fn a_lock_is_held_only_while_its_file_is_open() {
        let temp = tempfile::tempdir().unwrap();
        let path = temp.path().join("lock");
        assert!(!is_held(&path).unwrap());
        let file = File::create(&path).unwrap();
        assert!(!is_held(&path).unwrap());
        flock(&file, FlockOperation::LockExclusive).unwrap();
        assert!(is_held(&path).unwrap());
        drop(file);
        assert!(!is_held(&path).unwrap());
    }
}
