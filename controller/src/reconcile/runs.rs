//! The runs under way: one for each system, each a task of its own, and one beside it when it takes long.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use rts_agent_api::messages::Seen;
use rts_host::timing::TARGET;
use rts_plan::plan::Plan;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::Instant;
use tracing::{Instrument, info_span};

use super::by_system::Plans;
use super::node_specs::NodeSpecs;
use super::results::{self, MadeFor};
use super::side::{Unfinished, beside};
use super::slots::{Slots, system_of};
use super::{SLOW_TICK, Stamp};
use crate::core::{Core, RunState};
use crate::execute::{Accepted, Executor, Peer, SharedProgress, StartTimeouts};
use crate::fault::Faults;

/// Most runs at once: an agent takes at most eight batches.
const MOST: usize = 7;
/// Progress is published at most this often while a plan runs.
const PROGRESS: Duration = Duration::from_millis(50);
/// A run of the same steps within this time after the last one has changed nothing.
const AT_ONCE: Duration = Duration::from_millis(250);
/// Runs that come to nothing after which a system waits before it is tried once more.
const FRUITLESS: u32 = 3;

/// Node → revision of the inventory that was seen of it.
pub type Revisions = BTreeMap<String, u64>;

/// The runs, by system uid; the empty one is for what belongs to no system.
pub struct Runs {
    core: Arc<Core>,
    tasks: JoinSet<Ended>,
    slots: Slots,
    last: BTreeMap<String, Last>,
    /// Run → node → why its agent refused the steps or was lost.
    faults: BTreeMap<String, Faults>,
}

/// How a run ended.
struct Ended {
    key: String,
    succeeded: bool,
    superseded: bool,
    faults: Faults,
    /// Kinds and targets of its steps.
    work: Vec<(&'static str, String)>,
}

/// The last run of a system.
struct Last {
    /// Runs in a row that came to nothing.
    fruitless: u32,
    at: Instant,
    work: Vec<(&'static str, String)>,
}

impl Ended {
    /// A run comes to nothing when no step succeeded, or when the very same steps are to be done again at once.
    fn after(&mut self, last: Option<Last>) -> Last {
        let at = Instant::now();
        let work = std::mem::take(&mut self.work);
        let same = |last: &Last| at.duration_since(last.at) < AT_ONCE && last.work == work;
        let again = last.as_ref().is_some_and(same);
        let before = last.map_or(0, |last| last.fruitless);
        let fruitless = match self.succeeded && !again {
            true => 0,
            false => before.saturating_add(1),
        };
        Last {
            fruitless,
            at,
            work,
        }
    }
}

impl Last {
    fn rests(&self, now: Instant) -> bool {
        self.fruitless >= FRUITLESS && now.duration_since(self.at) < SLOW_TICK
    }
}

struct Run {
    core: Arc<Core>,
    key: String,
    /// Its plan, and how far it is.
    state: RunState,
    /// What the system was told to be when it was planned.
    stamp: Option<Stamp>,
    peers: BTreeMap<String, Peer>,
    /// Node → generation of the NodeSpec that its steps are for.
    generations: BTreeMap<String, u64>,
    absent: BTreeMap<String, String>,
    starts: StartTimeouts,
    desired: watch::Receiver<u64>,
}

impl Runs {
    /// None yet.
    pub fn new(core: Arc<Core>) -> Self {
        Self {
            core,
            tasks: JoinSet::new(),
            slots: Slots::default(),
            last: BTreeMap::new(),
            faults: BTreeMap::new(),
        }
    }

    /// True while there is one.
    pub fn any(&self) -> bool {
        self.slots.len() > 0
    }

    /// Systems with a run.
    pub fn busy(&self) -> BTreeSet<String> {
        self.slots.systems()
    }

    /// The same by slot: a system may have two.
    pub fn slots(&self) -> BTreeSet<String> {
        self.slots.names()
    }

    /// What runs that take long have still to do, by system. To be asked before looking at what is there: what ends
    /// meanwhile may not be seen yet.
    pub fn long(&self) -> BTreeMap<String, Vec<Unfinished>> {
        self.slots.long()
    }

    /// Nodes that refused steps or were lost in the last run of a system, and why.
    pub fn faults(&self) -> Faults {
        self.faults
            .values()
            .flatten()
            .map(|(n, why)| (n.clone(), why.clone()))
            .collect()
    }

    /// Systems whose runs come to nothing and that wait for a while.
    pub fn resting(&self) -> BTreeSet<String> {
        let now = Instant::now();
        let rest = self.last.iter().filter(|(_, last)| last.rests(now));
        rest.map(|(key, _)| key.clone()).collect()
    }

    /// Takes in the runs that have ended.
    pub fn collect(&mut self) {
        while let Some(joined) = self.tasks.try_join_next() {
            let Ok(mut ended) = joined else { continue };
            if ended.superseded {
                self.last.remove(&ended.key);
            } else {
                let last = self.last.remove(&ended.key);
                self.last.insert(ended.key.clone(), ended.after(last));
            }
            if ended.faults.is_empty() {
                self.faults.remove(&ended.key);
            } else {
                self.faults.insert(ended.key, ended.faults);
            }
        }
        self.slots.tidy();
    }

