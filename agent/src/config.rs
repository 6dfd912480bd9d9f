//! What an agent is told when it starts.

use std::path::PathBuf;

/// Settings of an agent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Config {
    /// `RTSCTL_HOME`: holds `run/`, `state/` and `logs/`.
    pub home: PathBuf,
    /// Node name.
    pub node: String,
    /// Further names by which hosts in profiles may mean this node.
    pub aliases: Vec<String>,
    /// Folders that are searched for modules, in order.
    pub module_path: Vec<PathBuf>,
    /// The manager program.
    pub manager_program: PathBuf,
    /// Socket of the controller; none to run without one.
    pub controller_socket: Option<PathBuf>,
}

impl Config {
    /// Name of the node of this machine when no other was given.
    pub const LOCAL_NODE: &str = "local";
}
