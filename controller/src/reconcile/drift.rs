//! What was changed by hand: told once, and taken into the stored system where its policy says so.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use rts_controller_api::Problem;
use rts_plan::observed::{NodeObserved, Observed};
use rts_plan::plan::{Drift, DriftKind, Plan};
use rts_plan::target;
use rts_schemas::system::DriftPolicy;
use tokio::task::JoinSet;
use tokio::time::Instant;

use super::Stamp;
use crate::apply;
use crate::core::Core;
use crate::publish::drift::told;
use crate::store::SystemRecord;
use crate::view::Happening;

/// A system that does not take in what was changed by hand is asked again after this time.
const AGAIN: Duration = Duration::from_secs(60);
/// The same where what is in the way may pass, such as a node that does not answer.
const SOON: Duration = Duration::from_secs(15);

/// The drift that is known. None of it is needed after a restart: what is there is told once more.
pub struct Drifts {
    core: Arc<Core>,
    /// System uid and target → what was told of it, and of which generation.
    told: BTreeMap<(String, String), (Drift, u64)>,
    tasks: JoinSet<Taken>,
    /// Systems, by uid, that are being asked to take it in.
    asked: BTreeSet<String>,
    /// The same that did not, why, and until when they are left alone.
    refused: BTreeMap<String, Refusal>,
}

/// A system was asked to take in what was changed by hand.
struct Taken {
    uid: String,
    asked: Asked,
    /// Nodes that answered then.
    known: BTreeSet<String>,
    result: Result<u64, Problem>,
}

/// For what: of which generation, and which drift.
#[derive(Debug, Clone, PartialEq)]
struct Asked {
    generation: u64,
    drift: Vec<Drift>,
}

struct Refusal {
    asked: Asked,
    /// It was told.
    told: bool,
    until: Instant,
    /// What is in the way may pass: nodes that answered, of which more may change it.
    passes: Option<BTreeSet<String>>,
    /// What is in the way.
    why: String,
}

impl Refusal {
    /// Asking once more would say the same.
    fn holds(&self, asked: &Asked, known: &BTreeSet<String>) -> bool {
        let passes = self.passes.as_ref();
        let back = passes.is_some_and(|then| !known.is_subset(then));
        self.asked == *asked && !back && Instant::now() < self.until
    }
}

impl Drifts {
    /// None is known yet.
    pub fn new(core: Arc<Core>) -> Self {
        Self {
            core,
            told: BTreeMap::new(),
            tasks: JoinSet::new(),
            asked: BTreeSet::new(),
            refused: BTreeMap::new(),
        }
    }

    /// Takes in what a plan found. What the plan was made for is `stamps`, by uid.
    pub fn take(&mut self, plan: &Plan, observed: &Observed, stamps: &BTreeMap<String, Stamp>) {
        self.collect();
        let records = self.core.registry().systems.clone();
        let current = |record: &&Arc<SystemRecord>| {
            let stamp = stamps.get(&record.uid);
            record.deleted.is_none() && stamp.is_some_and(|s| s.generation == record.generation)
        };
        let records: BTreeMap<&str, &SystemRecord> = records
            .values()
            .filter(current)
            .map(|record| (record.name(), record.as_ref()))
            .collect();
        self.tell(plan, &records);
        self.forget(plan, observed, &records);
        let known = known(observed);
        for record in records.values() {
            self.adopt(plan, record, &known);
        }
    }

    /// Systems, by uid, that do not take in what was changed by hand, and why.
    pub fn refused(&self) -> BTreeMap<String, String> {
        let refused = self.refused.iter();
        refused
            .map(|(uid, refusal)| (uid.clone(), refusal.why.clone()))
            .collect()
    }

    /// Tells what was not told yet.
    fn tell(&mut self, plan: &Plan, records: &BTreeMap<&str, &SystemRecord>) {
        for drift in &plan.drift {
            let Some(record) = records.get(drift.system.as_str()) else {
                continue;
            };
            let key = (record.uid.clone(), drift.target.clone());
            let before = self.told.get_mut(&key);
            if let Some((_, generation)) = before.filter(|(before, _)| before == drift) {
                // Another generation that wishes the same of it makes no other drift of it.
                *generation = record.generation;
                continue;
            }
            let event = Happening::warning("Drifted", &drift.target, told(drift));
            self.core.record(event.of(Some(&drift.system)));
            self.told.insert(key, (drift.clone(), record.generation));
        }
    }

    /// Forgets what is gone, and tells of what was put back. What cannot be seen now is not gone.
    fn forget(
        &mut self,
        plan: &Plan,
        observed: &Observed,
        records: &BTreeMap<&str, &SystemRecord>,
    ) {
        let core = &self.core;
        self.told.retain(|(uid, target), (drift, generation)| {
            let same = |now: &&Drift| now.system == drift.system && now.target == *target;
            let record = records.get(drift.system.as_str());
            let Some(record) = record.filter(|r| r.uid == *uid) else {
                // The plan says nothing of it yet, or the system is gone.
                let stored = core.registry().systems.get(&drift.system).cloned();
                return stored.is_some_and(|r| r.uid == *uid && r.deleted.is_none());
            };
            if plan.drift.iter().any(|now| same(&now)) || !is_seen(observed, record) {
                return true;
            }
            // Another generation is another wish: what differed from the old one was not put back.
            let repaired = drift.policy == DriftPolicy::Repair && record.generation == *generation;
            if repaired && !is_there(observed, &record.uid, drift) {
                // Its process died, and its marks with it: it is told once it is back.
                return true;
            }
            if repaired {
                let event = Happening::normal("DriftRepaired", target, "is as written again");
                core.record(event.of(Some(&drift.system)));
            }
            false
        });
    }

