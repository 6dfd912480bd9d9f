//! Writes results into files: whole, or not at all.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, fchown};
use std::path::{Path, PathBuf};

use crate::error::CliError;

/// Mode of a file that is nobody's secret; the umask takes its part.
const PUBLIC: u32 = 0o666;

/// Mode of a file until it has the mode of the one that it replaces.
const PRIVATE: u32 = 0o600;

/// Replaces a file as a whole. What is there and is no file (a device, a pipe) is written to.
pub fn save(path: &Path, text: &str) -> Result<(), CliError> {
    let written = match std::fs::metadata(path) {
        Ok(there) if !there.is_file() => write(path, text),
        // A link stays, and its file is replaced.
        Ok(_) => path
            .canonicalize()
            .and_then(|file| replace(&file, text.as_bytes(), PUBLIC)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            replace(path, text.as_bytes(), PUBLIC)
        }
        Err(error) => Err(error),
    };
    written.map_err(|source| CliError::Write {
        path: path.to_owned(),
        source,
    })
}

/// Replaces the text of a file that is there, as a whole: it keeps its mode and its owner, and a link to it stays one.
pub fn rewrite(path: &Path, text: &str) -> Result<(), CliError> {
    let written = path.canonicalize().and_then(|file| {
        let old = std::fs::metadata(&file)?;
        if !old.is_file() {
            let reason = "it is no regular file";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
        }
        // What may not be written to is not replaced either, though its folder would allow it.
        File::options().append(true).open(&file)?;
        replace_as(&file, text.as_bytes(), PRIVATE, |new| {
            // Only root can give files away; for others the owner is the same.
            let _ = fchown(new, Some(old.uid()), Some(old.gid()));
            new.set_permissions(old.permissions())
        })
    });
    written.map_err(|source| CliError::Write {
        path: path.to_owned(),
        source,
    })
}

/// Replaces a file, or a link, as a whole; the new one has this mode.
pub(crate) fn replace(path: &Path, bytes: &[u8], mode: u32) -> io::Result<()> {
    replace_as(path, bytes, mode, |_| Ok(()))
}

fn replace_as(
    path: &Path,
    bytes: &[u8],
    mode: u32,
    finish: impl FnOnce(&File) -> io::Result<()>,
) -> io::Result<()> {
    let new = beside(path).ok_or(io::ErrorKind::InvalidInput)?;
    let mut options = File::options();
    let created = options.write(true).create_new(true).mode(mode).open(&new);
    let written = created.and_then(|mut file| {
        file.write_all(bytes)?;
        finish(&file)?;
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
    fn a_file_that_is_rewritten_keeps_its_mode_and_its_links() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        std::fs::write(&file, "old").unwrap();
        let mode = std::fs::Permissions::from_mode(0o646);
        std::fs::set_permissions(&file, mode.clone()).unwrap();
        std::os::unix::fs::symlink("file", &link).unwrap();
        rewrite(&link, "new").unwrap();
        assert!(link.is_symlink());
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
        assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o646);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
        for no_file in [folder.path().to_owned(), folder.path().join("none")] {
            assert!(rewrite(&no_file, "x").is_err());
        }
    }

    #[test]
    fn links_in_a_circle_are_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a"), folder.path().join("b"));
        std::os::unix::fs::symlink(&b, &a).unwrap();
        std::os::unix::fs::symlink(&a, &b).unwrap();
        assert!(save(&a, "x").is_err() && rewrite(&a, "x").is_err());
        assert!(a.is_symlink() && b.is_symlink());
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
