//! Folders of `RTSCTL_HOME`, the lock that makes this the only controller in it, and the file that says who runs.

use std::io;
use std::path::{Path, PathBuf};

use rts_host::files;
use rts_host::identity::Identity;

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
    _lock: files::Lock,
}

impl Home {
    /// Makes the folders (mode 0700) and takes the lock.
    pub fn take(root: &Path) -> Result<Self, HomeError> {
        rts_host::home::claim(root)?;
        let path = root.join("run/controller.lock");
        match files::lock(&path) {
            Ok(Some(lock)) => Ok(Self {
                root: root.to_owned(),
                _lock: lock,
            }),
            Ok(None) => Err(HomeError::Held {
                home: root.to_owned(),
                holder: holder(&root.join("run/controller.json")),
            }),
            Err(source) => Err(failed("lock", &path, source)),
        }
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
    pub fn announce(&self) -> Result<(), HomeError> {
        let path = self.json();
        let own = Identity::own(env!("CARGO_PKG_VERSION"));
        serde_json::to_vec(&own)
            .map_err(io::Error::from)
            .and_then(|text| files::replace(&path, &text))
            .map_err(|source| failed("write", &path, source))
    }

    /// Takes the socket and the file away. The lock goes with this value.
    pub fn leave(&self) {
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
        let home = Home::take(folder.path()).unwrap();
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
}
