//! The three folders of an `RTSCTL_HOME`, and the mark that says that they are ours to remove.

use std::io;
use std::path::{Path, PathBuf};

use crate::files::{private_folder, replace};

/// What a home holds.
pub const FOLDERS: [&str; 3] = ["run", "state", "logs"];
/// Name of the mark in each of them.
pub const MARK: &str = ".rtsctl";

/// A home whose folders cannot be ours.
#[derive(Debug)]
pub enum ClaimError {
    /// The folder was there before, with somebody's files in it.
    Foreign(PathBuf),
    /// It cannot be made or marked.
    File(PathBuf, io::Error),
}

impl std::fmt::Display for ClaimError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Foreign(folder) => write!(
                f,
                "{} was there before and holds files of another program; set RTSCTL_HOME to a folder of its own",
                folder.display()
            ),
            Self::File(folder, _) => write!(f, "cannot make the folder {}", folder.display()),
        }
    }
}

impl std::error::Error for ClaimError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Foreign(_) => None,
            Self::File(_, error) => Some(error),
        }
    }
}

/// Makes the folders, mode 0700, and marks them. One that is there already must bear the mark or be empty.
pub fn claim(home: &Path) -> Result<(), ClaimError> {
    for name in FOLDERS {
        let folder = home.join(name);
        claim_one(&folder).map_err(|error| match error {
            Some(error) => ClaimError::File(folder, error),
            None => ClaimError::Foreign(folder),
        })?;
    }
    Ok(())
}

/// `None` as the error means that the folder is somebody else's.
fn claim_one(folder: &Path) -> Result<(), Option<io::Error>> {
    private_folder(folder)?;
    if is_claimed(folder) {
        return Ok(());
    }
    let foreign = std::fs::read_dir(folder)?
        .flatten()
        .any(|entry| !entry.file_name().to_string_lossy().starts_with(MARK));
    // Another of our programs may have marked it and gone on meanwhile.
    if foreign && !is_claimed(folder) {
        return Err(None);
    }
    Ok(replace(
        &folder.join(MARK),
        b"Made by rtsctl; `rtsctl down --purge` removes this folder.\n",
    )?)
}

/// True when the folder is ours.
pub fn is_claimed(folder: &Path) -> bool {
    folder.join(MARK).is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_and_empty_folders_are_taken_and_taken_again() {
        let home = tempfile::tempdir().unwrap();
        std::fs::create_dir(home.path().join("logs")).unwrap();
        claim(home.path()).unwrap();
        std::fs::write(home.path().join("run/controller.lock"), "").unwrap();
        claim(home.path()).unwrap();
        assert!(
            FOLDERS
                .iter()
                .all(|name| is_claimed(&home.path().join(name)))
        );
    }

    #[test]
    fn a_folder_with_files_of_others_is_refused() {
        let home = tempfile::tempdir().unwrap();
        std::fs::create_dir(home.path().join("logs")).unwrap();
        std::fs::write(home.path().join("logs/thesis.log"), "").unwrap();
        let error = claim(home.path()).unwrap_err();
        assert!(
            matches!(&error, ClaimError::Foreign(folder) if folder.ends_with("logs")),
            "{error}"
        );
        assert!(!is_claimed(&home.path().join("logs")));
    }
}
