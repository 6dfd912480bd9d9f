//! Admission of a system: every reason to refuse it is found before anything is stored.

mod check;
mod describe;
mod identity;
mod modules;
mod places;
mod size;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rts_controller_api::requests::ApplyRequest;
use rts_controller_api::{Problem, ProblemError};
use rts_plan::observed::Observed;
use rts_plan::plan::Plan;
use rts_plan::{PlaceError, Placed};
use rts_schemas::system::SystemSpec;

pub use self::places::places_of_old;
use self::places::{kept, places};
use crate::core::Core;
use crate::moved;
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

/// A request that was checked against what agents say; nothing is decided yet.
pub struct Examined {
    candidate: SystemRecord,
    /// What was stored under its name.
    stored: Option<Version>,
    types: Types,
    found: modules::Found,
    observed: Observed,
}

/// Times that a request is examined when the system changes meanwhile.
pub const ATTEMPTS: usize = 8;

/// Node → types that it must have.
type Types = BTreeMap<String, BTreeSet<String>>;

/// What of a stored system an examination rests on: uid, generation, and whether it goes.
type Version = (String, u64, bool);

fn version(record: &SystemRecord) -> Version {
    let deleted = record.deleted.is_some();
    (record.uid.clone(), record.generation, deleted)
}

/// Checks a request, and says what would be done. Nothing is held up by it, and nothing is stored.
pub async fn admit(
    core: &Arc<Core>,
    name: &str,
    request: &ApplyRequest,
) -> Result<Admitted, Problem> {
    for _ in 0..ATTEMPTS {
        let examined = examine(core, name, request).await?;
        if let Some(admitted) = examined.decide(core)? {
            return Ok(admitted);
        }
    }
    Err(changed(name))
}

/// The system was changed by somebody else again and again while it was being examined.
pub fn changed(name: &str) -> Problem {
    let detail = format!("system {name} was changed by somebody else meanwhile; try again");
    Problem::unavailable("changed-meanwhile", detail)
}

/// Asks agents all that the decision needs. It may take seconds: nothing is locked meanwhile.
pub async fn examine(
    core: &Arc<Core>,
    name: &str,
    request: &ApplyRequest,
) -> Result<Examined, Problem> {
    let spec = &request.spec;
    refuse(check::spec(name, spec))?;
    let mut faults = check::orders(spec);
    faults.extend(size::parts(spec));
    let stored = core.registry().systems.get(name).cloned();
    let candidate = candidate(core, stored.as_ref(), spec);
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
    Ok(Examined {
        stored: stored.as_ref().map(version),
        found: found?,
        observed: core.observe().await,
        types,
        candidate,
    })
}

/// What would be stored, before its nodes and modules are known.
fn candidate(core: &Core, stored: Option<&SystemRecord>, spec: &SystemSpec) -> SystemRecord {
    let uid = || core.rng.uuid();
    SystemRecord {
        uid: stored.map_or_else(uid, |s| s.uid.clone()),
        generation: stored.map_or(0, |s| s.generation),
        spec: spec.clone(),
        digests: BTreeMap::new(),
        nodes: stored.map_or_else(BTreeSet::new, |s| s.nodes.clone()),
        created: stored.map_or_else(|| core.clock.now(), |s| s.created),
        deleted: None,
        forgotten: BTreeSet::new(),
        places: stored.map_or_else(BTreeMap::new, |s| kept(core, s, spec)),
        left: stored.map_or_else(BTreeMap::new, |s| s.left.clone()),
    }
}

impl Examined {
    /// Decides; nothing is waited for. The caller holds [`Core::admission`] when it means to store. None when the stored
    /// system has changed since: it must be examined again.
    pub fn decide(self, core: &Core) -> Result<Option<Admitted>, Problem> {
        let mut records = core.registry().systems.clone();
        let mut candidate = self.candidate;
        let name = candidate.name().to_owned();
        let stored = records.get(&name).cloned();
        if stored.as_ref().map(version) != self.stored {
            return Ok(None);
        }
        let placed = core.place(Some(&candidate));
        clashes(&placed, &candidate)?;
        if types_by_node(&placed, &candidate).0 != self.types {
            return Ok(None);
        }
        let places = places(&placed, &candidate.uid);
        if let Some(stored) = &stored {
            candidate.nodes.clone_from(&stored.nodes);
            candidate.places.clone_from(&stored.places);
            candidate.left.clone_from(&stored.left);
        }
        candidate.settle(places);
        candidate.digests = self.found.digests;
        candidate.nodes.extend(self.types.into_keys());
        let changed = stored.as_ref().is_none_or(|stored| {
            let old = (&stored.spec, &stored.digests, &stored.places);
            old != (&candidate.spec, &candidate.digests, &candidate.places)
        });
        if changed {
            candidate.generation += 1;
        }
        records.insert(name.clone(), candidate.clone());
        let placed = core.place_all(&records);
        if changed {
            size::whole(&placed, &candidate.uid, records.values())?;
        }
        let mut notes = placed.notes.get(&name).cloned().unwrap_or_default();
        notes.extend(self.found.notes);
        Ok(Some(Admitted {
            plan: moved::plan(core, &records, &placed.desired, &self.observed),
            record: candidate,
            changed,
            notes,
        }))
    }
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
    let records = core.registry().systems.clone();
    moved::plan(core, &records, &placed.desired, &observed)
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
