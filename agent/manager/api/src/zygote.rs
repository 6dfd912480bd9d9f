//! What an agent and its zygote say to each other, and what makes a forked process a certain manager.
//!
//! A zygote (`rts-manager --zygote`) has a socket of datagrams as standard input. It says [`FromZygote::Ready`], and then
//! answers each [`Fork`], in their order. The copy has the socket that came with the order as its control connection; there
//! it waits for [`Become`], a frame with the log file, and then goes on like any manager. A copy whose control
//! connection ends before that ends too, and so does a zygote whose socket ends.

use std::path::PathBuf;

use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::control::SystemId;

/// Version of what is said here. Another one is not spoken to: the agent then spawns its managers.
pub const ZYGOTE_VERSION: u32 = 1;
/// Largest datagram in bytes.
pub const MAX_DATAGRAM: usize = 4096;
/// Largest [`Become`] in bytes.
pub const MAX_BECOME: usize = 64 * 1024;

/// The order to fork. With it come the control connection and, if it says so, the folder of a control group (version 2).
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Fork {
    /// The copy is to be born in the control group whose folder came along.
    pub cgroup: bool,
    /// The copy will wait to be told who it is: it starts its threads meanwhile. One that is told at once does not.
    #[serde(default)]
    pub waits: bool,
}

/// What a zygote says.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(
    tag = "what",
    rename_all = "camelCase",
    rename_all_fields = "camelCase"
)]
pub enum FromZygote {
    /// It takes orders.
    Ready {
        /// Its [`ZYGOTE_VERSION`].
        version: u32,
    },
    /// A copy is there, a child of the agent. Its pidfd comes along.
    Forked {
        /// Its number.
        pid: u32,
        /// It is in the control group; where it could not be born there, the agent has to put it there.
        in_cgroup: bool,
    },
    /// There is no copy.
    Failed {
        /// Why.
        reason: String,
    },
}

/// Makes a process that waits a certain manager. The log file comes with its first byte.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Become {
    /// Run folder, and working folder.
    pub dir: PathBuf,
    /// Manager name.
    pub name: String,
    /// System that it belongs to.
    pub system: Option<SystemId>,
    /// Unique id of this start.
    pub incarnation: String,
    /// Name of its control group, where that is not the one that its run folder has: told in its `manager.json`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cgroup: Option<String>,
}

/// Reads a datagram.
pub fn decode<T: DeserializeOwned>(datagram: &[u8]) -> Result<T, serde_json::Error> {
    serde_json::from_slice(datagram)
}
