//! Why a check failed, and whose logs tell more.

use rts_controller_api::objects::Waiting;
use rts_schemas::diagnostic;
use rts_schemas::system::SystemSpec;

use crate::error::CliError;
use crate::exit::Exit;
use crate::show::progress::grouped;

/// What a check found: what it saw, or why it failed.
pub type Verdict = Result<String, Failure>;

/// Why a check failed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// In one line.
    pub message: String,
    /// What more is known, a line each.
    pub details: Vec<String>,
    /// Instance names of the components in question.
    pub culprits: Vec<String>,
    /// How the program ends for it.
    pub exit: Exit,
}

impl Failure {
    /// A check that failed.
    pub fn new(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            details: Vec::new(),
            culprits: Vec::new(),
            exit: Exit::Different,
        }
    }

    /// Time is up.
    pub fn late(message: impl Into<String>) -> Self {
        Self {
            exit: Exit::Deadline,
            ..Self::new(message)
        }
    }

    /// The same with components whose logs tell more.
    pub fn of(mut self, culprits: impl IntoIterator<Item = String>) -> Self {
        for culprit in culprits {
            if !self.culprits.contains(&culprit) {
                self.culprits.push(culprit);
            }
        }
        self
    }

    /// The same with what does not go on.
    pub fn waiting<'a>(
        mut self,
        waiting: impl IntoIterator<Item = &'a Waiting>,
        spec: &SystemSpec,
    ) -> Self {
        let waiting: Vec<_> = waiting.into_iter().collect();
        let told = grouped(waiting.iter().copied(), |_| String::new());
        self.details.extend(told);
        // A connector waits for a component, most of the time.
        let is_component = |w: &&&Waiting| w.target.starts_with("component/");
        let own: Vec<_> = waiting.iter().filter(is_component).collect();
        let blamed = match own.is_empty() {
            true => waiting.iter().collect(),
            false => own,
        };
        let blamed = blamed.into_iter().flat_map(|w| components(&w.target, spec));
        self.of(blamed)
    }
}

impl From<CliError> for Failure {
    fn from(error: CliError) -> Self {
        let exit = match error.exit() {
            // A part of it does not run.
            Exit::Partly => Exit::Different,
            exit => exit,
        };
        let mut failure = Self {
            exit,
            ..Self::new(error.line())
        };
        if let CliError::Refused { findings, .. } = &error {
            let all = findings.findings.iter();
            failure.details.extend(all.map(diagnostic::render));
        }
        let faults = error.faults().iter();
        failure
            .details
            .extend(faults.map(|fault| fault.detail.clone()));
        failure.details.extend(error.help());
        failure
    }
}

/// Instance names that a target stands for: itself, or both ends of a connector.
pub fn components(target: &str, spec: &SystemSpec) -> Vec<String> {
    match target.split_once('/') {
        Some(("component", name)) => vec![name.to_owned()],
        Some(("connector", name)) => {
            let mut connectors = spec.connectors.iter();
            let ends = connectors.find(|c| c.name == name);
            let ends = ends.map(|c| vec![c.source.instance.clone(), c.target.instance.clone()]);
            ends.unwrap_or_default()
        }
        _ => Vec::new(),
    }
}
