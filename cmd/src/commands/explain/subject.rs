//! What of a plan is meant.

use std::collections::BTreeSet;

use rts_plan::plan::{Plan, StepId};
use rts_schemas::system::SystemSpec;

use crate::error::CliError;
use crate::local::plural;

/// What is to be explained.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Subject {
    /// A step.
    Step(StepId),
    /// A target that the plan speaks of.
    Target(String),
    /// A part of the system that the plan does not speak of.
    Settled(String),
}

impl Subject {
    /// Of a number, `KIND TARGET`, or `TARGET`. A target may be a bare name where that is clear.
    pub fn find(plan: &Plan, spec: &SystemSpec, what: &str) -> Result<Self, CliError> {
        let words: Vec<&str> = what.split_whitespace().collect();
        match words.as_slice() {
            [number] if number.chars().all(|c| c.is_ascii_digit()) => step(plan, number),
            [target] => one(plan, spec, target),
            [kind, target] => of_kind(plan, kind, target),
            _ => Err(CliError::usage("name one step or one target")),
        }
    }
}

fn step(plan: &Plan, number: &str) -> Result<Subject, CliError> {
    let id = number.parse().unwrap_or(StepId::MAX);
    match plan.steps.iter().any(|step| step.id == id) {
        true => Ok(Subject::Step(id)),
        false => {
            let count = plural("step", plan.steps.len());
            let text = format!("there is no step {number}: the plan has {count}");
            Err(CliError::usage_help(text, LIST))
        }
    }
}

fn of_kind(plan: &Plan, kind: &str, target: &str) -> Result<Subject, CliError> {
    let mut steps = plan.steps.iter();
    let found = steps.find(|step| {
        step.work.kind().eq_ignore_ascii_case(kind) && is_called(&step.target, target)
    });
    match found {
        Some(step) => Ok(Subject::Step(step.id)),
        None => {
            let text = format!("there is no step {kind} {target}");
            Err(CliError::usage_help(text, LIST))
        }
    }
}

fn one(plan: &Plan, spec: &SystemSpec, name: &str) -> Result<Subject, CliError> {
    let mut all: BTreeSet<&str> = plan.steps.iter().map(|s| s.target.as_str()).collect();
    all.extend(plan.changes.iter().map(|c| c.target.as_str()));
    all.extend(plan.waiting_on.iter().map(|w| w.target.as_str()));
    all.extend(plan.drift.iter().map(|d| d.target.as_str()));
    let named: Vec<&str> = all.into_iter().filter(|t| is_called(t, name)).collect();
    match named.as_slice() {
        [target] => Ok(Subject::Target((*target).to_owned())),
        [] => match settled(spec, name) {
            Some(target) => Ok(Subject::Settled(target)),
            None => {
                let text = format!("neither the plan nor the system has a {name}");
                Err(CliError::usage_help(text, LIST))
            }
        },
        several => {
            let text = format!("{name} may be {}", several.join(", "));
            Err(CliError::usage_help(text, "name it with its kind"))
        }
    }
}

/// A component or connector of the system.
fn settled(spec: &SystemSpec, name: &str) -> Option<String> {
    let components = spec.components.iter();
    let components = components.map(|c| rts_plan::target::component(&c.instance));
    let connectors = spec.connectors.iter();
    let connectors = connectors.map(|c| rts_plan::target::connector(&c.name));
    components.chain(connectors).find(|t| is_called(t, name))
}

/// `component/Sine0` and `Sine0` both mean `component/Sine0`.
fn is_called(target: &str, name: &str) -> bool {
    target == name || target.split_once('/').is_some_and(|(_, bare)| bare == name)
}

const LIST: &str = "`rtsctl explain FILE` lists the steps";