    /// Has a system take in what was changed by hand in it and is to be adopted.
    fn adopt(&mut self, plan: &Plan, record: &SystemRecord, known: &BTreeSet<String>) {
        let own =
            |drift: &&Drift| drift.policy == DriftPolicy::Adopt && drift.system == record.name();
        let asked = Asked {
            generation: record.generation,
            drift: plan.drift.iter().filter(own).cloned().collect(),
        };
        if asked.drift.is_empty() {
            self.refused.remove(&record.uid);
            return;
        }
        let refused = self.refused.get(&record.uid);
        let rests = refused.is_some_and(|refusal| refusal.holds(&asked, known));
        if rests || self.asked.contains(&record.uid) {
            return;
        }
        let (spec, _) = rts_plan::with_drift(&record.spec, &asked.drift, |_| true);
        if spec == *record.spec {
            return;
        }
        self.asked.insert(record.uid.clone());
        let (core, uid, index) = (Arc::clone(&self.core), record.uid.clone(), record.index);
        let known = known.clone();
        self.tasks.spawn(async move {
            let targets = asked.drift.iter().map(|drift| drift.target.clone());
            let result = apply::fold(&core, spec, index, targets.collect()).await;
            core.wake.notify_one();
            Taken {
                uid,
                asked,
                known,
                result: result.map(|result| result.system.metadata.generation),
            }
        });
    }

    /// Tells how it went where systems were asked.
    fn collect(&mut self) {
        while let Some(joined) = self.tasks.try_join_next() {
            let Ok(taken) = joined else { continue };
            self.asked.remove(&taken.uid);
            match &taken.result {
                Ok(generation) => {
                    self.refused.remove(&taken.uid);
                    let message = format!("is part of the stored system, generation {generation}");
                    for drift in &taken.asked.drift {
                        let event = Happening::normal("DriftAdopted", &drift.target, &message);
                        self.core.record(event.of(Some(&drift.system)));
                    }
                }
                // Somebody else has changed it: the next plan says what is left to do.
                Err(problem) if problem.code == "stale-plan" => {}
                Err(problem) => self.refuse(&taken, problem),
            }
        }
    }

    fn refuse(&mut self, taken: &Taken, problem: &Problem) {
        let before = self.refused.get(&taken.uid);
        let before = before.filter(|before| before.asked == taken.asked);
        let told = before.is_some_and(|before| before.told);
        // What is changed once more just then is simply looked at again.
        let passing = problem.code == "drift-moved" && before.is_none();
        let first = taken.asked.drift.first();
        if let Some(first) = first.filter(|_| !told && !passing) {
            let object = format!("system/{}", first.system);
            let names = taken.asked.drift.iter().map(|drift| drift.target.as_str());
            let names = names.collect::<Vec<_>>().join(", ");
            let message = format!(
                "{names}, changed by hand, cannot become part of the stored system and is left: {}",
                problem.detail
            );
            let event = Happening::warning("DriftNotAdopted", &object, message);
            self.core.record(event.of(Some(&first.system)));
        }
        let refusal = Refusal {
            asked: taken.asked.clone(),
            told: told || !passing,
            until: Instant::now() + if problem.retryable { SOON } else { AGAIN },
            passes: problem.retryable.then(|| taken.known.clone()),
            why: problem.detail.clone(),
        };
        self.refused.insert(taken.uid.clone(), refusal);
    }
}

/// Nodes that answer.
fn known(observed: &Observed) -> BTreeSet<String> {
    let known = |(node, answer): (&String, &NodeObserved)| {
        matches!(answer, NodeObserved::Known(_)).then(|| node.clone())
    };
    observed.nodes.iter().filter_map(known).collect()
}

/// True when a drift that is gone was put back: its target is there, or, made by hand, not there.
fn is_there(observed: &Observed, uid: &str, drift: &Drift) -> bool {
    let inventories = observed.nodes.values().filter_map(|answer| match answer {
        NodeObserved::Known(inventory) => Some(inventory),
        NodeObserved::Unknown { .. } => None,
    });
    let managers = inventories.flat_map(|inventory| &inventory.managers);
    let mut own = managers
        .flat_map(|manager| &manager.components)
        .filter(|c| c.system.as_ref().is_some_and(|s| s.uid == uid));
    if drift.kind == DriftKind::Extra {
        return true;
    }
    own.any(|component| {
        let mut connectors = component.connectors.iter();
        target::component(&component.instance) == drift.target
            || connectors.any(|c| target::connector(&c.name) == drift.target)
    })
}

/// True when every node of a system answers, and everything of it there.
fn is_seen(observed: &Observed, record: &SystemRecord) -> bool {
    record
        .nodes
        .iter()
        .all(|node| match observed.nodes.get(node) {
            Some(NodeObserved::Known(inventory)) => inventory.managers.iter().all(|manager| {
                let own = manager.key.system.as_ref().filter(|s| s.uid == record.uid);
                own.is_none() || manager.responsive
            }),
            _ => false,
        })
}
