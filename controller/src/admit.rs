//! Admission of a system: every reason to refuse it is found before anything is stored.

mod check;
mod describe;
mod identity;
mod modules;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rts_controller_api::requests::ApplyRequest;
use rts_controller_api::{Problem, ProblemError};
use rts_plan::plan::Plan;
use rts_plan::{PlaceError, Placed};

use crate::core::Core;
use crate::store::SystemRecord;

/// A system that may be stored.
#[derive(Debug)]
pub struct Admitted {
    /// The record to store; the stored one when nothing changes.
    pub record: SystemRecord,
    /// False when the very same is stored already.
    pub changed: bool,
    /// What will be done.
    pub plan: Plan,
    /// Remarks of the placement.
    pub notes: Vec<String>,
}

/// Checks a request. The caller holds [`Core::admission`] when it means to store.
pub async fn admit(
    core: &Arc<Core>,
    name: &str,
    request: ApplyRequest,
) -> Result<Admitted, Problem> {
    let spec = request.spec;
    refuse(check::spec(name, &spec))?;
    let mut faults = check::orders(&spec);
    let stored = core.registry().systems.get(name).cloned();
    let mut candidate = SystemRecord {
        uid: stored
            .as_ref()
            .map_or_else(|| core.rng.uuid(), |s| s.uid.clone()),
        generation: stored.as_ref().map_or(0, |s| s.generation),
        spec,
        digests: BTreeMap::new(),
        nodes: stored
            .as_ref()
            .map_or_else(BTreeSet::new, |s| s.nodes.clone()),
        created: stored
            .as_ref()
            .map_or_else(|| core.clock.now(), |s| s.created),
        deleted: None,
        forgotten: BTreeSet::new(),
    };
    let placed = core.place(Some(&candidate));
    let (types, lost) = types_by_node(&placed, &candidate);
    faults.extend(lost);
    let found = modules::resolve(core, &candidate.spec, &types).await;
    // What is wrong with the system itself goes before what is in its way, and that before what may pass.
    if let Ok(found) = &found {
        faults.extend(found.missing.clone());
        let described = described(&placed, &candidate, found);
        faults.extend(describe::check(&candidate.spec, &described));
    }
    refuse(faults)?;
    if let Some(stored) = &stored {
        identity::check(stored, &candidate.spec, request.replace)?;
    }
    clashes(&placed, &candidate)?;
    let found = found?;
    candidate.digests = found.digests;
    candidate.nodes.extend(types.into_keys());
    let changed = stored
        .as_ref()
        .is_none_or(|stored| stored.spec != candidate.spec || stored.digests != candidate.digests);
    if changed {
        candidate.generation += 1;
    }
    let placed = core.place(Some(&candidate));
    let mut notes = placed.notes.get(name).cloned().unwrap_or_default();
    notes.extend(found.notes);
    Ok(Admitted {
        plan: plan(core, &placed).await,
        record: candidate,
        changed,
        notes,
    })
}

/// What the modules of a system's components say of themselves, as far as they say it.
fn described<'a>(
    placed: &'a Placed,
    candidate: &SystemRecord,
    found: &'a modules::Found,
) -> describe::Descriptions<'a> {
    let nodes = placed.desired.nodes.iter();
    let parts = nodes.flat_map(|(node, spec)| spec.systems.iter().map(move |part| (node, part)));
    parts
        .filter(|(_, part)| part.system.uid == candidate.uid)
        .flat_map(|(node, part)| part.components.iter().map(move |c| (node, &c.spec)))
        .filter_map(|(node, component)| {
            let description = found.described.get(node)?.get(&component.type_name)?;
            Some((component.instance.as_str(), description))
        })
        .collect()
}

/// What would be done now.
pub async fn plan(core: &Arc<Core>, placed: &Placed) -> Plan {
    let observed = core.observe().await;
    let blocked = core.backoff().blocked();
    rts_plan::plan(&placed.desired, &observed, &blocked)
}

/// Refuses a candidate that wants another system's instance names; a clash between two others is not its fault.
fn clashes(placed: &Placed, candidate: &SystemRecord) -> Result<(), Problem> {
    let mut clashes = Vec::new();
    for problem in &placed.problems {
        if let PlaceError::InstanceClash {
            instance, systems, ..
        } = problem
            && systems.iter().any(|system| system == candidate.name())
        {
            clashes.push(ProblemError {
                pointer: check::pointer(&candidate.spec, instance),
                code: "instance-clash".to_owned(),
                detail: problem.to_string(),
                help: Some("rename the instance, or tear the other system down".to_owned()),
            });
        }
    }
    let Some(first) = clashes.first() else {
        return Ok(());
    };
    let detail = summary(&first.detail, clashes.len());
    Err(Problem::conflict("instance-clash", detail).with_errors(clashes))
}

/// Types that each known node must have for a system, and a fault for each component on an unknown one.
fn types_by_node(
    placed: &Placed,
    candidate: &SystemRecord,
) -> (BTreeMap<String, BTreeSet<String>>, Vec<ProblemError>) {
    let mut faults = Vec::new();
    let mut unknown = BTreeSet::new();
    for problem in &placed.problems {
        if let PlaceError::UnknownNode {
            system,
            component,
            node,
            ..
        } = problem
            && system == candidate.name()
        {
            unknown.insert(node);
            faults.push(ProblemError {
                pointer: check::pointer(&candidate.spec, component),
                code: "unknown-node".to_owned(),
                detail: problem.to_string(),
                help: Some("start an agent on that node, or change rtsctl.node".to_owned()),
            });
        }
    }
    let mut types: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let known = placed.desired.nodes.iter();
    for (node, spec) in known.filter(|(node, _)| !unknown.contains(node)) {
        let parts = spec.systems.iter();
        for part in parts.filter(|part| part.system.uid == candidate.uid) {
            for component in &part.components {
                let of_node = types.entry(node.clone()).or_default();
                of_node.insert(component.spec.type_name.clone());
            }
        }
    }
    (types, faults)
}

/// All faults as one problem; its code is theirs when they agree.
fn refuse(faults: Vec<ProblemError>) -> Result<(), Problem> {
    let Some(first) = faults.first() else {
        return Ok(());
    };
    let same = faults.iter().all(|fault| fault.code == first.code);
    let code = if same { &first.code } else { "invalid-system" };
    Err(Problem::invalid(code, summary(&first.detail, faults.len())).with_errors(faults))
}

fn summary(first: &str, count: usize) -> String {
    match count {
        0 | 1 => first.to_owned(),
        n => format!("{first} (and {} more)", n - 1),
    }
}
