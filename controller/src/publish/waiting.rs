//! What does not go on, and why: the planner's word, failed targets in back-off, and nodes that refuse.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};

use rts_controller_api::objects::Waiting;
use rts_plan::Placed;
use rts_plan::desired::ManagerKey;
use rts_plan::observed::{Held, NodeObserved};
use rts_plan::target;
use tokio::time::Instant;

use super::drift;
use crate::core::World;
use crate::placement::reference;
use crate::reconcile::{Backoff, Entry, target_of};
use crate::sessions::NodeEntry;
use crate::store::SystemRecord;

/// How the planner's reason ends when a component stays in Error until somebody resets it.
const STAYS: &str = "(rtsctl.resetOnError is off)";

/// Why a target does not go on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reason {
    /// For people.
    pub text: String,
    /// It is expected to pass by itself within moments.
    pub transient: bool,
}

impl Reason {
    /// True when nothing tries it again by itself.
    fn stays(&self) -> bool {
        self.text.ends_with(STAYS)
    }
}

/// Target → reason, over all systems.
pub fn reasons(
    world: &World,
    backoff: &Backoff,
    nodes: &BTreeMap<String, NodeEntry>,
) -> BTreeMap<String, Reason> {
    let unsure: Vec<String> = nodes
        .iter()
        .filter(|(_, entry)| entry.unsure() || entry.may_be_back())
        .map(|(node, _)| format!("node {node} is unknown"))
        .collect();
    let silent: Vec<(String, String)> = world
        .silence
        .of_a_moment()
        .into_iter()
        .map(|name| (format!("manager/{name}"), format!("manager {name} ")))
        .collect();
    let answers_soon = |target: &str, text: &str| {
        let own = |(manager, words): &(String, String)| {
            manager == target || (text.contains(words) && text.contains("does not answer"))
        };
        silent.iter().any(own)
    };
    let planned = world.plan.waiting_on.iter();
    let mut reasons: BTreeMap<_, _> = planned
        .map(|waiting| {
            let text = waiting.reason.clone();
            let node = waiting.target.replacen('/', " ", 1) + " is unknown";
            let asked = unsure.iter().any(|u| *u == node || text.contains(u));
            let transient = waiting.transient || asked || answers_soon(&waiting.target, &text);
            (waiting.target.clone(), Reason { text, transient })
        })
        .collect();
    // Once its time has come, only a plan with steps for it says that it is still about to be tried.
    let now = Instant::now();
    let runs = world.runs.values().map(|run| &run.plan);
    let plans = || runs.clone().chain([&world.plan]);
    let steps = || plans().flat_map(|plan| &plan.steps);
    // Most of the time nothing has failed, and nobody asks.
    let tried: OnceCell<BTreeSet<&str>> = OnceCell::new();
    let tried = || tried.get_or_init(|| steps().map(|step| step.target.as_str()).collect());
    for (key, entry) in backoff.failing() {
        let target = target_of(key);
        // That its last try failed is how it came to be in Error.
        if reasons.get(target).is_some_and(Reason::stays) {
            continue;
        }
        if entry.blocks(now) || tried().contains(target) {
            reasons.insert(target.to_owned(), lasting(&entry.reason));
        }
    }
    for drift in &world.plan.drift {
        if let Some(why) = drift::misses(drift) {
            reasons.insert(drift.target.clone(), lasting(&why));
        }
    }
    for held in held(world) {
        reasons.insert(target::component(&held.instance), lasting(&held.reason));
    }
    for (node, fault) in &world.faults {
        let reason = Reason {
            text: fault.reason.clone(),
            transient: fault.may_pass(),
        };
        reasons.insert(target::node(node), reason);
    }
    reasons
}

/// What agents do not bring up again.
fn held(world: &World) -> impl Iterator<Item = &Held> {
    let known = world.observed.nodes.values().map(|node| match node {
        NodeObserved::Known(inventory) => &inventory.held[..],
        NodeObserved::Unknown { .. } => &[],
    });
    let wanted = |held: &&Held| world.planned.contains_key(&held.system.uid);
    known.flatten().filter(wanted)
}

fn lasting(text: &str) -> Reason {
    Reason {
        text: text.to_owned(),
        transient: false,
    }
}