    /// Starts a run for each system that has steps and no run, or none but long ones.
    pub fn start(
        &mut self,
        plans: Plans,
        stamps: &BTreeMap<String, Stamp>,
        busy: &BTreeSet<String>,
        long: &BTreeMap<String, Vec<Unfinished>>,
        specs: &NodeSpecs,
        seen: &Revisions,
    ) {
        let resting = self.resting();
        self.faults
            .retain(|key, _| plans.contains_key(system_of(key)) || busy.contains(system_of(key)));
        self.last
            .retain(|key, _| plans.contains_key(system_of(key)) || busy.contains(system_of(key)));
        for (system, plan) in plans {
            let (Some(key), true) = (self.slots.free(&system), self.slots.len() < MOST) else {
                continue;
            };
            if resting.contains(&key) {
                continue;
            }
            let plan = match long.get(&system) {
                Some(left) => beside(&plan, left),
                None => Some(plan).filter(|_| !busy.contains(&system)),
            };
            let Some(plan) = plan else { continue };
            // It would come to nothing.
            let waits = |node| specs.unnumbered().contains(node);
            if plan.steps.iter().any(|step| waits(&step.node)) {
                continue;
            }
            let world = self.core.world();
            let faults = world.faults.iter();
            let absent = faults.map(|(node, fault)| (node.clone(), fault.reason.clone()));
            let absent = absent.collect();
            drop(world);
            let peers = self.peers(&plan, specs, seen);
            let generations = peers
                .iter()
                .map(|(n, peer)| (n.clone(), peer.accepted.generation));
            let run = Run {
                core: Arc::clone(&self.core),
                key: key.clone(),
                stamp: stamps.get(&system).copied(),
                generations: generations.collect(),
                peers,
                starts: self.core.start_timeouts(&system),
                absent,
                desired: self.core.watch_desired(),
                state: RunState {
                    plan,
                    progress: SharedProgress::default(),
                },
            };
            let state = run.state.clone();
            let mut world = self.core.world();
            world.runs.insert(key.clone(), state.clone());
            drop(world);
            let steps = state.plan.steps.len();
            let span = info_span!(target: TARGET, "run", of = format!("{steps} steps"));
            let task = self.tasks.spawn(run.carry_out().instrument(span));
            self.slots.take(key, task, state);
        }
    }

    /// Nodes of a plan whose agent takes steps for the newest NodeSpec.
    fn peers(&self, plan: &Plan, specs: &NodeSpecs, seen: &Revisions) -> BTreeMap<String, Peer> {
        let nodes: BTreeSet<&String> = plan.steps.iter().map(|step| &step.node).collect();
        let sessions = self.core.sessions.all().into_iter();
        let ready = sessions.filter(|(node, entry)| !entry.lost && nodes.contains(node));
        ready
            .filter_map(|(node, entry)| {
                let generation = specs.taken(&node, &entry.session.id)?;
                let core = Arc::clone(&self.core);
                let (name, session) = (node.clone(), entry.session.id.clone());
                let seen = seen.get(&node).map(|revision| Seen {
                    session: session.clone(),
                    revision: *revision,
                });
                let peer = Peer {
                    agent: entry.session.agent,
                    accepted: Accepted { generation, seen },
                    lost: Box::pin(async move { core.sessions.ended(&name, &session).await }),
                };
                Some((node, peer))
            })
            .collect()
    }
}

impl Run {
    /// Carries its plan out and shows how far it is. A newer NodeSpec makes the agents start nothing more.
    async fn carry_out(mut self) -> Ended {
        let plan_id = self.core.rng.uuid();
        let peers = std::mem::take(&mut self.peers);
        let store = (self.core.cluster_uid.as_str(), self.core.epoch());
        let (absent, starts) = (&self.absent, &self.starts);
        let RunState { plan, progress } = self.state.clone();
        let mut run = Executor::start(
            &plan,
            &plan_id,
            store,
            peers,
            absent,
            starts,
            progress.clone(),
        );
        let mut publish = tokio::time::interval(PROGRESS);
        publish.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let mut dirty = true;
        loop {
            tokio::select! {
                biased;
                _ = publish.tick(), if dirty => {
                    dirty = false;
                    self.core.publish();
                    // However long that took, what has come meanwhile is taken first.
                    match self.core.pace.due() {
                        Some(due) => publish.reset_at(due),
                        None => publish.reset(),
                    }
                }
                more = run.next() => {
                    for (step, outcome) in run.take_ended() {
                        results::take(&self.core, step, &outcome, self.made_for());
                        // What was told before says nothing about it.
                        self.core.sessions.doubt(&step.node);
                    }
                    dirty = true;
                    if !more {
                        break;
                    }
                }
            }
        }
        // What was told before the last step ended says nothing about it.
        let nodes: BTreeSet<&String> = plan.steps.iter().map(|step| &step.node).collect();
        for node in nodes {
            self.core.sessions.doubt(node);
        }
        progress.lock().running.clear();
        let steps = plan.steps.iter();
        let work = steps.map(|step| (step.work.kind(), step.target.clone()));
        // That an agent takes no more steps for a spec that was replaced is no fault of its node.
        let mut faults = run.faults.clone();
        faults.retain(|node, _| !self.is_replaced(node));
        let replaced = self.generations.keys().any(|node| self.is_replaced(node));
        let ended = Ended {
            succeeded: progress.lock().succeeded > 0,
            superseded: replaced || self.desired.has_changed().unwrap_or(false),
            faults,
            work: work.collect(),
            key: self.key.clone(),
        };
        self.core.publish();
        self.core.wake.notify_one();
        ended
    }

    /// What a step that ends now was made for.
    fn made_for(&self) -> MadeFor {
        if super::stamp(&self.core, system_of(&self.key)) == self.stamp {
            MadeFor::Now
        } else {
            MadeFor::OlderGeneration
        }
    }

    /// True when the node has been given a newer NodeSpec than this run's, perhaps for another system's sake: what had
    /// not started there is planned again.
    fn is_replaced(&self, node: &str) -> bool {
        let registry = self.core.registry();
        let given = registry.nodes.get(node);
        let own = self.generations.get(node);
        given
            .zip(own)
            .is_some_and(|(given, own)| given.generation > *own)
    }
}
