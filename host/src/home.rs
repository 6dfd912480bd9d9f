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

/// Makes the folders, mode 0700, and marks them. One that is there already must bear the mark or be empty. `run` may
/// also hold what our programs make anew there when somebody has removed it, and nothing else.
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
    let is_run = folder.file_name().is_some_and(|name| name == FOLDERS[0]);
    let foreign = entries(folder)?
        .iter()
        .any(|(name, entry)| !(name.starts_with(MARK) || is_run && is_of_run(name, entry)));
    // Another of our programs may have marked it and gone on meanwhile.
    if foreign && !is_claimed(folder) {
        return Err(None);
    }
    Ok(replace(
        &folder.join(MARK),
        b"Made by rtsctl; `rtsctl down --purge` removes this folder.\n",
    )?)
}

/// Names and paths of what a folder holds.
fn entries(folder: &Path) -> io::Result<Vec<(String, PathBuf)>> {
    let entries = std::fs::read_dir(folder)?.flatten();
    let named = entries.map(|e| (e.file_name().to_string_lossy().into_owned(), e.path()));
    Ok(named.collect())
}

/// True for what a controller makes in `run`, and for the folder of a node with nothing else than what its agent and
/// managers make there.
fn is_of_run(name: &str, path: &Path) -> bool {
    is_of_daemon("controller", name)
        || is_folder(path)
            && entries(path).is_ok_and(|entries| {
                let mut entries = entries.iter();
                entries.all(|(name, path)| {
                    is_of_daemon("agent", name) || is_manager(name) && is_folder(path)
                })
            })
}

/// `agent.sock`, `agent.lock`, `agent.json`, and what these are called while they are written.
fn is_of_daemon(daemon: &str, name: &str) -> bool {
    let rest = name.strip_prefix(daemon);
    let rest = rest.map(|rest| rest.strip_suffix(".new").unwrap_or(rest));
    matches!(rest, Some(".sock" | ".lock" | ".json"))
}

/// The run folder of a manager: 8 hexadecimal digits.
fn is_manager(name: &str) -> bool {
    name.len() == 8 && name.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
}

/// True for a folder, not for a link to one.
fn is_folder(path: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|file| file.is_dir())
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
    fn a_run_folder_that_our_programs_made_anew_is_taken_and_no_other() {
        let home = tempfile::tempdir().unwrap();
        let run = home.path().join("run");
        std::fs::create_dir_all(run.join("local/0123abcd")).unwrap();
        for name in ["controller.sock", "local/agent.lock", "local/agent.json"] {
            std::fs::write(run.join(name), "").unwrap();
        }
        std::fs::write(run.join("local/0123abcd/manager.json"), "").unwrap();
        claim(home.path()).unwrap();
        assert!(is_claimed(&run));
        for foreign in [
            "thesis.tex",
            "local/thesis.tex",
            "local/0123abce",
            "controller.tex",
        ] {
            std::fs::remove_file(run.join(MARK)).unwrap();
            std::fs::write(run.join(foreign), "").unwrap();
            assert!(claim(home.path()).is_err(), "{foreign}");
            std::fs::remove_file(run.join(foreign)).unwrap();
            claim(home.path()).unwrap();
        }
        // Another folder of the home holds nothing of that kind.
        let logs = home.path().join("logs");
        std::fs::remove_file(logs.join(MARK)).unwrap();
        std::fs::create_dir(logs.join("local")).unwrap();
        assert!(claim(home.path()).is_err());
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
