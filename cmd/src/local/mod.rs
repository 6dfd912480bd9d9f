//! The local stack: one controller and the agents of this machine, everything of it under one folder.

pub mod down;
pub mod home;
pub mod lock;
pub mod nodes;
pub mod relays;
pub mod remove;
pub mod restore;
pub mod strays;
pub mod up;

use std::io;
use std::path::PathBuf;

use crate::exit::Exit;

/// Name of the only node of a home that was told of no others.
pub const LOCAL_NODE: &str = "local";

/// Why the local stack could not be started or stopped.
#[derive(Debug, thiserror::Error)]
pub enum LocalError {
    /// Neither a flag, nor a variable, nor a home folder of the user.
    #[error("there is no folder for the local stack: neither RTSCTL_HOME nor HOME is set")]
    NoHome,
    /// Sockets below it would have names that are too long.
    #[error(
        "{} is too long: a Unix socket in it would have a path of {bytes} bytes, and {limit} is the limit", home.display()
    )]
    HomeTooLong {
        /// The home.
        home: PathBuf,
        /// Bytes of the longest socket path.
        bytes: usize,
        /// The kernel's limit.
        limit: usize,
    },
    /// Its folders cannot be ours.
    #[error(transparent)]
    Claim(#[from] rts_host::home::ClaimError),
    /// The home cannot be made.
    #[error("cannot make the folder {}", path.display())]
    Home {
        /// The folder.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// A file or folder of the home.
    #[error("cannot {what} {}", path.display())]
    File {
        /// What was tried.
        what: &'static str,
        /// On what.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// Another `up`, `down` or `apply` holds the lock.
    #[error("{} is locked by another rtsctl for more than {seconds} s", home.display())]
    Locked {
        /// The home.
        home: PathBuf,
        /// How long it was waited for.
        seconds: u64,
    },
    /// A program of the stack could not be started.
    #[error("cannot start {}", program.display())]
    Spawn {
        /// The program.
        program: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// A program did not become ready.
    #[error("{program} did not become ready: {reason}")]
    NotReady {
        /// The program.
        program: &'static str,
        /// Why not.
        reason: String,
        /// Its log.
        log: PathBuf,
    },
    /// A node that is reached by SSH is not.
    #[error("node {node} is not reached: {reason}")]
    Relay {
        /// The node.
        node: String,
        /// Why.
        reason: String,
        /// How to mend it.
        help: Option<String>,
        /// The exit code.
        exit: Exit,
        /// The relay's log.
        log: PathBuf,
    },
    /// Systems run and nobody said that they may be stopped.
    #[error("{} still running: {}", plural("system", systems.len()), systems.join(", "))]
    SystemsRun {
        /// Their names.
        systems: Vec<String>,
    },
    /// The nodes that were named cannot be.
    #[error("{0}")]
    Nodes(String),
    /// The user said no.
    #[error("nothing was stopped")]
    Declined,
    /// Something is still there.
    #[error("not everything stopped: {}", left.join("; "))]
    Left {
        /// What, and why.
        left: Vec<String>,
    },
    /// The async runtime.
    #[error("cannot start the runtime")]
    Runtime(#[source] io::Error),
}

impl LocalError {
    /// For `map_err` behind a file operation.
    pub fn file(what: &'static str, path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        move |source| LocalError::File { what, path, source }
    }

    /// The exit code.
    pub fn exit(&self) -> Exit {
        match self {
            LocalError::NoHome
            | LocalError::HomeTooLong { .. }
            | LocalError::Claim(_)
            | LocalError::Home { .. }
            | LocalError::SystemsRun { .. }
            | LocalError::Nodes(_)
            | LocalError::Declined => Exit::Usage,
            LocalError::Relay { exit, .. } => *exit,
            LocalError::Locked { .. } => Exit::Deadline,
            LocalError::Left { .. } => Exit::Partly,
            LocalError::File { .. }
            | LocalError::Spawn { .. }
            | LocalError::NotReady { .. }
            | LocalError::Runtime(_) => Exit::Unreachable,
        }
    }

    /// How to mend it.
    pub fn help(&self) -> Option<String> {
        match self {
            LocalError::Home { .. } | LocalError::Claim(rts_host::home::ClaimError::File(..)) => {
                Some("set RTSCTL_HOME to a folder that you may write to".to_owned())
            }
            LocalError::NoHome => Some("set RTSCTL_HOME to a folder of your own".to_owned()),
            LocalError::HomeTooLong { .. } => {
                Some("set RTSCTL_HOME to a shorter folder".to_owned())
            }
            LocalError::SystemsRun { .. } => Some(
                "take them down with `rtsctl teardown`, or stop everything with `rtsctl down --yes`"
                    .to_owned(),
            ),
            LocalError::Relay { help, log, .. } => Some(
                help.clone()
                    .unwrap_or_else(|| format!("see {}", log.display())),
            ),
            LocalError::NotReady { log, .. } => Some(format!("see {}", log.display())),
            LocalError::Spawn { .. } => Some(
                "rtsctl looks for the other programs beside itself: `cargo build --workspace` builds them"
                    .to_owned(),
            ),
            _ => None,
        }
    }
}

/// `1 system`, `2 systems`.
pub fn plural(noun: &str, count: usize) -> String {
    let s = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{s}")
}
