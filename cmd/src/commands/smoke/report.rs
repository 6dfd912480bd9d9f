//! What the checks found, as a table and as a document.

use std::time::{Duration, Instant};

use rts_controller_api::API_VERSION;
use rts_schemas::system::SystemSpec;
use serde_json::{Value, json};

use super::Format;
use super::budget::Budgets;
use super::check::Check;
use super::evidence::Evidence;
use super::failure::{Failure, Verdict};
use crate::error::CliError;
use crate::exit::Exit;
use crate::local::plural;
use crate::output::Output;
use crate::show::plan::yaml;
use crate::show::table::Table;

/// How a check ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// It passed; what it saw.
    Passed(String),
    /// It failed.
    Failed(Failure),
    /// It was not made; why.
    Skipped(String),
}

/// A check that was made, or was not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outcome {
    /// Which.
    pub check: Check,
    /// How long it took.
    pub took: Duration,
    /// How it ended.
    pub ending: Ending,
}

impl Outcome {
    fn word(&self) -> &'static str {
        match self.ending {
            Ending::Passed(_) => "passed",
            Ending::Failed(_) => "failed",
            Ending::Skipped(_) => "skipped",
        }
    }

    fn message(&self) -> &str {
        match &self.ending {
            Ending::Passed(text) | Ending::Skipped(text) => text,
            Ending::Failed(failure) => &failure.message,
        }
    }

    fn failure(&self) -> Option<&Failure> {
        match &self.ending {
            Ending::Failed(failure) => Some(failure),
            _ => None,
        }
    }
}

/// All of it.
#[derive(Debug)]
pub struct Report {
    /// Name of the system.
    pub system: String,
    /// In the order in which they are made.
    pub outcomes: Vec<Outcome>,
    /// How many components are stand-ins, and how many there are.
    pub stand_ins: (usize, usize),
    /// What shows why something failed.
    pub evidence: Option<Evidence>,
    /// How long all of it took.
    pub took: Duration,
    budgets: Budgets,
    begun: Instant,
}

impl Report {
    /// Nothing was checked yet.
    pub fn new(spec: &SystemSpec, budgets: Budgets) -> Self {
        Self {
            system: spec.name.clone(),
            outcomes: Vec::new(),
            stand_ins: (0, spec.components.len()),
            evidence: None,
            took: Duration::ZERO,
            budgets,
            begun: Instant::now(),
        }
    }

    /// Takes in a check, and says so in a line. One that passed and took longer than it may has failed, and comes with
    /// the critical path.
    pub fn record(
        &mut self,
        check: Check,
        took: Duration,
        verdict: Verdict,
        path: impl FnOnce() -> Vec<String>,
    ) -> String {
        let ending = match (verdict, self.budgets.exceeded(check, took)) {
            (Ok(_), Some(message)) => {
                let mut failure = Failure::new(message);
                failure.details = match check {
                    Check::Apply | Check::Total => path(),
                    _ => Vec::new(),
                };
                Ending::Failed(failure)
            }
            (Ok(text), None) => Ending::Passed(text),
            (Err(failure), _) => Ending::Failed(failure),
        };
        let outcome = Outcome {
            check,
            took,
            ending,
        };
        let (name, word, seconds) = (check.name(), outcome.word(), took.as_secs_f64());
        let line = format!(
            "check {name} {word} ({seconds:.2} s): {}",
            outcome.message()
        );
        self.outcomes.push(outcome);
        line
    }

    /// Takes in a check that is not made.
    pub fn skip(&mut self, check: Check, reason: &str) {
        self.outcomes.push(Outcome {
            check,
            took: Duration::ZERO,
            ending: Ending::Skipped(reason.to_owned()),
        });
        self.outcomes.sort_by_key(|outcome| outcome.check);
    }

    /// The end: how long all of it took.
    pub fn total(&mut self, path: Vec<String>) {
        self.took = self.begun.elapsed();
        if self.budgets.of(Check::Total).is_some() {
            let verdict = Ok("within its budget".to_owned());
            self.record(Check::Total, self.took, verdict, || path);
        }
    }

    /// True once a check was made, or was not.
    pub fn has(&self, check: Check) -> bool {
        self.outcomes.iter().any(|outcome| outcome.check == check)
    }

    /// True for a check that was made and passed.
    pub fn passed(&self, check: Check) -> bool {
        let mut own = self.outcomes.iter().filter(|o| o.check == check);
        own.any(|outcome| matches!(outcome.ending, Ending::Passed(_)))
    }

    /// True when a check failed.
    pub fn failed(&self) -> bool {
        self.failures().next().is_some()
    }

