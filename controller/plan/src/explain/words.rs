//! Rules and needs in words.

use crate::plan::{Limit, OnTimeout, OrderName, Plan, Rule, Step};
use crate::render::steps::milliseconds;

/// A rule by which the first step stands before the second.
pub(super) fn rule(rule: Rule, first: &Step, second: &Step) -> String {
    let (one, other) = (bare(first), bare(second));
    match rule {
        Rule::Sequence { order } => format!(
            "order {}: {one} has a lower sequence number than {other}",
            order.element()
        ),
        Rule::Sync { order } => format!(
            "order {}: {other} has a Preceding with SYNC, which waits until {one} {}",
            order.element(),
            reached(order)
        ),
        Rule::Async { order } => format!(
            "order {}: {other} has a Preceding with ASYNC, which waits until {one} was asked",
            order.element()
        ),
        Rule::ProviderFirst => {
            "preference: a service provider comes up before its consumers, and goes down after them"
                .to_owned()
        }
        Rule::DownStreamFirst => {
            "preference: what a source feeds comes up before the source".to_owned()
        }
        Rule::UpStreamFirst => "preference: a source goes down before what it feeds".to_owned(),
    }
}

/// What has become of a component when an order's action has succeeded.
fn reached(order: OrderName) -> &'static str {
    match order {
        OrderName::StartUp | OrderName::Initializing => "is initialised",
        OrderName::Activation => "is Active",
        OrderName::Deactivation => "is Inactive",
        OrderName::Resetting => "is out of Error",
        OrderName::ShutDown | OrderName::Finalizing => "is gone",
    }
}

/// The name without its kind.
fn bare(step: &Step) -> &str {
    let name = step.target.split_once('/');
    name.map_or(&step.target, |(_, name)| name)
}

/// Why the work of the second step rests on the first, by their kinds.
pub(super) fn rests_on(first: &Step, second: &Step) -> &'static str {
    let same = first.target == second.target;
    match (first.work.kind(), second.work.kind()) {
        ("Install", _) => "its module file must be on the node",
        ("StartManager", "LoadModule") => "its process must run",
        ("StartManager", _) => "the process must run",
        ("LoadModule", "Create") => "its module must be loaded",
        ("LoadModule", _) => "the module must be loaded",
        ("Create", "Connect") => "both of its ends must be there",
        ("Create", _) => "it must be there",
        ("Configure", "Activate") if same => "it must be configured before it runs",
        ("Configure", _) => "the component must be configured",
        ("Connect", "Activate") => "its connectors must be connected before it runs",
        ("Connect", _) => "the connector must be connected",
        ("Activate", _) => "the other one must be Active",
        ("Reset", _) => "it must be out of Error",
        ("Deactivate", "Disconnect") => {
            "a component must stand still before its connectors are cut"
        }
        ("Deactivate", "Delete") if same => "it must stand still before it is deleted",
        ("Deactivate", _) => "the component must stand still",
        ("Disconnect", "Connect") => "the old connector must be gone",
        ("Disconnect", "Delete") => "its connectors must be cut",
        ("Disconnect", _) => "the connector must be cut",
        ("Delete", "Create") => "the old instance must be gone",
        ("Delete", "StopManager") => "what is in the process must be gone",
        ("Delete", "UnloadModule") => "what was made from the module must be gone",
        ("Delete", "Unbind") => "its source must be gone",
        ("Unbind", "Connect") => "the old end at the in-port must be gone",
        ("Unbind", _) => "the end at the in-port must be gone",
        ("Delete", _) => "the component must be gone",
        ("UnloadModule", _) => "the old module must be unloaded",
        ("StopManager", "StartManager") => "the old process must have ended",
        ("StopManager", _) => "the process must have ended",
        _ => "it rests on that",
    }
}

/// `waits at most 500 ms for Activate component/Sensor0 (4), then fails and is tried again`.
pub(super) fn limit(limit: &Limit, plan: &Plan) -> String {
    let name = |id: &u32| match super::step_of(plan, *id) {
        Some(step) => format!("{} {} ({id})", step.work.kind(), step.target),
        None => id.to_string(),
    };
    let names: Vec<String> = limit.steps.iter().map(name).collect();
    let then = match limit.then {
        OnTimeout::Fail => "fails, and is tried again later",
        OnTimeout::GoOn => "goes on without",
    };
    let time = milliseconds(u64::from(limit.ms));
    format!("waits at most {time} for {}, then {then}", names.join(", "))
}
