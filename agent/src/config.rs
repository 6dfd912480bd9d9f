//! What an agent is told when it starts.

use std::path::PathBuf;
use std::time::Duration;

use rts_agent_api::session::UNKNOWN_AFTER;

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
    /// After so long without a controller the agent heals its node by itself; none for never.
    pub heal_after: Option<Duration>,
    /// Manager processes that are kept ready to become any manager, at most [`Config::MOST_IDLE`]; none for spawning each
    /// manager anew, without a zygote.
    pub idle_managers: Option<u8>,
}

impl Config {
    /// Name of the node of this machine when no other was given.
    pub const LOCAL_NODE: &str = "local";
    /// When a controller takes a silent agent for gone, the agent takes the controller for gone too.
    pub const HEAL_AFTER: Duration = UNKNOWN_AFTER;
    /// Most managers that are kept ready, and how many are unless somebody says otherwise.
    pub const MOST_IDLE: u8 = 2;
}
