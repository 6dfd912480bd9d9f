//! The files of a log: the one that is written, and the one before it, `<path>.1`.

use std::fs::{File, Metadata};
use std::io;
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::{Path, PathBuf};

/// Bytes that are read at once.
const BLOCK: usize = 64 * 1024;

/// Device and inode of a file. A file that is open keeps its own.
pub(super) type Identity = (u64, u64);

/// A part of a file, read from its start to its end.
#[derive(Debug)]
pub(super) struct Part {
    file: File,
    pub identity: Identity,
    pub at: u64,
    pub end: u64,
    /// It begins within a line.
    pub torn: bool,
}

impl Part {
    /// The whole file as long as it is now; none when it is not there.
    pub fn open(path: &Path) -> io::Result<Option<Self>> {
        let file = match File::open(path) {
            Ok(file) => file,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(e),
        };
        let about = file.metadata()?;
        Ok(Some(Self {
            file,
            identity: identity(&about),
            at: 0,
            end: about.len(),
            torn: false,
        }))
    }

    /// The next bytes; none at its end.
    pub fn read(&mut self) -> io::Result<Vec<u8>> {
        let most = (self.end - self.at).min(BLOCK as u64) as usize;
        let mut block = vec![0; most];
        let length = self.file.read_at(&mut block, self.at)?;
        block.truncate(length);
        self.at += length as u64;
        Ok(block)
    }

    /// Leaves out all but the last bytes.
    pub fn shorten(&mut self, most: u64) {
        let from = self.end.saturating_sub(most);
        if from > self.at {
            // The byte before tells whether a line begins there.
            self.at = from - 1;
            self.torn = true;
        }
    }

    /// Goes on with what was added. True when the file was cut and is read from its start again.
    pub fn grow(&mut self) -> io::Result<bool> {
        self.end = self.file.metadata()?.len();
        let cut = self.end < self.at;
        if cut {
            self.at = 0;
        }
        Ok(cut)
    }
}

/// The files that a log has now, the older one first, each as long as it is.
pub(super) fn open(path: &Path) -> io::Result<Vec<Part>> {
    let new = Part::open(path)?;
    let old = Part::open(&former(path))?;
    // Renamed between the two looks: it was opened twice.
    let old = old.filter(|old| new.as_ref().is_none_or(|new| new.identity != old.identity));
    Ok(old.into_iter().chain(new).collect())
}

/// `<path>.1`.
pub(super) fn former(path: &Path) -> PathBuf {
    let mut former = path.as_os_str().to_owned();
    former.push(".1");
    former.into()
}

/// Which file lies at a path now.
pub(super) fn at(path: &Path) -> io::Result<Option<Identity>> {
    match path.metadata() {
        Ok(about) => Ok(Some(identity(&about))),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(e),
    }
}

fn identity(about: &Metadata) -> Identity {
    (about.dev(), about.ino())
}
