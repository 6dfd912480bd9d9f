//! System objects: phase, conditions, progress.

use std::collections::{BTreeMap, BTreeSet};

use jiff::Timestamp;
use rts_controller_api::objects::{Kind, Metadata, Phase, Progress, System, SystemStatus, Waiting};
use rts_plan::observed::{ComponentObserved, ConnectorState, LifeCycleState, NodeObserved};
use rts_plan::plan::Step;
use rts_plan::target;
use rts_schemas::system::{ConnectorSpec, DriftPolicy, PortKind, PortRef};

use super::conditions::conditions;
use super::drift::{made_by_hand, misses, of_system, text};
use super::{Scene, object, waiting};
use crate::core::RunState;
use crate::execute::step;
use crate::reconcile::{Backoff, is_free_of};
use crate::sessions::NodeEntry;
use crate::store::SystemRecord;

/// Running steps that are shown.
const RUNNING: usize = 8;

/// One system.
pub fn system(
    scene: &Scene<'_>,
    backoff: &Backoff,
    record: &SystemRecord,
    before: Option<&System>,
    now: Timestamp,
) -> System {
    let before = before.filter(|before| before.metadata.uid == record.uid);
    let facts = Facts::gather(scene, backoff, record);
    let mut status = facts.status(scene, record);
    status.conditions = conditions(&facts, &status, record, before, now);
    let metadata = Metadata {
        name: record.name().to_owned(),
        uid: record.uid.clone(),
        resource_version: String::new(),
        generation: record.generation,
        labels: BTreeMap::new(),
        creation_timestamp: Some(record.created),
        deletion_timestamp: record.deleted,
    };
    object(Kind::System, metadata, record.spec.clone(), status)
}

/// What the status is made of.
pub struct Facts {
    /// The last plan was made for this generation.
    pub planned: bool,
    /// Steps are carried out, or will be at once.
    pending: bool,
    /// Differences that the last plan found.
    pub differences: usize,
    /// Nodes that it lies on now, or ever did; what was forgotten is not waited for.
    nodes: Vec<String>,
    /// Some node that it runs on cannot be asked.
    pub silent: bool,
    /// Some node that it runs on was there a moment ago, and is not now.
    lost: bool,
    /// What was changed by hand, and what becomes of it.
    pub drift: Vec<String>,
    /// Some of it is left as it is.
    pub left: bool,
    /// Why it is not healthy.
    pub unhealthy: Vec<String>,
    /// Something is on its way by itself.
    settling: bool,
    active: usize,
    /// What does not go on.
    pub waiting: Vec<Waiting>,
    progress: Progress,
}

impl Facts {
    fn gather(scene: &Scene<'_>, backoff: &Backoff, record: &SystemRecord) -> Self {
        let world = scene.world;
        let planned = world.planned.get(&record.uid) == Some(&record.generation);
        let mine = |system: Option<&str>| system == Some(record.name());
        let own = |step: &&Step| step.system.as_ref().is_some_and(|s| s.uid == record.uid);
        let steps = world.plan.steps.iter().filter(own).count();
        let run = world.runs.get(&record.uid);
        let resting = world.resting.contains(&record.uid);
        let known = |node| matches!(world.observed.nodes.get(node), Some(NodeObserved::Known(_)));
        let mut needed: BTreeMap<&str, bool> = BTreeMap::new();
        for (node, _, required) in waiting::seats(record, &world.placed) {
            *needed.entry(node).or_default() |= required;
        }
        // Nothing but optional components is there: what is not known of it is no fault of the system.
        let idle = |node: &String| needed.get(node.as_str()) == Some(&false);
        let ran = record.nodes.difference(&record.forgotten);
        let nodes: BTreeSet<&str> = needed
            .keys()
            .copied()
            .chain(ran.map(String::as_str))
            .collect();
        let drift = of_system(&scene.drifts, record.name());
        let refused = world.unadopted.get(&record.uid).map(String::as_str);
        let mut facts = Self {
            lost: record.nodes.iter().any(|node| {
                let entry = scene.nodes.get(node);
                !idle(node) && entry.is_some_and(NodeEntry::may_be_back)
            }),
            nodes: nodes.into_iter().map(str::to_owned).collect(),
            silent: !record.nodes.iter().all(|node| known(node) || idle(node)),
            planned,
            pending: run.is_some() || (steps > 0 && !resting),
            differences: world
                .plan
                .changes
                .iter()
                .filter(|change| mine(change.system.as_deref()))
                .count(),
            left: drift
                .iter()
                .any(|drift| drift.policy != DriftPolicy::Repair),
            drift: drift
                .into_iter()
                .map(|drift| text(drift, refused))
                .collect(),
            unhealthy: Vec::new(),
            settling: false,
            active: 0,
            waiting: waiting::of_system(&scene.reasons, backoff, record, &world.placed),
            progress: progress(run, steps),
        };
        facts.look(scene, record);
        facts
    }

