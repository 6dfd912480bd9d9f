//! What a relay is told when it starts.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rts_ssh::{Destination, lease_name};

/// Settings of a relay.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Config {
    /// `RTSCTL_HOME` on this machine.
    pub home: PathBuf,
    /// Node name.
    pub node: String,
    /// Hosts in profiles that mean the node.
    pub aliases: Vec<String>,
    /// Whom to reach.
    pub destination: Destination,
    /// Folders of this machine that are searched for the node's modules, in order.
    pub module_path: Vec<PathBuf>,
    /// Folder with `rts-agent` and `rts-manager` for the machine over there.
    pub programs: PathBuf,
    /// How long the session is kept when no command needs it.
    pub keep: Duration,
}

impl Config {
    /// [`Config::keep`] when nothing else was said.
    pub const KEEP: Duration = Duration::from_secs(60);
    /// Longest [`Config::keep`].
    pub const LONGEST: Duration = Duration::from_secs(24 * 3600);

    /// The node's run folder.
    pub(crate) fn run(&self) -> PathBuf {
        self.home.join("run").join(&self.node)
    }

    /// What keeps the copies over there that this node needs.
    pub fn lease(&self) -> String {
        lease(&self.home, &self.node)
    }

    /// Where the node's agent is found.
    pub(crate) fn agent_socket(&self) -> PathBuf {
        self.run().join("agent.sock")
    }

    /// Where commands keep the relay awake.
    pub(crate) fn relay_socket(&self) -> PathBuf {
        self.run().join("relay.sock")
    }

    /// Held for life.
    pub(crate) fn lock(&self) -> PathBuf {
        self.run().join("relay.lock")
    }

    /// Says which process it is.
    pub(crate) fn description(&self) -> PathBuf {
        self.run().join("relay.json")
    }

    /// The controller.
    pub(crate) fn controller_socket(&self) -> PathBuf {
        self.home.join("run/controller.sock")
    }
}

/// The name of what keeps the copies over there that a node of a home needs. Machines that are copies of one another have homes at
/// the same path: a home has a number of its own, made when it first reaches a node.
pub fn lease(home: &Path, node: &str) -> String {
    let machine = std::fs::read_to_string("/etc/machine-id").unwrap_or_default();
    let path = || home.canonicalize().unwrap_or_else(|_| home.to_owned());
    let own = number(&home.join("state/nodes.id")).unwrap_or_else(|e| {
        tracing::warn!("the home has no number of its own: {e}");
        path().display().to_string()
    });
    lease_name(machine.trim(), &own, node)
}

/// The number in a file, which is made if it is not there. Two that make it at once get the same.
fn number(file: &Path) -> io::Result<String> {
    let read = || std::fs::read_to_string(file).map(|text| text.trim().to_owned());
    match read() {
        Err(e) if e.kind() == io::ErrorKind::NotFound => {}
        known => return known,
    }
    let folder = file.parent().unwrap_or(Path::new("/"));
    let mut new = tempfile::Builder::new()
        .prefix("nodes.id.")
        .tempfile_in(folder)?;
    writeln!(new, "{}", uuid::Uuid::new_v4().simple())?;
    match new.persist_noclobber(file) {
        Err(e) if e.error.kind() != io::ErrorKind::AlreadyExists => Err(e.error),
        _ => read(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lease_is_of_one_home_even_where_the_path_is_the_same_on_copies_of_a_machine() {
        let temp = tempfile::tempdir().unwrap();
        let home = temp.path();
        std::fs::create_dir(home.join("state")).unwrap();
        let first = lease(home, "arm");
        assert_eq!(lease(home, "arm"), first);
        assert_ne!(lease(home, "leg"), first);
        assert_eq!(home.join("state").read_dir().unwrap().count(), 1);
        // The same path on another machine.
        std::fs::remove_file(home.join("state/nodes.id")).unwrap();
        assert_ne!(lease(home, "arm"), first);
        // Without a place for the number it goes by its path.
        let nowhere = home.join("nowhere");
        assert_eq!(lease(&nowhere, "arm"), lease(&nowhere, "arm"));
    }
}
