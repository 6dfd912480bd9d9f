//! The log file of a component, which changes its file when it grows too long or is moved away.
//!
//! A line is one `write(2)` to a file that was opened for appending, so lines of several threads never mix.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use jiff::Timestamp;

use crate::log::{Level, line};
use crate::sync::lock;

/// A file of this length is renamed to `NAME.1` and a new one begun.
pub const MAX_LENGTH: u64 = 16 * 1024 * 1024;
/// The path is looked at this often.
const LOOK: Duration = Duration::from_secs(1);

/// The log of a component.
#[derive(Debug)]
pub struct LogFile {
    path: PathBuf,
    max_length: u64,
    open: Mutex<Open>,
}

#[derive(Debug)]
struct Open {
    file: File,
    looked: Instant,
    written: u64,
}

impl LogFile {
    /// Opens it for appending, or makes it with mode 0600.
    pub fn open(path: &Path) -> io::Result<Self> {
        Self::with_max_length(path, MAX_LENGTH)
    }

    fn with_max_length(path: &Path, max_length: u64) -> io::Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            max_length,
            open: Mutex::new(Open::at(path)?),
        })
    }

    /// Appends a line. A full disk must not stop a robot: errors are ignored.
    pub fn write(&self, level: Level, message: &str) {
        let text = line(Timestamp::now(), level, message);
        let mut open = lock(&self.open);
        if open.looked.elapsed() >= LOOK {
            self.look(&mut open);
        }
        if open.written + text.len() as u64 > self.max_length {
            self.rotate(&mut open);
        }
        open.written += text.len() as u64;
        let _ = open.file.write(text.as_bytes());
    }

    /// Goes on in a new file when ours was moved away or removed.
    fn look(&self, open: &mut Open) {
        open.looked = Instant::now();
        let number = |file: std::fs::Metadata| (file.dev(), file.ino());
        let ours = open.file.metadata().ok().map(number);
        let there = std::fs::symlink_metadata(&self.path).ok().map(number);
        if ours != there
            && let Ok(new) = Open::at(&self.path)
        {
            *open = new;
        }
    }

    fn rotate(&self, open: &mut Open) {
        // Begun anew even when it fails, so that a folder without room is not asked for each line.
        open.written = 0;
        if std::fs::rename(&self.path, former(&self.path)).is_ok()
            && let Ok(new) = Open::at(&self.path)
        {
            *open = new;
        }
    }
}

/// Where a file goes that is full.
pub fn former(path: &Path) -> PathBuf {
    let mut former = path.to_owned().into_os_string();
    former.push(".1");
    former.into()
}

impl Open {
    fn at(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new()
            .append(true)
            .create(true)
            .mode(0o600)
            .open(path)?;
        Ok(Self {
            written: file.metadata()?.len(),
            file,
            looked: Instant::now(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What stands behind the times.
    fn words(path: &Path) -> Vec<String> {
        let text = std::fs::read_to_string(path).unwrap();
        let word = |line: &str| line.split_once(' ').unwrap().1.to_owned();
        text.lines().map(word).collect()
    }

    #[test]
    fn lines_are_appended_to_a_private_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.log");
        LogFile::open(&path).unwrap().write(Level::Info, "one");
        LogFile::open(&path).unwrap().write(Level::Warn, "two");
        assert_eq!(words(&path), ["INFO one", "WARN two"]);
        assert_eq!(path.metadata().unwrap().permissions().mode() & 0o777, 0o600);
    }

    #[test]
    fn a_file_that_is_full_becomes_the_former_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.log");
        let log = LogFile::with_max_length(&path, 90).unwrap();
        for number in 1..=5 {
            log.write(Level::Info, &format!("line {number}"));
        }
        // A line has 37 bytes, so two fit.
        assert_eq!(words(&path), ["INFO line 5"]);
        let former = folder.path().join("c.log.1");
        assert_eq!(words(&former), ["INFO line 3", "INFO line 4"]);
        // Its length is known again after a restart.
        let again = LogFile::with_max_length(&path, 90).unwrap();
        again.write(Level::Info, "line 6");
        again.write(Level::Info, "line 7");
        assert_eq!(words(&path), ["INFO line 7"]);
    }

    #[test]
    fn a_file_that_was_moved_away_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.log");
        let log = LogFile::open(&path).unwrap();
        log.write(Level::Info, "one");
        std::fs::rename(&path, folder.path().join("old")).unwrap();
        log.look(&mut lock(&log.open));
        log.write(Level::Info, "two");
        assert_eq!(words(&path), ["INFO two"]);
        log.look(&mut lock(&log.open));
        log.write(Level::Info, "three");
        assert_eq!(words(&path), ["INFO two", "INFO three"]);
    }
}
