//! Where an agent's files lie below `RTSCTL_HOME`.

use std::io;
use std::path::{Path, PathBuf};

use rts_host::reserve::Reserve;
use rts_http::server::MAX_SOCKET_PATH;
use rts_manager_api::files::CONTROL_SOCKET;
use rts_plan::desired::ManagerKey;
use sha2::{Digest, Sha256};

use crate::log_name::log_name;

/// Longest node name in bytes.
const MAX_NODE: usize = 63;
/// Hexadecimal digits of a manager's folder.
const ID_DIGITS: usize = 8;

/// What the names of control groups of processes that wait begin with, behind that of the node.
const WAITING: &str = "idle-";

/// The folders of one node.
#[derive(Debug, Clone)]
pub(crate) struct Folders {
    /// `RTSCTL_HOME`.
    pub home: PathBuf,
    /// `run/<node>`.
    pub run: PathBuf,
    /// `state/<node>`.
    pub state: PathBuf,
    /// `logs/<node>/components`.
    pub component_logs: PathBuf,
    /// `logs/<node>/managers`.
    pub manager_logs: PathBuf,
    node: String,
}

/// Folders that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The folders cannot be ours.
    #[error(transparent)]
    Claim(#[from] rts_host::home::ClaimError),
    /// A node name that is no file name.
    #[error(
        "node name {0:?} is not usable: use 1 to 63 of a-z, A-Z, 0-9, '-', '_' and '.', not starting with '.'"
    )]
    NodeName(String),
    /// Sockets below the home would not fit.
    #[error(
        "{} is too long: {socket} would have {length} bytes, and a Unix socket path may have {MAX_SOCKET_PATH}; set RTSCTL_HOME to a shorter folder",
        home.display()
    )]
    TooLong {
        /// The home.
        home: PathBuf,
        /// An example of the longest socket.
        socket: String,
        /// Its length.
        length: usize,
    },
    /// A folder cannot be made.
    #[error("cannot make the folder {}", folder.display())]
    Make {
        /// Which.
        folder: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl Folders {
    /// The folders of a node; nothing is made yet.
    pub fn new(home: &Path, node: &str) -> Result<Self, FolderError> {
        if !is_node_name(node) {
            return Err(FolderError::NodeName(node.to_owned()));
        }
        let home = std::path::absolute(home).unwrap_or_else(|_| home.to_owned());
        let logs = home.join("logs").join(node);
        let folders = Self {
            run: home.join("run").join(node),
            state: home.join("state").join(node),
            component_logs: logs.join("components"),
            manager_logs: logs.join("managers"),
            node: node.to_owned(),
            home,
        };
        let socket = folders.run.join("0".repeat(ID_DIGITS)).join(CONTROL_SOCKET);
        let length = socket.as_os_str().len();
        if length > MAX_SOCKET_PATH {
            return Err(FolderError::TooLong {
                home: folders.home,
                socket: socket.display().to_string(),
                length,
            });
        }
        Ok(folders)
    }

    /// Makes the folders, mode 0700.
    pub fn make(&self) -> Result<(), FolderError> {
        rts_host::home::claim(&self.home)?;
        let failed = |folder: &PathBuf| {
            let folder = folder.clone();
            move |source| FolderError::Make { folder, source }
        };
        for folder in [&self.run, &self.component_logs, &self.manager_logs] {
            rts_host::files::private_folder(folder).map_err(failed(folder))?;
        }
        rts_host::files::durable_folder(&self.state).map_err(failed(&self.state))
    }

    /// Socket of the agent.
    pub fn agent_socket(&self) -> PathBuf {
        self.run.join("agent.sock")
    }

    /// Describes the agent's process.
    pub fn description(&self) -> PathBuf {
        self.run.join("agent.json")
    }

    /// Space for the day on which the disk is full.
    pub fn reserve(&self) -> Reserve {
        Reserve::within(&self.state)
    }

    /// Run folder of a manager.
    pub fn manager(&self, key: &ManagerKey) -> PathBuf {
        self.run.join(folder_id(key))
    }

    /// Name of the control group of the manager with this run folder.
    pub fn cgroup(&self, folder: &Path) -> String {
        let id = folder.file_name().unwrap_or_default();
        format!("{}.{}", self.node, id.to_string_lossy())
    }

    /// Run folder of the manager with this control group; none when it is of another node.
    pub fn of_cgroup(&self, name: &str) -> Option<PathBuf> {
        let id = name.strip_prefix(&self.node)?.strip_prefix('.')?;
        is_folder_id(id).then(|| self.run.join(id))
    }

    /// Name of the control group of a process that waits to become a manager: of an agent with this process number, the
    /// `number`th that it made.
    pub fn waiting_cgroup(&self, agent: u32, number: u64) -> String {
        format!("{}.{WAITING}{agent}-{number}", self.node)
    }

    /// True for a name that [`Folders::waiting_cgroup`] can have made for this node.
    pub fn is_waiting_cgroup(&self, name: &str) -> bool {
        let number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        name.strip_prefix(&self.node)
            .and_then(|rest| rest.strip_prefix('.')?.strip_prefix(WAITING))
            .and_then(|rest| rest.split_once('-'))
            .is_some_and(|(agent, own)| number(agent) && number(own))
    }

    /// Log of a component.
    pub fn component_log(&self, instance: &str) -> PathBuf {
        self.component_logs
            .join(format!("{}.log", log_name(instance)))
    }

    /// Standard output and error of a manager.
    pub fn manager_log(&self, key: &ManagerKey) -> PathBuf {
        let name = log_name(&key.display_name());
        self.manager_logs.join(format!("{name}.log"))
    }
}

/// True for a name that stays inside its folder and survives a shell.
pub fn is_node_name(name: &str) -> bool {
    (1..=MAX_NODE).contains(&name.len())
        && !name.starts_with('.')
        && name
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.'))
}

/// Name of a manager's run folder: 8 hexadecimal digits made of its display name and its system's uid.
pub(crate) fn folder_id(key: &ManagerKey) -> String {
    let uid = key.system.as_ref().map_or("", |s| s.uid.as_str());
    let mut hash = Sha256::new();
    hash.update(key.display_name());
    hash.update([0]);
    hash.update(uid);
    let mut id = format!("{:x}", hash.finalize());
    id.truncate(ID_DIGITS);
    id
}

/// True for a name that [`folder_id`] can have made.
pub(crate) fn is_folder_id(name: &str) -> bool {
    name.len() == ID_DIGITS
        && name
            .bytes()
            .all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b))
}

