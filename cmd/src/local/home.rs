//! Where the local stack's folder is and what lies in it.

use std::io;
use std::path::{Path, PathBuf};

use etcetera::BaseStrategy;

use super::LocalError;

/// Longest path of a Unix socket on Linux, in bytes.
const MAX_SOCKET_PATH: usize = 107;

/// Folder of a local stack: `run/` (sockets, locks), `state/`, `logs/`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Home(PathBuf);

impl Home {
    /// The folder that was named, else `rtsctl` in the user's state folder.
    pub fn settle(named: Option<PathBuf>) -> Result<Self, LocalError> {
        let path = match named.filter(|p| !p.as_os_str().is_empty()) {
            Some(path) => path,
            None => etcetera::choose_base_strategy()
                .map_err(|_| LocalError::NoHome)?
                .state_dir()
                .ok_or(LocalError::NoHome)?
                .join("rtsctl"),
        };
        let path = std::path::absolute(&path).map_err(LocalError::file("resolve", &path))?;
        Ok(Self(path))
    }

    /// Refuses a folder in which the paths of a node's sockets would be too long.
    pub fn check_length(&self, node: &str) -> Result<(), LocalError> {
        let longest = self.node_run(node).join("01234567").join("control.sock");
        let bytes = longest.as_os_str().len();
        if bytes > MAX_SOCKET_PATH {
            return Err(LocalError::HomeTooLong {
                home: self.0.clone(),
                bytes,
                limit: MAX_SOCKET_PATH,
            });
        }
        Ok(())
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// `run/`.
    pub fn run(&self) -> PathBuf {
        self.0.join("run")
    }

    /// `state/`.
    pub fn state(&self) -> PathBuf {
        self.0.join("state")
    }

    /// `logs/`.
    pub fn logs(&self) -> PathBuf {
        self.0.join("logs")
    }

    /// `run/controller.sock`.
    pub fn controller_socket(&self) -> PathBuf {
        self.run().join("controller.sock")
    }

    /// `run/controller.lock`, held while a controller lives.
    pub fn controller_lock(&self) -> PathBuf {
        self.run().join("controller.lock")
    }

    /// `run/controller.json`.
    pub fn controller_json(&self) -> PathBuf {
        self.run().join("controller.json")
    }

    /// `logs/controller.log`.
    pub fn controller_log(&self) -> PathBuf {
        self.logs().join("controller.log")
    }

    /// `run/<node>/`.
    pub fn node_run(&self, node: &str) -> PathBuf {
        self.run().join(node)
    }

    /// `state/<node>/`.
    pub fn node_state(&self, node: &str) -> PathBuf {
        self.state().join(node)
    }

    /// `run/<node>/agent.json`.
    pub fn agent_json(&self, node: &str) -> PathBuf {
        self.node_run(node).join("agent.json")
    }

    /// `run/<node>/agent.lock`, held while an agent lives.
    pub fn agent_lock(&self, node: &str) -> PathBuf {
        self.node_run(node).join("agent.lock")
    }

    /// `run/<node>/relay.sock`: whoever is connected keeps the session of a node that is reached by SSH.
    pub fn relay_socket(&self, node: &str) -> PathBuf {
        self.node_run(node).join("relay.sock")
    }

    /// `logs/<node>/agent.log`.
    pub fn agent_log(&self, node: &str) -> PathBuf {
        self.logs().join(node).join("agent.log")
    }
}

/// Makes a folder and what is missing above it, for the user alone.
pub fn make_private(path: &Path) -> Result<(), LocalError> {
    match rts_host::files::private_folder(path) {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists && path.is_dir() => Ok(()),
        other => other.map_err(|source| LocalError::Home {
            path: path.to_owned(),
            source,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_home_of_the_longest_allowed_path_is_taken_and_one_byte_more_is_refused() {
        let rest = "/run/local/01234567/control.sock".len();
        let longest = format!("/{}", "h".repeat(MAX_SOCKET_PATH - rest - 1));
        let home = |path: &str| Home::settle(Some(PathBuf::from(path))).unwrap();
        home(&longest).check_length("local").unwrap();
        let error = home(&format!("{longest}h"));
        let error = error.check_length("local").unwrap_err();
        assert_eq!(error.exit().code(), 2);
        assert!(error.help().unwrap().contains("RTSCTL_HOME"));
        assert!(error.to_string().contains("108 bytes"), "{error}");
    }

    #[test]
    fn a_relative_home_is_made_absolute() {
        let home = Home::settle(Some(PathBuf::from("x"))).unwrap();
        assert!(home.path().is_absolute());
    }
}
