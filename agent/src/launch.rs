//! Starting a manager. A trait, so that other runtimes can be started too.

mod process;

use std::future::Future;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::pin::Pin;

use rts_plan::desired::ManagerKey;

pub use process::ProcessLauncher;
pub(crate) use process::environment;

/// What is to be started.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Start {
    /// Which manager.
    pub key: ManagerKey,
    /// Unique id of this start.
    pub incarnation: String,
    /// Its run folder; exists and is empty.
    pub folder: PathBuf,
    /// Where its standard output and error go.
    pub log: PathBuf,
}

/// How a process ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// It returned.
    Code(i32),
    /// A signal ended it.
    Signal(i32),
    /// It was not our child.
    Unknown,
}

impl std::fmt::Display for Exit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Exit::Code(code) => write!(f, "exit status {code}"),
            Exit::Signal(signal) => write!(f, "signal {signal}"),
            Exit::Unknown => f.write_str("exit status unknown"),
        }
    }
}

/// Is done when the process has ended, and its process group was killed.
pub type ExitFuture = Pin<Box<dyn Future<Output = Exit> + Send>>;

/// A manager that was started and may not serve yet.
pub struct Launched {
    /// Process id, also its process group.
    pub pid: u32,
    /// The first control connection; its Hello is the sign of readiness.
    pub control: UnixStream,
    /// Its end.
    pub exit: ExitFuture,
}

/// A start that failed.
#[derive(Debug, thiserror::Error)]
#[error("cannot start {what}")]
pub struct LaunchError {
    /// Program or file.
    pub what: String,
    /// Why.
    pub source: std::io::Error,
}

/// Starts managers.
pub trait Launcher: Send + Sync + 'static {
    /// Starts one and returns at once. Must be called within a tokio runtime.
    fn launch(&self, start: &Start) -> Result<Launched, LaunchError>;
}
