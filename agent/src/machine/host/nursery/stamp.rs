//! Which version of the manager program lies on the disk.

use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// One version of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stamp {
    file: (u64, u64),
    modified: (i64, i64),
    size: u64,
}

impl Stamp {
    /// Of what lies at a path now; none when nothing does.
    pub fn of(path: &Path) -> Option<Self> {
        let file = std::fs::metadata(path).ok()?;
        Some(Self {
            file: (file.dev(), file.ino()),
            modified: (file.mtime(), file.mtime_nsec()),
            size: file.size(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_is_exchanged_or_written_over_is_another_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p");
        assert_eq!(Stamp::of(&path), None);
        std::fs::write(&path, "one").unwrap();
        let first = Stamp::of(&path);
        assert_eq!(first, Stamp::of(&path));
        std::fs::write(folder.path().join("q"), "one").unwrap();
        std::fs::rename(folder.path().join("q"), &path).unwrap();
        let second = Stamp::of(&path);
        assert!(second.is_some() && second != first);
        std::fs::write(&path, "longer").unwrap();
        assert_ne!(Stamp::of(&path), second);
    }
}