    /// Looks at components and connectors as observed.
    fn look(&mut self, scene: &Scene<'_>, record: &SystemRecord) {
        let (components, connectors) = observed(scene, record);
        let all = record.spec.components.iter();
        let optional: BTreeSet<&str> = all
            .filter(|spec| !spec.required)
            .map(|spec| spec.instance.as_str())
            .collect();
        for spec in &record.spec.components {
            let found = components.get(spec.instance.as_str());
            let state = found.map(|found| found.state);
            if state == Some(LifeCycleState::Active) {
                self.active += 1;
            }
            if let Some(hangs) = found.and_then(|found| found.hangs.as_ref()) {
                self.unhealthy.push(format!("{} {hangs}", spec.instance));
            } else if state == Some(LifeCycleState::Active) {
                continue;
            } else if spec.required {
                let state = state.map_or("not there", super::components::state_name);
                let why = left(scene, record, &target::component(&spec.instance));
                let why = why.unwrap_or_else(|| format!("is {state}"));
                self.unhealthy.push(format!("{} {why}", spec.instance));
            }
        }
        // What leads to an optional component that does not run is as optional.
        let idle = |end: &PortRef| {
            let found = components.get(end.instance.as_str());
            let active = found.is_some_and(|c| c.state == LifeCycleState::Active);
            !active && optional.contains(end.instance.as_str())
        };
        let declared = undetermined(scene, record);
        // Service connectors are declared only: this version does not connect them.
        let counts = |spec: &&ConnectorSpec| {
            spec.kind == PortKind::Data
                && !declared.contains(spec.name.as_str())
                && !idle(&spec.source)
                && !idle(&spec.target)
        };
        for spec in record.spec.connectors.iter().filter(counts) {
            let state = match connectors.get(spec.name.as_str()) {
                Some(ConnectorState::Connected) => continue,
                Some(ConnectorState::Connecting) => "Connecting",
                _ => "not connected",
            };
            self.settling |= state == "Connecting";
            let why = left(scene, record, &target::connector(&spec.name));
            let why = why.unwrap_or_else(|| format!("is {state}"));
            self.unhealthy.push(format!("{} {why}", spec.name));
        }
    }

    /// True for what is no mere question of moments. A node or a process that is silent is serious at once, though an apply waits
    /// for it to come back.
    fn is_serious(&self, waiting: &Waiting) -> bool {
        !waiting.transient || self.lost || waiting.target.starts_with("manager/")
    }

    fn status(&self, scene: &Scene<'_>, record: &SystemRecord) -> SystemStatus {
        let mine: BTreeSet<&str> = self.waiting.iter().map(|w| w.target.as_str()).collect();
        let planned = &scene.world.plan.waiting_on;
        let held = !mine.is_empty() && planned.iter().any(|w| mine.contains(w.target.as_str()));
        let synced = self.planned && self.differences == 0 && !self.silent && !held;
        let healthy = self.unhealthy.is_empty();
        let phase = if record.deleted.is_some() {
            Phase::Terminating
        } else if self.pending || !self.planned || (scene.world.stale && !healthy) {
            Phase::Progressing
        } else if self.waiting.iter().any(|w| self.is_serious(w)) {
            Phase::Degraded
        } else if !self.waiting.is_empty() {
            Phase::Progressing
        } else if synced && healthy {
            Phase::Converged
        } else if self.settling || !synced {
            Phase::Progressing
        } else {
            Phase::Degraded
        };
        SystemStatus {
            observed_generation: scene.world.planned.get(&record.uid).copied().unwrap_or(0),
            phase,
            synced,
            healthy,
            conditions: Vec::new(),
            progress: self.progress.clone(),
            waiting_on: self.waiting.clone(),
            notes: notes(scene, record),
            drift: [self.drift.clone(), made_by_hand(scene, record)].concat(),
            check_index: record.index,
            tombstones: tombstones(scene, record),
            nodes: self.nodes.clone(),
            components: count(record.spec.components.len()),
            active: count(self.active),
            stand_ins: count(record.stand_ins.len()),
        }
    }
}

