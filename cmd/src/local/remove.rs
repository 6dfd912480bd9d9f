//! Removes the folders of a local stack that was stopped, and nothing that is not its own.

use std::path::{Path, PathBuf};

use rts_manager_api::files::{CONTROL_SOCKET, MANAGER_JSON};

use super::LocalError;
use super::home::Home;

/// Files that only our programs write into `run/`.
const RUN_MARKS: [&str; 8] = [
    "controller.lock",
    "controller.json",
    "controller.sock",
    "agent.lock",
    "agent.json",
    "agent.sock",
    MANAGER_JSON,
    CONTROL_SOCKET,
];

/// Removes `run/`; with `purge` also `state/`, `logs/` and the home if nothing else is in it. Gives what it left alone.
pub fn remove(home: &Home, purge: bool) -> Result<Vec<PathBuf>, LocalError> {
    let mut alone = Vec::new();
    let own = |folder: PathBuf, marks: &[&str], alone: &mut Vec<PathBuf>| {
        if !folder.is_dir() {
            return Ok(());
        }
        if !is_ours(&folder, marks)? {
            alone.push(folder);
            return Ok(());
        }
        std::fs::remove_dir_all(&folder).map_err(LocalError::file("remove", folder))
    };
    own(home.run(), &RUN_MARKS, &mut alone)?;
    if purge {
        own(
            home.state(),
            &["controller.redb", "node-spec.json"],
            &mut alone,
        )?;
        own(home.logs(), &["controller.log", "agent.log"], &mut alone)?;
        // Fails when anything else is in it: that is not ours to remove.
        if std::fs::remove_dir(home.path()).is_err() && alone.is_empty() {
            alone.push(home.path().to_owned());
        }
    }
    Ok(alone)
}

/// A mistaken home must lose nothing: a folder is ours if it holds no file, or one that only our programs write.
fn is_ours(folder: &Path, marks: &[&str]) -> Result<bool, LocalError> {
    let mut names = Vec::new();
    collect_names(folder, 2, &mut names)?;
    Ok(names.is_empty() || names.iter().any(|name| marks.contains(&name.as_str())))
}

/// Names of what is in a folder; of folders only those that are too deep to be looked into.
fn collect_names(folder: &Path, depth: u32, names: &mut Vec<String>) -> Result<(), LocalError> {
    for entry in std::fs::read_dir(folder).map_err(LocalError::file("read", folder))? {
        let entry = entry.map_err(LocalError::file("read", folder))?;
        if depth > 0 && entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            collect_names(&entry.path(), depth - 1, names)?;
        } else {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn home(folder: &Path) -> Home {
        Home::settle(Some(folder.to_owned())).unwrap()
    }

    fn write(path: &Path) {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, "x").unwrap();
    }

    #[test]
    fn a_purge_takes_what_is_ours_and_the_home() {
        let temp = tempfile::tempdir().unwrap();
        let home = home(&temp.path().join("h"));
        write(&home.controller_lock());
        write(&home.state().join("controller.redb"));
        write(&home.agent_log("local"));
        assert_eq!(remove(&home, true).unwrap(), Vec::<PathBuf>::new());
        assert!(!home.path().exists());
    }

    #[test]
    fn a_mistaken_home_loses_nothing() {
        let temp = tempfile::tempdir().unwrap();
        let home = home(temp.path());
        for file in [
            "run/fast.sh",
            "state/of/the/art.txt",
            "logs/2026.log",
            "thesis.tex",
        ] {
            write(&temp.path().join(file));
        }
        let alone = remove(&home, true).unwrap();
        assert_eq!(alone, [home.run(), home.state(), home.logs()]);
        assert!(temp.path().join("state/of/the/art.txt").exists());
        assert!(temp.path().join("thesis.tex").exists());
    }

    #[test]
    fn down_without_purge_keeps_state_and_logs() {
        let temp = tempfile::tempdir().unwrap();
        let home = home(temp.path());
        write(&home.agent_lock("local"));
        write(&home.state().join("controller.redb"));
        remove(&home, false).unwrap();
        assert!(!home.run().exists());
        assert!(home.state().exists());
    }
}
