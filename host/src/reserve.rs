//! A little space that is kept for the day on which the disk is full: what must be written then, so that something can be taken
//! down and space comes back, finds room.

use std::io;
use std::path::{Path, PathBuf};

use crate::files::write_private;

/// Bytes that are kept: some small files, in the blocks of any file system.
const KEPT: usize = 64 * 1024;

/// The space, a file.
#[derive(Debug, Clone)]
pub struct Reserve(PathBuf);

impl Reserve {
    /// In a folder. Nothing is made yet.
    pub fn within(folder: &Path) -> Self {
        Self(folder.join("reserve"))
    }

    /// Makes the file where it is not there, or not whole. Without it a full disk is only harder to get out of: that is told in
    /// the log.
    pub fn keep(&self) {
        let length = std::fs::metadata(&self.0).map(|file| file.len());
        if length.is_ok_and(|length| length >= KEPT as u64) {
            return;
        }
        if let Err(e) = write_private(&self.0, &[0; KEPT]) {
            tracing::warn!(
                "cannot keep space for a full disk in {}: {e}",
                self.0.display()
            );
            // Half of it helps nobody, and takes what is left.
            let _ = std::fs::remove_file(&self.0);
        }
    }

    /// Writes something; if the disk is full, once more with this space given back.
    pub fn write<T>(&self, write: impl Fn() -> io::Result<T>) -> io::Result<T> {
        match write() {
            Err(e) if is_full(&e) && std::fs::remove_file(&self.0).is_ok() => {
                tracing::warn!(
                    "the disk is full: the space that was kept in {} is given back",
                    self.0.display()
                );
                write()
            }
            done => done,
        }
    }
}

/// No space, or not for this account.
pub fn is_full(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn a_full_disk_gets_what_was_kept_once() {
        let folder = tempfile::tempdir().unwrap();
        let reserve = Reserve::within(folder.path());
        let path = folder.path().join("reserve");
        let tries = Cell::new(0);
        // There is room as soon as the reserve is gone.
        let write = || {
            tries.set(tries.get() + 1);
            match path.exists() || tries.get() < 2 {
                true => Err(io::Error::from(io::ErrorKind::StorageFull)),
                false => Ok("written"),
            }
        };
        let nothing_kept = reserve.write(write).unwrap_err();
        assert!(is_full(&nothing_kept) && tries.get() == 1);
        reserve.keep();
        assert_eq!(std::fs::metadata(&path).unwrap().len(), KEPT as u64);
        assert_eq!(reserve.write(write).unwrap(), "written");
        let other = reserve.write(|| Err::<(), _>(io::Error::other("x")));
        assert_eq!(other.unwrap_err().to_string(), "x");
        std::fs::write(&path, "cut off").unwrap();
        reserve.keep();
        assert_eq!(std::fs::metadata(&path).unwrap().len(), KEPT as u64);
    }
}
