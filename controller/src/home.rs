//! Folders of `RTSCTL_HOME`, the lock that makes this the only controller in it, and the file that says who runs.

use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use rts_host::files;
use rts_host::identity::Identity;

/// Looks in a row at which another controller must have the lock before it counts: one that has just begun finds that
/// the store is in use, and ends.
const RIVAL: u32 = 5;

/// A home that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum HomeError {
    /// Another controller runs.
    #[error(
        "another controller already runs in {} ({holder}); stop it with `rtsctl down`, or set RTSCTL_HOME to another folder", home.display()
    )]
    Held {
        /// The home.
        home: PathBuf,
        /// Who, as far as known.
        holder: String,
    },
    /// The folders cannot be ours.
    #[error(transparent)]
    Claim(#[from] rts_host::home::ClaimError),
    /// A folder or file failed.
    #[error("cannot {what} {}", path.display())]
    Io {
        /// What was being tried.
        what: &'static str,
        /// Where.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
}

/// A home that is ours until this is dropped.
#[derive(Debug)]
pub struct Home {
    root: PathBuf,
    /// Its flock ends with the descriptor.
    lock: files::Lock,
    /// What tells the file that says who runs from another one at its path, once it was written.
    announced: Option<(u64, u64)>,
    /// Looks in a row at which another controller had the lock.
    rival: u32,
}

impl Home {
    /// Makes the folders (mode 0700) and takes the lock.
    pub fn take(root: &Path) -> Result<Self, HomeError> {
        rts_host::home::claim(root)?;
        let lock = try_lock(root)?.ok_or_else(|| held(root))?;
        Ok(Self {
            root: root.to_owned(),
            lock,
            announced: None,
            rival: 0,
        })
    }

    /// Makes anew what somebody has removed or replaced in `run`: the lock, and the file that says who runs. To be
    /// called now and then; [`HomeError::Held`] when another controller has had the lock for a while.
    pub fn keep(&mut self) -> Result<(), HomeError> {
        if !self.holds() {
            // A home that is gone as a whole is not made again.
            if !self.root.exists() {
                return Ok(());
            }
            rts_host::home::claim(&self.root)?;
            let Some(lock) = try_lock(&self.root)? else {
                self.rival = self.rival.saturating_add(1);
                return match self.rival < RIVAL {
                    true => Ok(()),
                    false => Err(held(&self.root)),
                };
            };
            let path = lock_of(&self.root);
            tracing::warn!("{} was gone or replaced; it is taken anew", path.display());
            self.lock = lock;
        }
        self.rival = 0;
        if self.announced.is_some() && number(&self.json()) != self.announced {
            self.announce()?;
        }
        Ok(())
    }

    /// True while the lock is still the one at its path.
    fn holds(&self) -> bool {
        self.lock.is_at(&lock_of(&self.root))
    }

    /// The controller's socket.
    pub fn socket(&self) -> PathBuf {
        self.root.join("run/controller.sock")
    }

    /// The store's file.
    pub fn store(&self) -> PathBuf {
        self.root.join("state/controller.redb")
    }

    /// Says who runs here. Replaced as a whole, so that nobody reads half of it.
    pub fn announce(&mut self) -> Result<(), HomeError> {
        let path = self.json();
        let own = Identity::own(env!("CARGO_PKG_VERSION"));
        serde_json::to_vec(&own)
            .map_err(io::Error::from)
            .and_then(|text| files::replace(&path, &text))
            .map_err(|source| failed("write", &path, source))?;
        self.announced = number(&path);
        Ok(())
    }

    /// Takes the socket and the file away, unless they may be another controller's. The lock goes with this value.
    pub fn leave(&self) {
        if !self.holds() {
            return;
        }
        for path in [self.json(), self.socket()] {
            if let Err(e) = std::fs::remove_file(&path)
                && e.kind() != io::ErrorKind::NotFound
            {
                tracing::warn!(path = %path.display(), error = %e, "cannot be removed");
            }
        }
    }

    fn json(&self) -> PathBuf {
        self.root.join("run/controller.json")
    }
}

fn lock_of(root: &Path) -> PathBuf {
    root.join("run/controller.lock")
}

fn try_lock(root: &Path) -> Result<Option<files::Lock>, HomeError> {
    let path = lock_of(root);
    files::lock(&path).map_err(|source| failed("lock", &path, source))
}

fn held(root: &Path) -> HomeError {
    HomeError::Held {
        home: root.to_owned(),
        holder: holder(&root.join("run/controller.json")),
    }
}

/// Device and inode.
fn number(path: &Path) -> Option<(u64, u64)> {
    let file = std::fs::symlink_metadata(path).ok()?;
    Some((file.dev(), file.ino()))
}

fn failed(what: &'static str, path: &Path, source: io::Error) -> HomeError {
    HomeError::Io {
        what,
        path: path.to_owned(),
        source,
    }
}

fn holder(json: &Path) -> String {
    Identity::read(json).map_or_else(
        || "it is starting".to_owned(),
        |own| format!("pid {}", own.pid),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_home_has_one_controller() {
        let folder = tempfile::tempdir().unwrap();
        let mut home = Home::take(folder.path()).unwrap();
        home.announce().unwrap();
        let error = Home::take(folder.path()).unwrap_err().to_string();
        let error = error
            .replace(&folder.path().display().to_string(), "HOME")
            .replace(&std::process::id().to_string(), "PID");
        insta::assert_snapshot!(error, @"another controller already runs in HOME (pid PID); stop it with `rtsctl down`, or set RTSCTL_HOME to another folder");
        home.leave();
        drop(home);
        Home::take(folder.path()).unwrap();
    }
    #[test]
    fn what_was_removed_is_made_anew() {
        let folder = tempfile::tempdir().unwrap();
        let mut home = Home::take(folder.path()).unwrap();
        home.announce().unwrap();
        let run = folder.path().join("run");
        let is_whole = || {
            let error = Home::take(folder.path()).unwrap_err();
            assert!(matches!(error, HomeError::Held { .. }), "{error}");
            Identity::read(&run.join("controller.json")).is_some_and(|own| own.is_now())
        };
        for name in ["controller.lock", "controller.json"] {
            std::fs::remove_file(run.join(name)).unwrap();
            home.keep().unwrap();
            assert!(is_whole(), "{name}");
        }
        std::fs::remove_dir_all(&run).unwrap();
        home.keep().unwrap();
        assert!(is_whole() && rts_host::home::is_claimed(&run));
        home.leave();
        assert!(!run.join("controller.json").exists());
    }

    #[test]
    fn a_rival_that_stays_wins_and_one_that_goes_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let mut home = Home::take(folder.path()).unwrap();
        home.announce().unwrap();
        let lock = folder.path().join("run/controller.lock");
        std::fs::remove_file(&lock).unwrap();
        let mut rival = Home::take(folder.path()).unwrap();
        home.keep().unwrap();
        drop(rival);
        home.keep().unwrap();
        assert!(home.holds());
        std::fs::remove_file(&lock).unwrap();
        rival = Home::take(folder.path()).unwrap();
        rival.announce().unwrap();
        for _ in 1..RIVAL {
            home.keep().unwrap();
        }
        let error = home.keep().unwrap_err();
        assert!(matches!(error, HomeError::Held { .. }), "{error}");
        home.leave();
        assert!(folder.path().join("run/controller.json").exists());
    }

    #[test]
    fn a_home_that_is_gone_is_not_made_again() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("home");
        let mut home = Home::take(&root).unwrap();
        home.announce().unwrap();
        std::fs::remove_dir_all(&root).unwrap();
        home.keep().unwrap();
        assert!(!root.exists());
    }
}
