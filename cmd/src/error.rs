//! Errors as the user sees them: what was tried, why it failed, how to mend it, and the exit code.

mod help;

use std::path::PathBuf;

use rts_controller_api::{ClientError, Problem, ProblemError};
use rts_host::error::chain;
use rts_schemas::diagnostic::Report;
use rts_ssh::SshError;
use rts_ssh::bootstrap::BootstrapError;

pub use self::help::Rest;
use crate::exit::Exit;
use crate::local::{LocalError, plural};

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
    /// A file that was asked for cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file is no backup that can be restored.
    #[error("{0}")]
    Backup(String),
    /// A file is a saved plan that cannot be used.
    #[error("{file} cannot be used as a saved plan: {reason}")]
    SavedPlan {
        /// The file.
        file: String,
        /// Why.
        reason: String,
        /// How to mend it.
        help: Option<String>,
    },
    /// A plan is not what it was any more.
    #[error("system/{system} is not as it was planned: {reason}")]
    Stale {
        /// Its name.
        system: String,
        /// What is different.
        reason: String,
    },
    /// The input has errors; they have been printed.
    #[error("{file} cannot be deployed: {errors}")]
    Invalid {
        /// The file.
        file: String,
        /// How many (`2 errors`).
        errors: String,
    },
    /// Files that cannot be converted; why has been printed.
    #[error("cannot convert {files}: {errors}")]
    NotConverted {
        /// The files.
        files: String,
        /// How many errors (`2 errors`).
        errors: String,
    },
    /// Files have no canonical form; why was printed.
    #[error("cannot format {files}: no byte was changed")]
    NotFormatted {
        /// How many (`2 files`).
        files: String,
    },
    /// A request failed.
    #[error("cannot {what}")]
    Request {
        /// What was tried (`apply system/hello`).
        what: String,
        /// Why.
        source: Box<ClientError>,
    },
    /// The controller refused the input, with a finding for each fault.
    #[error("cannot {what}")]
    Refused {
        /// What was tried (`apply system/hello`).
        what: String,
        /// Its answer.
        problem: Box<Problem>,
        /// Its faults, at their places in the file.
        findings: Report,
    },
    /// A process would restart and the user forbade it.
    #[error("system/{system} was not applied: {restarts}")]
    WouldRestart {
        /// Its name.
        system: String,
        /// `1 process would restart`.
        restarts: String,
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
    /// Another machine by SSH.
    #[error(transparent)]
    Ssh(Box<SshError>),
    /// An agent as a service of another machine.
    #[error(transparent)]
    Bootstrap(Box<BootstrapError>),
    /// Some required things do not run; they have been printed.
    #[error("system/{system} is only partly applied: {summary}")]
    Partly {
        /// Its name.
        system: String,
        /// `2 of 3 components active`.
        summary: String,
        /// What does not run (`component/Motor0`), when it can be described.
        target: Option<String>,
        /// What becomes of that.
        rest: Rest,
        /// Nodes that it lies on.
        nodes: Box<[String]>,
    },
    /// Somebody took it down while it was waited for.
    #[error("system/{system} was taken down by another command")]
    Gone {
        /// Its name.
        system: String,
    },
    /// The deadline passed.
    #[error("system/{system} is not {goal} after {seconds} s")]
    Deadline {
        /// Its name.
        system: String,
        /// `converged`, `gone`.
        goal: &'static str,
        /// How long it was waited for.
        seconds: f64,
        /// Nodes that it lies on.
        nodes: Box<[String]>,
    },
    /// Something about a port or its samples.
    #[error("{message}")]
    Port {
        /// What is wrong, and where.
        message: String,
        /// How to mend it.
        help: Option<String>,
        /// How the program ends.
        exit: Exit,
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

impl From<SshError> for CliError {
    fn from(error: SshError) -> Self {
        CliError::Ssh(Box::new(error))
    }
}

impl From<BootstrapError> for CliError {
    fn from(error: BootstrapError) -> Self {
        CliError::Bootstrap(Box::new(error))
    }
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
        move |source| CliError::Request {
            what,
            source: Box::new(source),
        }
    }

    /// The exit code.
    pub fn exit(&self) -> Exit {
        match self {
            CliError::Read { .. }
            | CliError::Backup(_)
            | CliError::SavedPlan { .. }
            | CliError::NotConverted { .. }
            | CliError::NotFormatted { .. }
            | CliError::Invalid { .. } => Exit::Invalid,
            CliError::Port { exit, .. } => *exit,
            CliError::Request { source, .. } => Exit::of_client(source),
            CliError::Refused { problem, .. } => Exit::of_problem(problem),
            CliError::WouldRestart { .. } => Exit::Refused,
            CliError::NoController { .. } | CliError::Object { .. } => Exit::Unreachable,
            CliError::Local(e) => e.exit(),
            CliError::Ssh(e) => Exit::of_ssh(e.kind()),
            CliError::Bootstrap(e) => Exit::of_ssh(e.kind()),
            CliError::Partly { .. } => Exit::Partly,
            CliError::Deadline { .. } => Exit::Deadline,
            CliError::Interrupted => Exit::Interrupted,
            CliError::Gone { .. } | CliError::Stale { .. } => Exit::Conflict,
            CliError::Stdout(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Exit::BrokenPipe,
            CliError::Usage { .. } | CliError::Write { .. } | CliError::Stdout(_) => Exit::Usage,
        }
    }

    /// The error on one line with its causes; what its faults say is not said again.
    pub fn line(&self) -> String {
        let findings = match self {
            CliError::Refused { findings, .. } => findings.findings.len(),
            _ => 0,
        };
        match self.faults().len() + findings {
            0 => chain(self),
            count => format!("{self}: {}", plural("error", count)),
        }
    }

    /// The controller's refusal, when there is one.
    fn problem(&self) -> Option<&Problem> {
        match self {
            CliError::Refused { problem, .. } => Some(problem),
            CliError::Request { source, .. } => match source.as_ref() {
                ClientError::Problem(problem) => Some(problem),
                _ => None,
            },
            _ => None,
        }
    }

    /// Nodes of the system that the error is about, where it is about one.
    pub fn nodes(&self) -> &[String] {
        match self {
            CliError::Partly { nodes, .. } | CliError::Deadline { nodes, .. } => nodes,
            _ => &[],
        }
    }

    /// Single faults of a problem document, in its order.
    pub fn faults(&self) -> &[ProblemError] {
        match self {
            CliError::Request { source, .. } => match source.as_ref() {
                ClientError::Problem(problem) => &problem.errors,
                _ => &[],
            },
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(errors: Vec<ProblemError>) -> CliError {
        let problem = Problem::invalid("invalid-system", "component A: no module of type X");
        CliError::request("apply system/hello")(problem.with_errors(errors).into())
    }

    #[test]
    fn causes_follow_on_the_same_line() {
        assert_eq!(
            refused(Vec::new()).line(),
            "cannot apply system/hello: component A: no module of type X"
        );
        let read = CliError::Read {
            path: "x.xml".into(),
            source: std::io::Error::other("disk on fire"),
        };
        assert_eq!(read.line(), "cannot read x.xml: disk on fire");
    }

    #[test]
    fn faults_that_are_printed_one_by_one_are_only_counted() {
        let fault = ProblemError {
            pointer: String::new(),
            code: "module-not-found".to_owned(),
            detail: "component A: no module of type X".to_owned(),
            help: None,
        };
        let error = refused(vec![fault.clone(), fault]);
        assert_eq!(error.line(), "cannot apply system/hello: 2 errors");
        assert_eq!(error.faults().len(), 2);
        assert_eq!(error.exit(), Exit::Invalid);
    }

    #[test]
    fn results_that_cannot_be_written_are_a_plain_failure() {
        let full = std::io::Error::from(std::io::ErrorKind::StorageFull);
        let error = CliError::Stdout(full);
        assert_eq!(error.line(), "cannot write to stdout: no storage space");
        assert_eq!(error.exit(), Exit::Usage);
        let closed = std::io::Error::from(std::io::ErrorKind::BrokenPipe);
        assert_eq!(CliError::Stdout(closed).exit(), Exit::BrokenPipe);
    }

    #[test]
    fn a_stopped_controller_comes_with_the_way_to_start_it() {
        let home = PathBuf::from("/h");
        let error = CliError::NoController { home };
        assert_eq!(error.line(), "no controller is running in /h");
        assert_eq!(error.help().as_deref(), Some("start one with `rtsctl up`"));
        assert_eq!(error.exit().code(), 4);
    }
}
