//! Files of a manager's run folder `$RTSCTL_HOME/run/<node>/<id>/`: `manager.json`, `lock`, `control.sock`.

use serde::{Deserialize, Serialize};

use crate::control::SystemId;

/// Name of the control socket.
pub const CONTROL_SOCKET: &str = "control.sock";
/// Name of the lock file; the manager holds an exclusive flock on it for life.
pub const LOCK: &str = "lock";
/// Name of the file that describes the manager.
pub const MANAGER_JSON: &str = "manager.json";

/// Contents of `manager.json`, written (and renamed into place) before the manager serves.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ManagerFile {
    /// Protocol version that it speaks.
    pub protocol_version: u32,
    /// System that it belongs to.
    pub system: Option<SystemId>,
    /// Manager name.
    pub name: String,
    /// Unique id of this start.
    pub incarnation: String,
    /// Process id; also its process group.
    pub pid: u32,
    /// Field 22 of `/proc/PID/stat`: with the pid and the boot id it names one process.
    pub start_ticks: u64,
    /// `/proc/sys/kernel/random/boot_id`.
    pub boot_id: String,
    /// Wall-clock start, RFC 3339.
    pub started: String,
    /// Name of its control group, where that is not the one that its run folder has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cgroup: Option<String>,
}
