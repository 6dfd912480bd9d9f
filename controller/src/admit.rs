//! Admission of a system: every reason to refuse it is found before anything is stored.

mod act;
mod check;
mod describe;
mod expect;
mod identity;
mod modules;
mod narrow;
mod placed;
mod places;
mod reach;
mod silent;
mod size;
mod stand_ins;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use futures_util::future::join;
use rts_controller_api::requests::{ApplyRequest, Expect};
use rts_controller_api::{Problem, ProblemError};
use rts_host::timing::TARGET;
use rts_plan::observed::Observed;
use rts_plan::plan::Plan;
use rts_schemas::stand_in::shapes;
use rts_schemas::system::SystemSpec;
use tracing::{Instrument, info_span};

pub use self::act::act;
use self::placed::{Types, clashes, described, needs};
pub use self::places::places_of_old;
use self::places::{kept, places};
use crate::core::Core;
use crate::moved;
use crate::placement::Placement;
use crate::store::SystemRecord;

/// A system that may be stored.
#[derive(Debug)]
pub struct Admitted {
    /// The record to store; the stored one when nothing changes.
    pub record: Arc<SystemRecord>,
    /// False when the very same is stored already.
    pub changed: bool,
    /// What will be done.
    pub plan: Arc<Plan>,
    /// Remarks of the placement.
    pub notes: Vec<String>,
    /// To store it forgets what failed of the system: it is another wish. What is stored as it runs is none.
    pub forgets: bool,
    /// There was none of its name; until it is stored, its uid is given for this once.
    new: bool,
    /// It is asked for once more when the record is stored, and when that is carried out.
    _placed: Arc<Placement>,
}

impl Admitted {
    /// Names what will be done to the system.
    pub fn digest(&self) -> String {
        expect::digest(&self.plan, &self.record, self.new)
    }
}

/// A request that was checked against what agents say; nothing is decided yet.
pub struct Examined {
    candidate: SystemRecord,
    /// What was stored under its name.
    stored: Option<Version>,
    types: Types,
    found: modules::Found,
    observed: Observed,
    expect: Expect,
    /// It is to be stored as it runs: targets that must not be touched for it.
    untouched: Option<BTreeSet<String>>,
    /// It is asked for once more when it is decided.
    _placed: Arc<Placement>,
}

/// Times that a request is examined when the system changes meanwhile.
pub const ATTEMPTS: usize = 8;

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
        if let Some(admitted) = examined.decide(core).await? {
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
    // What may be taken back is nothing to build on.
    core.durable(name).await;
    let stored = core.registry().systems.get(name).cloned();
    let spec = &Arc::new(narrow::narrow(stored.as_deref(), request)?);
    refuse(check::spec(name, spec))?;
    expect::index(name, stored.as_deref(), &request.expect)?;
    let mut faults = check::orders(spec);
    faults.extend(size::parts(spec));
    let candidate = candidate(core, stored.as_deref(), spec);
    let placed = core.place(Some(&candidate));
    let needs = needs(&placed, &candidate);
    faults.extend(needs.faults);
    faults.extend(reach::reach(
        &placed,
        &candidate,
        &core.sessions.transports(),
    ));
    let types = needs.types;
    let found = modules::resolve(core, &candidate.spec, &types);
    let found = found.instrument(info_span!(target: TARGET, "modules"));
    let look = core.observe();
    let look = look.instrument(info_span!(target: TARGET, "look"));
    // One does not wait for the other.
    let (found, observed) = join(found, look).await;
    // What is wrong with the system itself goes before what is in its way, and that before what may pass.
    if let Ok(found) = &found {
        faults.extend(found.missing.clone());
        let described = described(&placed, &candidate, found);
        faults.extend(describe::check(&candidate.spec, &described));
    }
    refuse(faults)?;
    if let Some(stored) = &stored {
        // Of what was asked for, also where that is narrowed to a part.
        identity::check(stored, &request.spec, request.replace)?;
    }
    clashes(&placed, &candidate)?;
    Ok(Examined {
        stored: stored.as_deref().map(version),
        found: found?,
        observed,
        expect: request.expect.clone(),
        untouched: None,
        types,
        candidate,
        _placed: placed,
    })
}

/// What would be stored, before its nodes and modules are known.
fn candidate(core: &Core, stored: Option<&SystemRecord>, spec: &Arc<SystemSpec>) -> SystemRecord {
    let uid = || core.rng.uuid();
    SystemRecord {
        uid: stored.map_or_else(uid, |s| s.uid.clone()),
        generation: stored.map_or(0, |s| s.generation),
        index: stored.map_or(0, |s| s.index),
        spec: Arc::clone(spec),
        digests: BTreeMap::new(),
        stand_ins: BTreeMap::new(),
        nodes: stored.map_or_else(BTreeSet::new, |s| s.nodes.clone()),
        created: stored.map_or_else(|| core.clock.now(), |s| s.created),
        deleted: None,
        forgotten: BTreeSet::new(),
        places: stored.map_or_else(BTreeMap::new, |s| kept(core, s, spec)),
        left: stored.map_or_else(BTreeMap::new, |s| s.left.clone()),
    }
}

