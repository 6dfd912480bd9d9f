//! Files and their names, as the kernel has them and as they would be after a loss of power. What is written is durable
//! once the file was synced, and what was done to names once their folder was: until then a loss of power leaves of the
//! former any part, and of the latter what was done first.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use crate::seed::Stream;

/// A file system.
#[derive(Debug, Default)]
pub(super) struct Files {
    next: u64,
    files: BTreeMap<u64, File>,
    names: Names,
    durable: Names,
    /// What was done to names since they were made durable, in order.
    done: Vec<Change>,
}

type Names = BTreeMap<PathBuf, u64>;

#[derive(Debug, Default)]
struct File {
    bytes: Vec<u8>,
    /// What was synced last; none when nothing ever was.
    durable: Option<Vec<u8>>,
    /// It was emptied since then, not only written over.
    emptied: bool,
}

/// Something done to a name.
#[derive(Debug, Clone)]
enum Change {
    Make(PathBuf, u64),
    Rename(PathBuf, PathBuf),
}

impl Change {
    fn folder(&self) -> Option<&Path> {
        match self {
            Self::Make(path, _) | Self::Rename(path, _) => path.parent(),
        }
    }

    fn apply(&self, names: &mut Names) {
        match self {
            Self::Make(path, file) => {
                names.insert(path.clone(), *file);
            }
            Self::Rename(from, to) => {
                if let Some(file) = names.remove(from) {
                    names.insert(to.clone(), file);
                }
            }
        }
    }
}

fn missing(path: &Path) -> io::Error {
    let message = format!("{} does not exist", path.display());
    io::Error::new(io::ErrorKind::NotFound, message)
}

impl Files {
    /// What a file holds.
    pub fn read(&self, path: &Path) -> Option<&[u8]> {
        let file = self.files.get(self.names.get(path)?)?;
        Some(&file.bytes)
    }

    /// Makes a file, or empties it, and writes these bytes.
    pub fn write(&mut self, path: &Path, bytes: &[u8]) {
        let file = match self.names.get(path) {
            Some(file) => *file,
            None => self.make(path),
        };
        let file = self.files.entry(file).or_default();
        file.bytes = bytes.to_vec();
        file.emptied = true;
    }

    /// Writes over the begin of a file that is there.
    pub fn write_over(&mut self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let file = self.names.get(path).ok_or_else(|| missing(path))?;
        let file = self.files.entry(*file).or_default();
        let behind = file.bytes.get(bytes.len()..).unwrap_or_default();
        file.bytes = [bytes, behind].concat();
        Ok(())
    }

    fn make(&mut self, path: &Path) -> u64 {
        self.next += 1;
        self.change(Change::Make(path.to_owned(), self.next));
        self.next
    }

    fn change(&mut self, change: Change) {
        change.apply(&mut self.names);
        self.done.push(change);
    }

    /// Makes the contents of a file durable.
    pub fn sync(&mut self, path: &Path) -> io::Result<()> {
        let file = self.names.get(path).ok_or_else(|| missing(path))?;
        if let Some(file) = self.files.get_mut(file) {
            file.durable = Some(file.bytes.clone());
            file.emptied = false;
        }
        Ok(())
    }

    /// Gives a file another name.
    pub fn rename(&mut self, from: &Path, to: &Path) -> io::Result<()> {
        if !self.names.contains_key(from) {
            return Err(missing(from));
        }
        self.change(Change::Rename(from.to_owned(), to.to_owned()));
        Ok(())
    }

    /// Makes the names in a folder durable.
    pub fn sync_folder(&mut self, folder: &Path) {
        let durable = &mut self.durable;
        self.done.retain(|change| {
            let here = change.folder() == Some(folder);
            if here {
                change.apply(durable);
            }
            !here
        });
        self.forget();
    }

    /// Files without a name, now or after a loss of power, are no more.
    fn forget(&mut self) {
        let made = |change: &Change| match change {
            Change::Make(_, file) => Some(*file),
            Change::Rename(..) => None,
        };
        let mut kept: Vec<u64> = self.names.values().copied().collect();
        kept.extend(self.durable.values());
        kept.extend(self.done.iter().filter_map(made));
        self.files.retain(|file, _| kept.contains(file));
    }

    /// Loses what was not made durable, or some of it.
    pub fn lose_power(&mut self, chance: &Stream) {
        // In each folder, what was done first is done.
        let mut folders: BTreeMap<PathBuf, Vec<Change>> = BTreeMap::new();
        for change in std::mem::take(&mut self.done) {
            let folder = change.folder().unwrap_or(Path::new("")).to_owned();
            folders.entry(folder).or_default().push(change);
        }
        for changes in folders.values() {
            let done = chance.between(0, changes.len() as u64);
            for change in changes.iter().take(done as usize) {
                change.apply(&mut self.durable);
            }
        }
        for file in self.files.values_mut() {
            file.lose_power(chance);
        }
        self.names = self.durable.clone();
        self.forget();
    }
}

impl File {
    fn lose_power(&mut self, chance: &Stream) {
        if self.durable.as_ref() != Some(&self.bytes) {
            match &self.durable {
                // It was not even emptied.
                Some(durable) if chance.chance(0.25) => self.bytes.clone_from(durable),
                // Some of its blocks are new, some are old.
                Some(durable) if !self.emptied => {
                    let from = chance.between(0, self.bytes.len() as u64) as usize;
                    let to = chance.between(from as u64, self.bytes.len() as u64) as usize;
                    let mut mixed = durable.clone();
                    if mixed.len() < to {
                        mixed.resize(to, 0);
                    }
                    mixed[from..to].copy_from_slice(&self.bytes[from..to]);
                    self.bytes = mixed;
                }
                _ => {
                    let kept = chance.between(0, self.bytes.len() as u64);
                    self.bytes.truncate(kept as usize);
                }
            }
        }
        self.durable = Some(self.bytes.clone());
        self.emptied = false;
    }
}
