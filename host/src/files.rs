//! Folders of mode 0700, files of mode 0600, locks, and replacing a file so that nobody reads half of it.

use std::fs::{DirBuilder, File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};

/// Makes a folder and its parents, mode 0700. One that is there already keeps its mode.
pub fn private_folder(path: &Path) -> io::Result<()> {
    DirBuilder::new().recursive(true).mode(0o700).create(path)
}

/// Makes a folder and its parents, mode 0700. When it returns, they outlive a power cut.
pub fn durable_folder(path: &Path) -> io::Result<()> {
    let new: Vec<&Path> = path.ancestors().take_while(|p| !p.exists()).collect();
    private_folder(path)?;
    for folder in new {
        // A folder is named by its parent.
        File::open(folder_of(folder))?.sync_all()?;
    }
    Ok(())
}

/// An exclusive lock on a file; it ends with this value, or with the process.
#[derive(Debug)]
pub struct Lock {
    file: File,
}

/// Tries for a lock whose file is replaced again and again.
const TRIES: u32 = 5;

impl Lock {
    /// True while the file at this path is the one that is locked: neither gone nor replaced.
    pub fn is_at(&self, path: &Path) -> bool {
        let number = |file: std::fs::Metadata| (file.dev(), file.ino());
        let own = self.file.metadata().map(number);
        let there = std::fs::metadata(path).map(number);
        own.is_ok_and(|own| there.is_ok_and(|there| own == there))
    }
}

/// Takes the lock without waiting; `None` when somebody else has it, or replaces its file all the time. The file is
/// made if need be, and is at its path when it is locked.
pub fn lock(path: &Path) -> io::Result<Option<Lock>> {
    for _ in 0..TRIES {
        match try_lock(path)? {
            Some(lock) if !lock.is_at(path) => {}
            taken => return Ok(taken),
        }
    }
    Ok(None)
}

fn try_lock(path: &Path) -> io::Result<Option<Lock>> {
    let mut options = OpenOptions::new();
    let file = options
        .write(true)
        .create(true)
        .truncate(false)
        .mode(0o600)
        .open(path)?;
    match flock(&file, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => Ok(Some(Lock { file })),
        Err(rustix::io::Errno::WOULDBLOCK) => Ok(None),
        Err(e) => Err(e.into()),
    }
}

/// Replaces a file as a whole, mode 0600. After a power cut the old or the new one is there, perhaps empty.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let new = beside(path)?;
    write_private(&new, bytes)?;
    std::fs::rename(&new, path)
}

/// Replaces a file as a whole, mode 0600. When it returns, the new one outlives a power cut.
pub fn replace_durably(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let new = beside(path)?;
    write_private(&new, bytes)?.sync_all()?;
    std::fs::rename(&new, path)?;
    File::open(folder_of(path))?.sync_all()
}

/// The folder that names a file; a bare name's is the working folder.
pub(crate) fn folder_of(path: &Path) -> &Path {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
    parent.unwrap_or(Path::new("."))
}

/// A name that only one process writes: the callers hold the lock of the folder.
pub(crate) fn beside(path: &Path) -> io::Result<PathBuf> {
    let name = path
        .file_name()
        .ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
    let mut new = name.to_owned();
    new.push(".new");
    Ok(path.with_file_name(new))
}

pub(crate) fn write_private(path: &Path, bytes: &[u8]) -> io::Result<File> {
    let mut options = OpenOptions::new();
    let mut file = options
        .write(true)
        .create(true)
        .truncate(true)
        .mode(0o600)
        .open(path)?;
    file.write_all(bytes)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.json");
        replace_durably(&path, b"a longer first text").unwrap();
        replace(&path, b"short").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"short");
        let mode = std::fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_lock_knows_whether_its_file_is_still_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.lock");
        let held = lock(&path).unwrap().unwrap();
        assert!(held.is_at(&path) && lock(&path).unwrap().is_none());
        std::fs::remove_file(&path).unwrap();
        assert!(!held.is_at(&path));
        let other = lock(&path).unwrap().unwrap();
        assert!(other.is_at(&path) && !held.is_at(&path));
    }

    #[test]
    fn a_bare_name_lies_in_the_working_folder() {
        let folder = |path: &str| folder_of(Path::new(path)).to_owned();
        assert_eq!(folder("backup.json"), Path::new("."));
        assert_eq!(folder("a/backup.json"), Path::new("a"));
        assert_eq!(folder("/backup.json"), Path::new("/"));
        let name = format!("bare-name-{}.json", std::process::id());
        let path = Path::new(&name);
        replace_durably(path, b"x").unwrap();
        assert_eq!(std::fs::read(path).unwrap(), b"x");
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn a_folder_is_made_with_its_parents_and_may_be_there_already() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b");
        durable_folder(&path).unwrap();
        durable_folder(&path).unwrap();
        let mode = std::fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o700);
    }

    #[test]
    fn a_lock_has_one_holder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        let held = lock(&path).unwrap();
        assert!(held.is_some());
        assert!(lock(&path).unwrap().is_none());
        drop(held);
        assert!(lock(&path).unwrap().is_some());
    }
}