impl Examined {
    /// The same for a system that is to be stored as it runs: these targets must not be touched for it, and a module
    /// file that has changed since is no reason to restart anything.
    pub fn leaving(mut self, targets: BTreeSet<String>) -> Self {
        self.untouched = Some(targets);
        self
    }

    /// Decides; only a large plan is waited for. The caller holds [`Core::admission`] when it means to store. None when the stored
    /// system has changed since: it must be examined again.
    pub async fn decide(self, core: &Core) -> Result<Option<Admitted>, Problem> {
        let span = info_span!(target: TARGET, "decide");
        self.decided(core).instrument(span).await
    }

    async fn decided(self, core: &Core) -> Result<Option<Admitted>, Problem> {
        let mut records = core.registry().systems.clone();
        let mut candidate = self.candidate;
        let name = candidate.name().to_owned();
        let stored = records.get(&name).cloned();
        if stored.as_deref().map(version) != self.stored {
            return Ok(None);
        }
        expect::index(&name, stored.as_deref(), &self.expect)?;
        let placed = core.place(Some(&candidate));
        clashes(&placed, &candidate)?;
        let needs = needs(&placed, &candidate);
        if needs.types != self.types {
            return Ok(None);
        }
        let places = places(&placed, &candidate.uid);
        if let Some(stored) = &stored {
            candidate.index = stored.index;
            candidate.nodes.clone_from(&stored.nodes);
            candidate.places.clone_from(&stored.places);
            candidate.left.clone_from(&stored.left);
        }
        candidate.settle(places);
        candidate.digests = match stored.as_ref().filter(|_| self.untouched.is_some()) {
            Some(stored) => stored.digests.clone(),
            None => self.found.pinned(stored.as_deref(), &self.observed),
        };
        candidate.stand_ins = match stored.as_ref().filter(|_| self.untouched.is_some()) {
            Some(stored) => stored.stand_ins.clone(),
            None => {
                let instances = self.found.stand_ins(stored.as_deref());
                let before = stored.as_ref().map(|stored| stored.stand_ins.clone());
                shapes(&candidate.spec, &instances, &before.unwrap_or_default())
            }
        };
        stand_ins::within(&candidate, self.expect.max_stand_ins)?;
        candidate.nodes.extend(self.types.into_keys());
        let changed = stored.as_ref().is_none_or(|stored| {
            let wish = (&stored.spec, &stored.places) == (&candidate.spec, &candidate.places);
            let kept = (&stored.digests, &stored.stand_ins);
            !wish || kept != (&candidate.digests, &candidate.stand_ins)
        });
        if changed {
            candidate.generation += 1;
        }
        // What stays is the same object, so that what was made of it is found again.
        let candidate = match stored.as_ref().filter(|_| !changed) {
            Some(stored) => Arc::clone(stored),
            None => Arc::new(candidate),
        };
        records.insert(name.clone(), Arc::clone(&candidate));
        let placed = core.place_all(&records);
        if changed {
            size::whole(&placed, &candidate.uid, records.values().map(Arc::as_ref))?;
        }
        let mut notes = placed.notes.get(&name).cloned().unwrap_or_default();
        notes.extend(needs.notes);
        notes.extend(self.found.notes);
        let forgets = changed && self.untouched.is_none();
        let forgotten = forgets.then_some(name.as_str());
        let blocked = moved::blocked(core, &records, &self.observed, forgotten);
        let mut plan = moved::plan(&placed, &self.observed, blocked).await;
        let touched = expect::untouched(&candidate, &plan, self.untouched.as_ref());
        if let Some(stored) = stored.as_ref().filter(|_| changed) {
            silent::tell(&mut plan, stored, &candidate);
        }
        let admitted = Admitted {
            plan: Arc::new(plan),
            new: stored.is_none(),
            record: candidate,
            changed,
            notes,
            forgets,
            _placed: placed,
        };
        let Admitted { plan, record, .. } = &admitted;
        expect::plan(&self.expect, record, plan, || admitted.digest())?;
        touched?;
        Ok(Some(admitted))
    }
}

/// What would be done now, if nothing is applied; none when there is no such system.
pub async fn stored(core: &Arc<Core>, name: &str) -> Option<Admitted> {
    let observed = core.observe().await;
    // Without an await between them, all speak of the same records.
    let records = core.registry().systems.clone();
    let record = records.get(name)?.clone();
    let placed = core.place_all(&records);
    let blocked = moved::blocked(core, &records, &observed, None);
    Some(Admitted {
        plan: Arc::new(moved::plan(&placed, &observed, blocked).await),
        notes: placed.notes.get(name).cloned().unwrap_or_default(),
        changed: false,
        forgets: false,
        new: false,
        record,
        _placed: placed,
    })
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
