//! What of a plan is a system's own: a plan may speak of other systems too.

use std::collections::BTreeSet;

use rts_controller_api::requests::PlanResult;
use rts_plan::plan::{Drift, Plan};
use rts_schemas::system::{DriftPolicy, SystemSpec};

use crate::local::plural;
use crate::output::Output;

/// An answer without what was changed by hand in other systems, and without the remarks on them, as far as they can be
/// told.
pub(super) fn of(result: &PlanResult, spec: &SystemSpec) -> PlanResult {
    let mut own = result.clone();
    let others = others(&result.plan, spec);
    own.plan.drift.retain(|drift| drift.system == spec.name);
    own.plan
        .notes
        .retain(|note| !is_foreign(note, spec, &others));
    own.notes.retain(|note| !is_foreign(note, spec, &others));
    own
}

/// The other systems that a plan speaks of.
fn others<'p>(plan: &'p Plan, spec: &SystemSpec) -> BTreeSet<&'p str> {
    let changes = plan.changes.iter().filter_map(|c| c.system.as_deref());
    let steps = plan.steps.iter().filter_map(|s| s.system.as_ref());
    let drifts = plan.drift.iter().map(|d| d.system.as_str());
    let all = changes.chain(steps.map(|s| s.name.as_str())).chain(drifts);
    all.filter(|name| *name != spec.name).collect()
}

/// True for a remark that names another system, or a manager of one, and not this one.
fn is_foreign(note: &str, spec: &SystemSpec, others: &BTreeSet<&str>) -> bool {
    let words: Vec<&str> = note.split([' ', ',', ':', ';']).collect();
    let mut foreign = false;
    for pair in words.windows(2) {
        let system = match pair[0] {
            "manager" => pair[1].split_once('.').map(|(system, _)| system),
            "system" => Some(pair[1]).filter(|name| *name == spec.name || others.contains(name)),
            _ => None,
        };
        match system {
            Some(name) if name == spec.name => return false,
            Some(_) => foreign = true,
            None => {}
        }
    }
    foreign
}

/// True when a plan has something to do, or something that waits, for a system; other systems' affairs do not count. Nor
/// does what a person changed by hand and may keep.
pub fn concerns(plan: &Plan, spec: &SystemSpec) -> bool {
    let own = |system: Option<&str>| system.is_none_or(|system| system == spec.name);
    plan.changes.iter().any(|c| own(c.system.as_deref()))
        || plan
            .steps
            .iter()
            .any(|s| own(s.system.as_ref().map(|s| s.name.as_str())))
        || plan.waiting_on.iter().any(|w| is_of(&w.target, spec))
        || plan
            .drift
            .iter()
            .any(|d| d.system == spec.name && !is_left(d))
}

/// Nothing comes of it: it is ignored, or it is a state, which no profile can adopt.
fn is_left(drift: &Drift) -> bool {
    match drift.policy {
        DriftPolicy::Repair => false,
        DriftPolicy::Ignore => true,
        DriftPolicy::Adopt => {
            !drift.fields.is_empty() && drift.fields.iter().all(|f| f.field == "state")
        }
    }
}

/// True when a target is a part of the system, or something that it may need.
fn is_of(target: &str, spec: &SystemSpec) -> bool {
    let (kind, name) = target.split_once('/').unwrap_or((target, ""));
    let at = name.rsplit_once('@');
    match kind {
        "component" => spec.components.iter().any(|c| c.instance == name),
        "connector" => spec.connectors.iter().any(|c| c.name == name),
        "manager" => owns(spec, name),
        "module" => at.is_some_and(|(_, manager)| owns(spec, manager)),
        "package" => at
            .is_some_and(|(type_name, _)| spec.components.iter().any(|c| c.type_name == type_name)),
        // Which nodes it needs is for the controller to know: rather a difference too many than one that is hidden.
        _ => true,
    }
}

fn owns(spec: &SystemSpec, manager: &str) -> bool {
    manager
        .split_once('.')
        .is_some_and(|(system, _)| system == spec.name)
}

/// Says what restarts, and what a person changed by hand, once that is decided.
pub fn tell(plan: &Plan, spec: &SystemSpec, out: &Output) {
    let drift = plan.drift.iter().filter(|d| d.system == spec.name);
    for drift in drift {
        out.say(&format!("drift: {}", rts_plan::render::drift(drift)));
    }
    for line in restarts(plan, spec) {
        out.say(&line);
    }
}

/// A line for each process of a system that restarts, with what that stops.
pub(super) fn restarts(plan: &Plan, spec: &SystemSpec) -> Vec<String> {
    let own = plan.restarts.iter().filter(|r| owns(spec, &r.manager));
    own.map(rts_plan::render::restart).collect()
}

/// Says what would restart, where that is refused.
pub fn tell_refused(plan: &Plan, spec: &SystemSpec, out: &Output) {
    for line in restarts(plan, spec) {
        out.say(&line.replacen("restarts:", "would restart:", 1));
    }
}

/// What would restart, in few words (`1 process would restart, 2 components would be made again`). None for nothing.
pub fn would_restart(plan: &Plan, spec: &SystemSpec) -> Option<String> {
    let own = plan.restarts.iter().filter(|r| owns(spec, &r.manager));
    let (ends, goes_on): (Vec<_>, Vec<_>) = own.partition(|r| r.pid.is_some());
    let again = goes_on.iter().map(|r| r.components.len()).sum();
    let mut parts = Vec::new();
    match ends.len() {
        0 => {}
        1 => parts.push("1 process would restart".to_owned()),
        count => parts.push(format!("{count} processes would restart")),
    }
    if again > 0 {
        parts.push(format!(
            "{} would be made again",
            plural("component", again)
        ));
    }
    (!parts.is_empty()).then(|| parts.join(", "))
}
