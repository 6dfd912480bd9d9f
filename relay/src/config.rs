//! What a relay is told when it starts.

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

/// The name of what keeps the copies over there that a node of a home needs.
pub fn lease(home: &Path, node: &str) -> String {
    let machine = std::fs::read_to_string("/etc/machine-id").unwrap_or_default();
    let home = home.canonicalize().unwrap_or_else(|_| home.to_owned());
    lease_name(machine.trim(), &home.display().to_string(), node)
}
