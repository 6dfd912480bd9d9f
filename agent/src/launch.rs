//! What starts and ends managers, in words.

use std::future::Future;
use std::io;
use std::path::PathBuf;
use std::pin::Pin;

use rts_plan::desired::ManagerKey;

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

/// A start that failed.
#[derive(Debug, thiserror::Error)]
#[error("cannot start {what}")]
pub struct LaunchError {
    /// Program or file.
    pub what: String,
    /// Why.
    pub source: io::Error,
}

impl LaunchError {
    /// What the manager before it started does not die.
    pub fn ending() -> Self {
        Self {
            what: "a manager in the place of one that does not end".to_owned(),
            source: io::Error::new(io::ErrorKind::ResourceBusy, Ending),
        }
    }

    /// True for [`LaunchError::ending`].
    pub fn is_ending(&self) -> bool {
        self.source.get_ref().is_some_and(|e| e.is::<Ending>())
    }
}

/// Somebody does not die.
#[derive(Debug, thiserror::Error)]
#[error("what it started does not die; look at it with `ps`")]
struct Ending;
