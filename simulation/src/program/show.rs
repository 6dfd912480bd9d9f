//! What came of seeds, for people and for programs.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::json;

use crate::check::Violation;
use crate::minimise::Minimised;
use crate::schedule::Schedule;

/// A seed that failed.
pub(super) struct Failure {
    pub seed: u64,
    pub violation: Violation,
    pub schedule: Schedule,
    /// Where it was made smaller, with what fails in the smaller one.
    pub minimised: Option<(Minimised, Violation)>,
}

impl Failure {
    /// What is left out of the schedule of the seed.
    fn without(&self) -> String {
        let names = self.minimised.as_ref().map(|(m, _)| &m.without);
        let names: Vec<&str> = names.into_iter().flatten().map(String::as_str).collect();
        names.join(",")
    }

    /// The command that runs it again.
    fn command(&self) -> String {
        command(self.seed, &self.without())
    }

    /// For people.
    pub fn print(&self) {
        println!("seed {} FAILED {}", self.seed, self.violation);
        match &self.minimised {
            Some((minimised, violation)) => {
                println!("smallest schedule found in {} tries:", minimised.tries);
                print!("{}", minimised.schedule);
                println!("there, {violation}");
            }
            None => print!("{}", self.schedule),
        }
        println!("replay: {}", self.command());
    }

    /// For programs.
    pub fn json(&self) -> serde_json::Value {
        let smaller = self.minimised.as_ref().map(|(m, _)| &m.schedule);
        json!({
            "seed": self.seed,
            "at": self.violation.at.as_secs_f64(),
            "invariant": self.violation.invariant,
            "subject": self.violation.subject,
            "what": self.violation.what,
            "schedule": smaller.unwrap_or(&self.schedule).to_string(),
            "replay": self.command(),
        })
    }
}

/// The command that runs a seed without some of its items.
fn command(seed: u64, without: &str) -> String {
    let command = format!("cargo xtask simulate --seed {seed}");
    if without.is_empty() {
        command
    } else {
        format!("{command} -- --without {without}")
    }
}

/// What seeds came by, in columns.
pub(super) fn coverage(counts: &BTreeMap<String, u64>) {
    let width = counts.keys().map(String::len).max().unwrap_or(0);
    for (what, count) in counts {
        println!("  {what:width$} {count:>10}");
    }
}

/// Names in a set that a schedule does not have.
pub(super) fn unknown(schedule: &Schedule, names: &BTreeSet<String>) -> Vec<String> {
    let known = schedule.names();
    names
        .iter()
        .filter(|name| !known.contains(name))
        .cloned()
        .collect()
}