/// Connectors of a system at ports of stand-ins that nothing can be connected to.
fn undetermined<'a>(scene: &Scene<'a>, record: &SystemRecord) -> BTreeSet<&'a str> {
    let nodes = scene.world.placed.desired.nodes.values();
    let parts = nodes.flat_map(|node| &node.systems);
    parts
        .filter(|part| part.system.uid == record.uid)
        .flat_map(|part| &part.connectors)
        .filter(|connector| connector.undetermined.is_some())
        .map(|connector| connector.spec.name.as_str())
        .collect()
}

type Components<'a> = BTreeMap<&'a str, &'a ComponentObserved>;
type Connectors<'a> = BTreeMap<&'a str, ConnectorState>;

/// States of a system's components and connectors, where they are certain.
fn observed<'a>(scene: &Scene<'a>, record: &SystemRecord) -> (Components<'a>, Connectors<'a>) {
    let (mut components, mut connectors) = (BTreeMap::new(), BTreeMap::new());
    for (inventory, known) in scene.inventories.values() {
        let managers = inventory.managers.iter().filter(|m| *known && m.responsive);
        for component in managers.flat_map(|manager| &manager.components) {
            if component
                .system
                .as_ref()
                .is_none_or(|s| s.uid != record.uid)
            {
                continue;
            }
            components.insert(component.instance.as_str(), component);
            let own = component.connectors.iter();
            connectors.extend(own.map(|connector| (connector.name.as_str(), connector.state)));
        }
    }
    (components, connectors)
}

fn progress(run: Option<&RunState>, steps: usize) -> Progress {
    let Some(run) = run else {
        return Progress {
            done: 0,
            total: count(steps),
            running: Vec::new(),
        };
    };
    let progress = run.progress.lock();
    let running = progress.running.iter();
    let running = running.filter_map(|id| step(&run.plan, *id));
    Progress {
        done: count(progress.succeeded),
        total: count(run.plan.steps.len()),
        running: running
            .take(RUNNING)
            .map(|step| format!("{} {}", step.work.kind(), step.target))
            .collect(),
    }
}

/// Remarks of the placement, and those of the plan that speak of this system.
fn notes(scene: &Scene<'_>, record: &SystemRecord) -> Vec<String> {
    let placed = scene.world.placed.notes.get(record.name());
    let mut notes = placed.cloned().unwrap_or_default();
    let planned = &scene.world.plan.notes;
    if planned.is_empty() {
        return notes;
    }
    let components = record.spec.components.iter();
    let mine: BTreeSet<String> = components
        .map(|component| target::component(&component.instance))
        .chain([record.name().to_owned()])
        .collect();
    let speaks = |note: &&String| note.split([' ', ',', ':', ';']).any(|w| mine.contains(w));
    notes.extend(planned.iter().filter(speaks).cloned());
    notes
}

/// Why what a person took away stays away.
fn left(scene: &Scene<'_>, record: &SystemRecord, target: &str) -> Option<String> {
    let drift = scene.drifts.get(&(record.name(), target))?;
    misses(drift)
}

/// Nodes on which something of a deleted system may be left, once nothing is left where it can be asked, and none of them was
/// there a moment ago.
fn tombstones(scene: &Scene<'_>, record: &SystemRecord) -> Vec<String> {
    let mut silent = Vec::new();
    for node in record.nodes.difference(&record.forgotten) {
        match scene.world.observed.nodes.get(node) {
            Some(NodeObserved::Known(inventory)) if is_free_of(inventory, &record.uid) => {}
            Some(NodeObserved::Known(_)) => return Vec::new(),
            _ if scene.nodes.get(node).is_some_and(NodeEntry::may_be_back) => return Vec::new(),
            _ => silent.push(node.clone()),
        }
    }
    if record.deleted.is_some() {
        silent
    } else {
        Vec::new()
    }
}

fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}
