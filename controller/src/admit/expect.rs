//! What the one who applies has seen before, and relies on. Checked where the change is decided, so that nothing comes
//! between.

use std::collections::BTreeSet;
use std::sync::Arc;

use rts_controller_api::requests::Expect;
use rts_controller_api::{Problem, ProblemError};
use rts_plan::plan::{Action, Change, Plan, Restart, Step};
use sha2::{Digest, Sha256};

use super::check;
use crate::reconcile::by_system;
use crate::store::SystemRecord;

/// Refuses a change of a system that was changed since. `stored` is what is there now.
pub fn index(name: &str, stored: Option<&SystemRecord>, expect: &Expect) -> Result<(), Problem> {
    let Some(then) = expect.index else {
        return Ok(());
    };
    let now = stored.map_or(0, |record| record.index);
    if now == then {
        return Ok(());
    }
    let what = match (then, now) {
        (_, 0) => format!("it was at index {then} then, and there is none now"),
        (0, _) => format!("there was none then, and it is at index {now} now"),
        _ => format!("it was at index {then} then, and is at index {now} now"),
    };
    Err(stale(format!(
        "system {name} was changed since the plan was made: {what}; nothing was applied: plan again"
    )))
}

/// Refuses a change that would do something else than was planned, or restart what must not restart. `digest` gives
/// [`digest`] of the plan.
pub fn plan(
    expect: &Expect,
    record: &SystemRecord,
    plan: &Plan,
    digest: impl FnOnce() -> String,
) -> Result<(), Problem> {
    if let Some(then) = &expect.digest
        && *then != digest()
    {
        let name = record.name();
        return Err(stale(format!(
            "what is to be done for system {name} is not what was planned: the request, something that runs, or a node has \
             changed since; nothing was applied: plan again"
        )));
    }
    if expect.no_restart {
        return no_restart(record, plan);
    }
    Ok(())
}

/// Refuses to store a system as it runs when one of these targets is not as it would be stored.
pub fn untouched(
    record: &SystemRecord,
    plan: &Plan,
    targets: Option<&BTreeSet<String>>,
) -> Result<(), Problem> {
    let targets = targets.into_iter().flatten();
    let of = |target: &String, change: &Change| {
        change.target == *target && change.system.as_deref() == Some(record.name())
    };
    let mut touched = targets.filter(|t| plan.changes.iter().any(|change| of(t, change)));
    match touched.next() {
        None => Ok(()),
        Some(target) => Err(Problem::conflict(
            "drift-moved",
            format!("{target} has changed meanwhile, and would not stay as it is"),
        )),
    }
}

fn stale(detail: String) -> Problem {
    Problem::conflict("stale-plan", detail)
}

fn no_restart(record: &SystemRecord, plan: &Plan) -> Result<(), Problem> {
    let name = record.name();
    let own = plan.restarts.iter().filter(|restart| {
        let rest = restart.manager.strip_prefix(name);
        rest.is_some_and(|rest| rest.starts_with('.'))
    });
    let own: Vec<&Restart> = own.collect();
    let mut errors: Vec<ProblemError> = own.iter().map(|r| of_restart(record, r)).collect();
    let named = |target: &str| {
        let instance = target.strip_prefix("component/");
        let instance = instance.map(str::to_owned);
        instance.is_some_and(|i| own.iter().any(|restart| restart.components.contains(&i)))
    };
    let again = plan.changes.iter().filter(|change| {
        change.action == Action::Restart
            && change.system.as_deref() == Some(name)
            && change.target.starts_with("component/")
            && !named(&change.target)
    });
    errors.extend(again.map(|change| ProblemError {
        pointer: pointer(record, &change.target),
        code: "would-restart".to_owned(),
        detail: format!("{} is made again: {}", change.target, change.reason),
        help: None,
    }));
    let Some(first) = errors.first() else {
        return Ok(());
    };
    let more = match errors.len() {
        1 => String::new(),
        count => format!(" (and {} more)", count - 1),
    };
    let detail = format!(
        "to apply system {name} takes a restart: {}{more}; nothing was applied",
        first.detail
    );
    Err(Problem::conflict("would-restart", detail).with_errors(errors))
}

fn of_restart(record: &SystemRecord, restart: &Restart) -> ProblemError {
    let Restart { node, manager, .. } = restart;
    let names = restart.components.join(", ");
    let what = match (restart.pid, restart.components.len()) {
        (Some(pid), 0) => format!("manager/{manager} (pid {pid}) on node {node} restarts"),
        (Some(pid), _) => {
            format!("manager/{manager} (pid {pid}) on node {node} restarts with {names}")
        }
        (None, 1) => format!("{names} is made again in manager/{manager} on node {node}"),
        (None, _) => format!("{names} are made again in manager/{manager} on node {node}"),
    };
    let first = restart.components.first();
    ProblemError {
        pointer: first.map_or_else(String::new, |i| check::pointer(&record.spec, i)),
        code: "would-restart".to_owned(),
        detail: format!("{what}: {}", restart.reason),
        help: None,
    }
}

fn pointer(record: &SystemRecord, target: &str) -> String {
    let instance = target.strip_prefix("component/").unwrap_or(target);
    check::pointer(&record.spec, instance)
}

/// Names what is done to one system, and what is stored of it: what goes on in others makes no other plan of it. One that
/// is `new` has another uid each time it is planned, which makes no other plan, either.
pub fn digest(plan: &Arc<Plan>, record: &SystemRecord, new: bool) -> String {
    let own = |change: &&Change| change.system.as_deref() == Some(record.name());
    let part = by_system(plan).remove(&record.uid);
    let part = part.iter().flat_map(|part| &part.steps);
    let mut part = Plan {
        steps: part.map(Step::without_reasons).collect(),
        ..Plan::default()
    };
    part.changes = plan.changes.iter().filter(own).cloned().collect();
    for step in part.steps.iter_mut().filter(|_| new) {
        let manager = step.work.manager_mut();
        if let Some(system) = manager.and_then(|manager| manager.system.as_mut()) {
            system.uid.clear();
        }
    }
    // Nothing of a spec can fail to become JSON.
    let spec = serde_json::to_vec(&record.spec).unwrap_or_default();
    let mut sha = Sha256::new();
    sha.update(part.digest());
    sha.update(spec);
    format!("{:x}", sha.finalize())
}