/// What of one system does not go on.
pub fn of_system(
    reasons: &BTreeMap<String, Reason>,
    backoff: &Backoff,
    record: &SystemRecord,
    placed: &Placed,
) -> Vec<Waiting> {
    if reasons.is_empty() {
        return Vec::new();
    }
    let index = Index::new(record, placed);
    let now = Instant::now();
    let mut failing: BTreeMap<&str, Vec<&Entry>> = BTreeMap::new();
    for (key, entry) in backoff.failing() {
        failing.entry(target_of(key)).or_default().push(entry);
    }
    reasons
        .iter()
        .filter_map(|(target, reason)| {
            let known = || failing.get(target.as_str()).into_iter().flatten().copied();
            let own = |entry: &&Entry| entry.system.as_deref() == Some(record.name());
            let foreign = known().any(|entry| entry.system.is_some());
            let entry = known().find(own);
            if entry.is_none() && (foreign || !index.concerns(target)) {
                return None;
            }
            let entry = entry.or_else(|| known().next());
            let blocks = entry.filter(|entry| entry.blocks(now) && !reason.stays());
            Some(Waiting {
                target: target.clone(),
                reason: reason.text.clone(),
                required: index.required(target),
                transient: reason.transient,
                tries: entry.map_or(0, |entry| entry.tries),
                next_try: blocks.map(|entry| entry.next_try),
            })
        })
        .collect()
}

/// What targets mean to a system, by name: true when it cannot be healthy without.
struct Index<'a> {
    record: &'a SystemRecord,
    components: BTreeMap<&'a str, bool>,
    types: BTreeMap<&'a str, bool>,
    connectors: BTreeMap<&'a str, bool>,
    nodes: BTreeMap<&'a str, bool>,
    /// By the names that people use.
    managers: BTreeMap<String, bool>,
}

impl<'a> Index<'a> {
    fn new(record: &'a SystemRecord, placed: &'a Placed) -> Self {
        let (mut nodes, mut managers) = (BTreeMap::new(), BTreeMap::new());
        for (node, manager, required) in seats(record, placed) {
            *nodes.entry(node).or_default() |= required;
            *managers.entry(manager).or_default() |= required;
        }
        let system = Some(reference(record));
        let managers = managers.into_iter().map(|(name, required)| {
            let (system, name) = (system.clone(), name.to_owned());
            (ManagerKey { system, name }.display_name(), required)
        });
        let mut components = BTreeMap::new();
        let mut types = BTreeMap::new();
        for component in &record.spec.components {
            components.insert(component.instance.as_str(), component.required);
            *types.entry(component.type_name.as_str()).or_default() |= component.required;
        }
        let needed = |instance: &String| components.get(instance.as_str()) == Some(&true);
        let connectors = record.spec.connectors.iter();
        Self {
            record,
            connectors: connectors
                .map(|c| {
                    (
                        c.name.as_str(),
                        needed(&c.source.instance) && needed(&c.target.instance),
                    )
                })
                .collect(),
            components,
            types,
            nodes,
            managers: managers.collect(),
        }
    }

    /// True when a target belongs to the system.
    fn concerns(&self, target: &str) -> bool {
        let (kind, rest) = target.split_once('/').unwrap_or((target, ""));
        let at = rest.rsplit_once('@');
        match kind {
            "component" => self.components.contains_key(rest),
            "connector" => self.connectors.contains_key(rest),
            "manager" => self.owns(rest),
            "module" => at.is_some_and(|(_, manager)| self.owns(manager)),
            "package" => at.is_some_and(|(type_name, node)| {
                self.record.nodes.contains(node) && self.types.contains_key(type_name)
            }),
            "node" => self.record.nodes.contains(rest),
            _ => false,
        }
    }

    fn owns(&self, manager: &str) -> bool {
        let rest = manager.strip_prefix(self.record.name());
        rest.is_some_and(|rest| rest.starts_with('.'))
    }

    /// True when the system cannot be healthy without a target.
    fn required(&self, target: &str) -> bool {
        let (kind, rest) = target.split_once('/').unwrap_or((target, ""));
        let found = match kind {
            "component" => self.components.get(rest),
            "connector" => self.connectors.get(rest),
            "module" | "package" => {
                let type_name = rest.rsplit_once('@').map_or(rest, |(name, _)| name);
                self.types.get(type_name)
            }
            "manager" => self.managers.get(rest),
            "node" => self.nodes.get(rest),
            _ => None,
        };
        found.copied().unwrap_or(true)
    }
}

/// Node and process of each component of a system, and whether that is required.
pub fn seats<'a>(
    record: &'a SystemRecord,
    placed: &'a Placed,
) -> impl Iterator<Item = (&'a str, &'a str, bool)> {
    let nodes = placed.desired.nodes.iter();
    let parts = nodes.flat_map(|(node, spec)| spec.systems.iter().map(move |part| (node, part)));
    let own = parts.filter(|(_, part)| part.system.uid == record.uid);
    own.flat_map(|(node, part)| {
        let components = part.components.iter();
        components.map(move |component| {
            let manager = component.manager.as_str();
            (node.as_str(), manager, component.spec.required)
        })
    })
}
