//! An agent as a service of an account: copied by digest, kept running by systemd where that is there, else a plain process. What
//! is to be done is a list, made of what is wanted and what is there; only then is anything touched.

#[cfg(feature = "session")]
mod change;
mod found;
#[cfg(feature = "session")]
mod install;
#[cfg(feature = "session")]
mod remove;
mod service;
#[cfg(feature = "session")]
mod steps;

use std::path::PathBuf;

#[cfg(feature = "session")]
pub use change::Change;
pub use found::{Found, Record};
#[cfg(feature = "session")]
pub use install::{Installed, install};
#[cfg(feature = "session")]
pub use remove::{Removed, remove};
pub use service::{Keeper, Service};

use crate::error::{Kind, SshError};

/// What is wanted of an installation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    /// Node name; a sound file name.
    pub node: String,
    /// Further hosts by which profiles may mean the node.
    pub aliases: Vec<String>,
    /// The agent's program here.
    pub agent: PathBuf,
    /// The manager's program here.
    pub manager: PathBuf,
    /// Module files here; none to leave those that are there.
    pub modules: Option<Vec<PathBuf>>,
    /// Nothing is touched.
    pub dry_run: bool,
}

/// Why a service could not be installed or removed.
#[derive(Debug, thiserror::Error)]
pub enum BootstrapError {
    /// The session, or a file on either side.
    #[error(transparent)]
    Ssh(#[from] SshError),
    /// An agent runs there that nobody installed like this.
    #[error(
        "on {host} node {node} already has an agent that was not installed by `node bootstrap`: process {pid}, {program}"
    )]
    Taken {
        /// The other machine.
        host: String,
        /// Node.
        node: String,
        /// Its agent.
        pid: u32,
        /// What it runs.
        program: String,
    },
    /// It was started and does not serve.
    #[error("the agent of node {node} on {host} does not serve after {seconds} s{}", if said.is_empty() { String::new() } else { format!(": {said}") })]
    NotServing {
        /// The other machine.
        host: String,
        /// Node.
        node: String,
        /// How long it was waited for.
        seconds: u64,
        /// The end of its log.
        said: String,
    },
    /// Managers run, and nobody said that they may be stopped.
    #[error("{managers} manager processes of node {node} still run on {host}")]
    InUse {
        /// The other machine.
        host: String,
        /// Node.
        node: String,
        /// How many.
        managers: usize,
    },
    /// A program does not start there at all.
    #[error("{program} does not run on {host}: {said}")]
    CannotRun {
        /// The other machine.
        host: String,
        /// Program there.
        program: String,
        /// What it said.
        said: String,
    },
}

impl BootstrapError {
    /// What kind of failure it is.
    pub fn kind(&self) -> Kind {
        match self {
            BootstrapError::Ssh(e) => e.kind(),
            BootstrapError::Taken { .. } | BootstrapError::InUse { .. } => Kind::Conflict,
            BootstrapError::NotServing { .. } | BootstrapError::CannotRun { .. } => {
                Kind::Unreachable
            }
        }
    }

    /// How to mend it.
    pub fn help(&self) -> Option<String> {
        match self {
            BootstrapError::Ssh(e) => e.help(),
            BootstrapError::Taken { .. } => {
                Some("stop it there (`rtsctl down` stops a local stack), or name another node with --name".to_owned())
            }
            BootstrapError::InUse { .. } => Some(
                "take their systems down with `rtsctl teardown` first, or stop them as well with --yes".to_owned(),
            ),
            BootstrapError::CannotRun { .. } => Some(
                "build the programs for that machine and its C library, and name their folder with --programs DIR".to_owned(),
            ),
            BootstrapError::NotServing { .. } => None,
        }
    }
}
