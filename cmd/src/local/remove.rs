//! Removes the folders of a local stack that was stopped, and nothing that is not its own.

use std::path::PathBuf;

use rts_host::home::is_claimed;

use super::LocalError;
use super::home::Home;

/// Removes `run/`; with `purge` also `state/`, `logs/` and the home if nothing else is in it. A folder without our mark
/// is left alone: a mistaken home must lose nothing. Gives what it left alone.
pub fn remove(home: &Home, purge: bool) -> Result<Vec<PathBuf>, LocalError> {
    let mut alone = Vec::new();
    let kept = if purge {
        vec![home.state(), home.logs()]
    } else {
        Vec::new()
    };
    for folder in [home.run()].into_iter().chain(kept) {
        if is_claimed(&folder) {
            std::fs::remove_dir_all(&folder).map_err(LocalError::file("remove", folder))?;
        } else if folder.is_dir() && std::fs::remove_dir(&folder).is_err() {
            alone.push(folder);
        }
    }
    // Fails when anything else is in it: that is not ours to remove.
    if purge && std::fs::remove_dir(home.path()).is_err() && alone.is_empty() {
        alone.push(home.path().to_owned());
    }
    Ok(alone)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

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
        rts_host::home::claim(home.path()).unwrap();
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
        rts_host::home::claim(home.path()).unwrap();
        write(&home.agent_lock("local"));
        write(&home.state().join("controller.redb"));
        remove(&home, false).unwrap();
        assert!(!home.run().exists());
        assert!(home.state().exists());
    }
}
