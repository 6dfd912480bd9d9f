//! Errors as the user sees them: what was tried, why it failed, how to mend it, and the exit code.

use std::path::PathBuf;

use rts_controller_api::{ClientError, ProblemError};

use crate::exit::Exit;
use crate::local::LocalError;

/// Why a verb failed.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// The command line asks for something that makes no sense here.
    #[error("{message}")]
    Usage {
        /// What is wrong.
        message: String,
        /// How to mend it.
        help: Option<String>,
    },
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The input has errors; they have been printed.
    #[error("{file} cannot be deployed: {errors}")]
    Invalid {
        /// The file.
        file: String,
        /// How many (`2 errors`).
        errors: String,
    },
    /// A request failed.
    #[error("cannot {what}")]
    Request {
        /// What was tried (`apply system/hello`).
        what: String,
        /// Why.
        source: ClientError,
    },
    /// No local controller runs, and this verb does not start one.
    #[error("no controller is running in {}", home.display())]
    NoController {
        /// The home.
        home: PathBuf,
    },
    /// The local stack could not be started or stopped.
    #[error(transparent)]
    Local(#[from] LocalError),
    /// Some required things do not run; they have been printed.
    #[error("system/{system} is only partly applied: {summary}")]
    Partly {
        /// Its name.
        system: String,
        /// `2 of 3 components active`.
        summary: String,
    },
    /// The deadline passed.
    #[error("system/{system} is not {goal} after {seconds} s")]
    Deadline {
        /// Its name.
        system: String,
        /// `converged`, `gone`.
        goal: &'static str,
        /// How long it was waited for.
        seconds: u64,
    },
    /// Ctrl-C; what happens next has been said.
    #[error("interrupted")]
    Interrupted,
    /// Stdout cannot be written.
    #[error("cannot write to stdout")]
    Stdout(#[from] std::io::Error),
    /// An object of the API is not what this version knows.
    #[error("{object} of the controller cannot be understood")]
    Object {
        /// Which.
        object: String,
        /// Why.
        source: serde_json::Error,
    },
}

impl CliError {
    /// A usage error without advice.
    pub fn usage(message: impl Into<String>) -> Self {
        CliError::Usage {
            message: message.into(),
            help: None,
        }
    }

    /// A usage error with advice.
    pub fn usage_help(message: impl Into<String>, help: impl Into<String>) -> Self {
        CliError::Usage {
            message: message.into(),
            help: Some(help.into()),
        }
    }

    /// For `map_err` behind a request.
    pub fn request(what: impl Into<String>) -> impl FnOnce(ClientError) -> Self {
        let what = what.into();
        move |source| CliError::Request { what, source }
    }

    /// The exit code.
    pub fn exit(&self) -> Exit {
        match self {
            CliError::Usage { .. } => Exit::Usage,
            CliError::Read { .. } | CliError::Invalid { .. } => Exit::Invalid,
            CliError::Request { source, .. } => Exit::of_client(source),
            CliError::NoController { .. } | CliError::Object { .. } => Exit::Unreachable,
            CliError::Local(e) => e.exit(),
            CliError::Partly { .. } => Exit::Partly,
            CliError::Deadline { .. } => Exit::Deadline,
            CliError::Interrupted => Exit::Interrupted,
            CliError::Stdout(_) => Exit::BrokenPipe,
        }
    }

    /// How to mend it.
    pub fn help(&self) -> Option<String> {
        match self {
            CliError::Usage { help, .. } => help.clone(),
            CliError::NoController { .. } => Some("start one with `rtsctl up`".to_owned()),
            CliError::Local(e) => e.help(),
            CliError::Request { source, .. } => help_of(source),
            CliError::Object { .. } => Some(VERSIONS.to_owned()),
            CliError::Partly { .. } => {
                Some("the controller goes on trying: see `rtsctl get components`".to_owned())
            }
            CliError::Deadline { .. } => {
                Some("the controller goes on: see `rtsctl get systems`".to_owned())
            }
            _ => None,
        }
    }

    /// Single faults of a problem document, in its order.
    pub fn faults(&self) -> &[ProblemError] {
        match self {
            CliError::Request {
                source: ClientError::Problem(problem),
                ..
            } => &problem.errors,
            _ => &[],
        }
    }
}

const VERSIONS: &str = "rtsctl and the controller are probably of different versions: compare `rtsctl version`, then run \
                        `rtsctl down` and `rtsctl up` with the newer one";

fn help_of(source: &ClientError) -> Option<String> {
    match source {
        ClientError::Unreachable { .. } => {
            Some("is it running? see its log, or run `rtsctl up`".to_owned())
        }
        ClientError::Protocol { .. } => Some(VERSIONS.to_owned()),
        ClientError::Problem(problem) if problem.retryable => Some("try again later".to_owned()),
        ClientError::Problem(_) => None,
    }
}