    /// Components in question, those of the first failure first.
    pub fn culprits(&self) -> Vec<String> {
        let all = self.failures().flat_map(|(_, failure)| &failure.culprits);
        let mut culprits: Vec<String> = Vec::new();
        for culprit in all {
            if !culprits.contains(culprit) {
                culprits.push(culprit.clone());
            }
        }
        culprits
    }

    fn failures(&self) -> impl Iterator<Item = (&Outcome, &Failure)> {
        let all = self.outcomes.iter();
        all.filter_map(|outcome| Some((outcome, outcome.failure()?)))
    }

    /// How the program ends: as its first failure says.
    pub fn exit(&self) -> Exit {
        let first = self.failures().next();
        first.map_or(Exit::Ok, |(_, failure)| failure.exit)
    }

    /// `1 of 3 components is a stand-in`; empty for none.
    pub fn stand_ins_text(&self) -> String {
        match self.stand_ins {
            (0, _) => String::new(),
            (1, all) => format!("1 of {} is a stand-in", plural("component", all)),
            (count, all) => format!("{count} of {} are stand-ins", plural("component", all)),
        }
    }

    /// Prints it.
    pub fn print(&self, format: Format, out: &Output) -> Result<(), CliError> {
        match format {
            Format::Table => out.result(&self.text()),
            Format::Json => out.result(&format!("{:#}", self.json())),
            Format::Yaml => out.result(&yaml(&self.json())?),
        }
    }

    /// What shows why a check failed, as text.
    pub fn evidence_text(&self) -> String {
        self.evidence
            .as_ref()
            .map(Evidence::text)
            .unwrap_or_default()
    }

    fn text(&self) -> String {
        let mut table = Table::new(&["CHECK", "RESULT", "TIME", "MESSAGE"]);
        for outcome in &self.outcomes {
            let time = match outcome.ending {
                Ending::Skipped(_) => String::new(),
                _ => format!("{:.2} s", outcome.took.as_secs_f64()),
            };
            let (name, word) = (outcome.check.name(), outcome.word());
            let message = outcome.message().to_owned();
            table.row([name.to_owned(), word.to_owned(), time, message]);
        }
        let mut text = table.render(true, false);
        for (outcome, failure) in self.failures() {
            let name = outcome.check.name();
            text.push_str(&format!("\nCheck {name} failed: {}\n", failure.message));
            text.extend(failure.details.iter().map(|line| format!("{line}\n")));
        }
        text.push_str(&self.evidence_text());
        if self.failed() {
            text.push('\n');
        }
        text.push_str(&self.summary());
        text
    }

    fn summary(&self) -> String {
        let made = self.outcomes.iter();
        let made = made.filter(|o| !matches!(o.ending, Ending::Skipped(_)));
        let checks = plural("check", made.count());
        let failed: Vec<_> = self.failures().map(|(o, _)| o.check.name()).collect();
        let stand_ins = match self.stand_ins_text() {
            none if none.is_empty() => none,
            some => format!("; {some}"),
        };
        let (system, seconds) = (&self.system, self.took.as_secs_f64());
        match failed.as_slice() {
            [] => format!("system/{system}: {checks} passed ({seconds:.2} s){stand_ins}\n"),
            some => {
                let (count, names) = (some.len(), some.join(", "));
                format!(
                    "system/{system}: {count} of {checks} failed: {names} ({seconds:.2} s){stand_ins}\n"
                )
            }
        }
    }

    fn json(&self) -> Value {
        let check = |outcome: &Outcome| {
            let mut check = json!({
                "name": outcome.check.name(),
                "result": outcome.word(),
                "seconds": outcome.took.as_secs_f64(),
                "message": outcome.message(),
            });
            if let Some(limit) = self.budgets.of(outcome.check) {
                check["budgetSeconds"] = json!(limit.as_secs_f64());
            }
            if let Some(failure) = outcome.failure() {
                check["details"] = json!(failure.details);
                check["components"] = json!(failure.culprits);
            }
            check
        };
        let checks: Vec<Value> = self.outcomes.iter().map(check).collect();
        json!({
            "apiVersion": API_VERSION,
            "kind": "SmokeReport",
            "metadata": {"name": self.system},
            "status": {
                "passed": !self.failed(),
                "exitCode": self.exit().code(),
                "seconds": self.took.as_secs_f64(),
                "components": self.stand_ins.1,
                "standIns": self.stand_ins.0,
                "checks": checks,
                "evidence": self.evidence.as_ref().map(Evidence::json),
            },
        })
    }
}