/// Bytes as lower-case hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::new(), |mut out, byte| {
        let _ = write!(out, "{byte:02x}");
        out
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rts_plan::desired::SystemRef;

    fn key(uid: Option<&str>, name: &str) -> ManagerKey {
        ManagerKey {
            system: uid.map(|uid| SystemRef {
                name: "hello".to_owned(),
                uid: uid.to_owned(),
            }),
            name: name.to_owned(),
        }
    }

    #[test]
    fn a_folder_id_depends_on_name_and_system_uid() {
        let ids = [
            key(Some("1"), "main"),
            key(Some("2"), "main"),
            key(Some("1"), "Printer0"),
            key(None, "main"),
            key(None, "hello.main"),
        ]
        .map(|k| folder_id(&k));
        for (n, id) in ids.iter().enumerate() {
            assert!(is_folder_id(id), "{id}");
            assert!(!ids[n + 1..].contains(id), "{id} occurs twice");
        }
        assert_eq!(folder_id(&key(Some("1"), "main")), ids[0]);
        assert!(!is_folder_id("agent.so") && !is_folder_id("0123456") && !is_folder_id("0123456G"));
    }

    #[test]
    fn a_control_group_leads_to_its_run_folder_and_no_other_nodes() {
        let folders = Folders::new(Path::new("/tmp/x"), "a.b").unwrap();
        let folder = folders.manager(&key(None, "main"));
        let name = folders.cgroup(&folder);
        assert_eq!(folders.of_cgroup(&name), Some(folder));
        let waiting = folders.waiting_cgroup(12, 3);
        assert_eq!(waiting, "a.b.idle-12-3");
        assert!(folders.is_waiting_cgroup(&waiting) && folders.of_cgroup(&waiting).is_none());
        for other in [
            "a.idle-12-3",
            "a.b.idle-12",
            "a.b.idle-12-",
            "a.b.idle-12-3.01234567",
            "a.b.idle-x-3",
            "a.b.01234567",
        ] {
            assert!(!folders.is_waiting_cgroup(other), "{other}");
        }
        for other in ["a.01234567", "a.b.c.01234567", "a.b.", "a.b.0123456x"] {
            assert_eq!(folders.of_cgroup(other), None, "{other}");
        }
    }

    #[test]
    fn the_longest_home_fits_and_one_byte_more_is_refused() {
        // "/run/local/01234567/control.sock" has 32 bytes.
        let fits = format!("/{}", "h".repeat(MAX_SOCKET_PATH - 32 - 1));
        let folders = Folders::new(Path::new(&fits), "local").unwrap();
        let socket = folders.manager(&key(None, "bench")).join(CONTROL_SOCKET);
        assert_eq!(socket.as_os_str().len(), MAX_SOCKET_PATH);
        let error = Folders::new(Path::new(&format!("{fits}h")), "local").unwrap_err();
        assert!(error.to_string().contains("RTSCTL_HOME"), "{error}");
    }

    #[test]
    fn names_that_leave_their_folder_are_refused() {
        for name in ["", "..", ".hidden", "a/b", "a\0b", "a\nb"] {
            assert!(Folders::new(Path::new("/tmp/x"), name).is_err(), "{name:?}");
            let folders = Folders::new(Path::new("/tmp/x"), "local").unwrap();
            let log = folders.component_log(name);
            assert_eq!(log.parent(), Some(folders.component_logs.as_path()));
            let log = folders.manager_log(&key(None, name));
            assert_eq!(log.parent(), Some(folders.manager_logs.as_path()));
        }
    }
}
