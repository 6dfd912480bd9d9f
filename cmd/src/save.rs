//! Writes results into files: whole, or not at all.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use crate::error::CliError;

/// Mode of a file that is nobody's secret; the umask takes its part.
const PUBLIC: u32 = 0o666;

/// Replaces a file as a whole. What is there and is no file (a device, a pipe) is written to.
pub fn save(path: &Path, text: &str) -> Result<(), CliError> {
    let written = match std::fs::metadata(path) {
        Ok(there) if !there.is_file() => write(path, text),
        // A link stays, and its file is replaced.
        Ok(_) => path
            .canonicalize()
            .and_then(|file| replace(&file, text.as_bytes(), PUBLIC)),
        Err(_) => replace(path, text.as_bytes(), PUBLIC),
    };
    written.map_err(|source| CliError::Write {
        path: path.to_owned(),
        source,
    })
}

/// Replaces a file, or a link, as a whole; the new one has this mode.
pub(crate) fn replace(path: &Path, bytes: &[u8], mode: u32) -> io::Result<()> {
    let new = beside(path).ok_or(io::ErrorKind::InvalidInput)?;
    let mut options = File::options();
    let created = options.write(true).create_new(true).mode(mode).open(&new);
    let written = created.and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()?;
        std::fs::rename(&new, path)
    });
    if written.is_err() {
        let _ = std::fs::remove_file(&new);
    }
    written
}

fn write(path: &Path, text: &str) -> io::Result<()> {
    let mut file = File::options().write(true).open(path)?;
    file.write_all(text.as_bytes())
}

/// A name beside the file that no other process uses.
fn beside(path: &Path) -> Option<PathBuf> {
    let mut name = OsString::from(".");
    name.push(path.file_name()?);
    name.push(format!(".{}.new", std::process::id()));
    Some(path.with_file_name(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.xml");
        save(&path, "a longer first text").unwrap();
        save(&path, "short").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "short");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn links_and_devices_stay_what_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        std::fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        save(&link, "new").unwrap();
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
        assert!(link.is_symlink());
        save(Path::new("/dev/null"), "x").unwrap();
        assert!(!Path::new("/dev/null").metadata().unwrap().is_file());
    }

    #[test]
    fn a_folder_or_a_way_to_nowhere_is_an_error_and_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        for path in [folder.path().to_owned(), folder.path().join("no/x")] {
            assert_eq!(save(&path, "x").unwrap_err().exit().code(), 2, "{path:?}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
