//! What all parts of the controller share: inputs, the store, what is desired, what was last observed.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use futures_util::future::{BoxFuture, Shared};
use rts_plan::NodeFacts;
use rts_plan::observed::Observed;
use rts_plan::plan::Plan;
use tokio::sync::{Notify, Semaphore, watch};
use tokio::time::Instant;

use crate::clock::{Chance, Clock};
use crate::execute::SharedProgress;
use crate::fault::{Fault, Faults};
use crate::fleet::Fleet;
use crate::metrics::Metrics;
use crate::node_numbers;
use crate::pace::Pace;
use crate::placement::{Placement, Placements};
use crate::publish::{self, Shown};
use crate::pulse::Pulse;
use crate::reconcile::Backoff;
use crate::sessions::Sessions;
use crate::silence::Silence;
use crate::simulator::Simulator;
use crate::store::{
    Durable, NodeGeneration, Records, Restored, State, Store, StoreError, SystemRecord, Write,
};
use crate::view::{Happening, View};

/// Revisions that are reserved in the store at a time.
pub(crate) const REVISIONS: u64 = 1 << 20;

/// What the controller takes from outside.
#[derive(Clone)]
pub struct Inputs {
    /// Name of the local node.
    pub local_node: String,
    /// Wall time.
    pub clock: Arc<dyn Clock>,
    /// Chance.
    pub rng: Arc<dyn Chance>,
    /// Agents.
    pub fleet: Arc<dyn Fleet>,
    /// What survives.
    pub store: Arc<dyn Store>,
    /// Plays changes through.
    pub simulator: Arc<dyn Simulator>,
}

/// The controller's state.
pub struct Core {
    /// Name of the local node.
    pub local_node: String,
    /// Wall time.
    pub clock: Arc<dyn Clock>,
    /// Chance.
    pub rng: Arc<dyn Chance>,
    /// Agents.
    pub fleet: Arc<dyn Fleet>,
    /// What survives.
    pub store: Durable,
    /// Plays changes through.
    pub simulator: Arc<dyn Simulator>,
    /// One simulation at a time.
    pub(crate) simulation: Arc<Semaphore>,
    /// Made once with the store.
    pub cluster_uid: String,
    epoch: AtomicU64,
    /// Nodes and their agents.
    pub sessions: Sessions,
    /// Objects as clients see them.
    pub view: View,
    /// Numbers for `/metrics`.
    pub metrics: Metrics,
    /// What failed and waits.
    pub backoff: Mutex<Backoff>,
    /// One apply or deletion is admitted at a time.
    pub admission: tokio::sync::Mutex<()>,
    /// Wakes the reconcile loop.
    pub wake: Notify,
    /// An agent has told something: wakes the loop, unless it is busy with what makes them tell.
    pub news: Notify,
    /// Tells whether the reconcile loop goes on.
    pub pulse: Pulse,
    /// When it is time to show everything once more.
    pub pace: Pace,
    desired: watch::Sender<u64>,
    /// Raised when a change that was not durable is, or was taken back.
    pub(crate) settled: watch::Sender<u64>,
    /// The last write of a change failed: the next one counts only once it is durable.
    pub(crate) store_failed: AtomicBool,
    registry: Mutex<Registry>,
    world: Mutex<World>,
    placements: Placements,
    shown: Mutex<Shown>,
    pub(crate) reserved: AtomicU64,
    pub(crate) indexes: AtomicU64,
    /// An observation for readers that runs now, or the last one.
    pub(crate) refresh: Mutex<Option<Shared<BoxFuture<'static, ()>>>>,
}

/// The store's contents, in memory.
#[derive(Debug, Clone, Default)]
pub struct Registry {
    /// Systems by name.
    pub systems: Records,
    /// Node generations.
    pub nodes: BTreeMap<String, NodeGeneration>,
    /// Set by a restore.
    pub restored: Option<Restored>,
    /// Systems by name whose last change counts and is not durable yet: nobody is told of it.
    pub pending: BTreeSet<String>,
    /// Node → numbers that were given out to it beyond the durable one.
    pub ahead: BTreeMap<String, u64>,
    /// Node → the next number is above this one, see [`node_numbers`](crate::node_numbers).
    pub floors: BTreeMap<String, u64>,
}

/// What is known of the world, and what is being done about it.
#[derive(Debug, Default)]
pub struct World {
    /// Last observation.
    pub observed: Observed,
    /// Placement that the last plan was made from.
    pub placed: Arc<Placement>,
    /// Last plan.
    pub plan: Arc<Plan>,
    /// System uid → generation that the plan was made for.
    pub planned: BTreeMap<String, u64>,
    /// Runs under way, and those that ended since the last plan, by system uid.
    pub runs: BTreeMap<String, RunState>,
    /// What was observed changed since the last plan was made.
    pub stale: bool,
    /// Systems whose runs come to nothing and that wait for a while, by uid.
    pub resting: BTreeSet<String>,
    /// Systems that do not take in what was changed by hand in them, by uid, and why.
    pub unadopted: BTreeMap<String, String>,
    /// Nodes that did not take their NodeSpecs or steps.
    pub faults: Faults,
    /// Processes that do not answer.
    pub silence: Silence,
}

impl World {
    /// True while what does not answer is waited for.
    pub fn waits_for_silence(&self) -> bool {
        self.faults.values().any(Fault::may_pass) || !self.silence.of_a_moment().is_empty()
    }
}

/// A run, and where its steps are now. Clones are the same.
#[derive(Debug, Clone, Default)]
pub struct RunState {
    /// Its steps.
    pub plan: Arc<Plan>,
    /// Where they are.
    pub progress: SharedProgress,
}

impl Core {
    /// Loads the store. Call it before serving.
    pub async fn load(inputs: Inputs) -> Result<Arc<Self>, StoreError> {
        let mut state = inputs.store.load().await?;
        let mut writes = state.number();
        writes.push(Write::Revisions(state.revisions + REVISIONS));
        inputs.store.write(writes).await?;
        let State {
            cluster_uid,
            epoch,
            revisions,
            indexes,
            systems,
            nodes,
            restored,
        } = state;
        let core = Arc::new(Self {
            local_node: inputs.local_node,
            clock: inputs.clock,
            rng: inputs.rng,
            fleet: inputs.fleet,
            store: Durable::new(inputs.store),
            simulator: inputs.simulator,
            simulation: Arc::new(Semaphore::new(1)),
            cluster_uid,
            epoch: AtomicU64::new(epoch),
            sessions: Sessions::default(),
            view: View::new(revisions),
            metrics: Metrics::default(),
            backoff: Mutex::default(),
            admission: tokio::sync::Mutex::new(()),
            wake: Notify::new(),
            news: Notify::new(),
            pulse: Pulse::default(),
            pace: Pace::default(),
            desired: watch::Sender::new(0),
            registry: Mutex::new(Registry {
                floors: node_numbers::floors(&nodes),
                systems,
                nodes,
                restored,
                ..Registry::default()
            }),
            settled: watch::Sender::new(0),
            store_failed: AtomicBool::new(false),
            world: Mutex::default(),
            placements: Placements::default(),
            shown: Mutex::default(),
            reserved: AtomicU64::new(revisions + REVISIONS),
            indexes: AtomicU64::new(indexes),
            refresh: Mutex::default(),
        });
        core.publish();
        Ok(core)
    }

    /// Raised each time a store is created or restored.
    pub fn epoch(&self) -> u64 {
        self.epoch.load(Ordering::Relaxed)
    }

    /// Raises the epoch, durably.
    pub async fn raise_epoch(&self, epoch: u64) -> Result<(), StoreError> {
        self.store.write(vec![Write::Epoch(epoch)]).await?;
        self.epoch.fetch_max(epoch, Ordering::Relaxed);
        Ok(())
    }

    /// What is stored.
    pub fn registry(&self) -> MutexGuard<'_, Registry> {
        self.registry.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What is known of the world.
    pub fn world(&self) -> MutexGuard<'_, World> {
        self.world.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What was shown last.
    pub fn shown(&self) -> MutexGuard<'_, Shown> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What failed and waits.
    pub fn backoff(&self) -> MutexGuard<'_, Backoff> {
        self.backoff.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes what is remembered of a system beside what it is to be, durably, then makes it known. Wakes nobody.
    pub async fn store_system(&self, record: Arc<SystemRecord>) -> Result<(), StoreError> {
        self.store.put_system(Arc::clone(&record)).await?;
        let name = record.name().to_owned();
        self.registry().systems.insert(name, record);
        Ok(())
    }

    /// The desired state changed: whatever runs must make way, and the loop must look.
    pub fn desired_changed(&self) {
        self.desired.send_modify(|n| *n = n.wrapping_add(1));
        self.publish();
        self.wake.notify_one();
    }

    /// Tells of changes of the desired state.
    pub fn watch_desired(&self) -> watch::Receiver<u64> {
        self.desired.subscribe()
    }

    /// Appends to the event log.
    pub fn record(&self, happening: Happening) {
        self.view.record(happening, self.clock.now());
    }

    /// Shows everything as it is now.
    pub fn publish(&self) {
        let since = Instant::now();
        publish::all(self);
        self.pace.took(since);
    }

    /// Shows everything anew, whatever was shown last. Gives how many objects that changes: none, as what is shown node by
    /// node is what is shown as a whole.
    pub fn publish_anew(&self) -> u64 {
        self.publish();
        let before = self.view.revision();
        *self.shown() = Shown::default();
        self.publish();
        self.view.revision() - before
    }

    /// Places all stored systems, with one of them replaced by `candidate`.
    pub fn place(&self, candidate: Option<&SystemRecord>) -> Arc<Placement> {
        match candidate {
            Some(candidate) => self.place_with(Arc::new(candidate.clone())),
            None => {
                let records = self.registry().systems.clone();
                self.place_all(&records)
            }
        }
    }

    /// Places all stored systems, with one of them replaced.
    pub fn place_with(&self, candidate: Arc<SystemRecord>) -> Arc<Placement> {
        let mut records = self.registry().systems.clone();
        records.insert(candidate.name().to_owned(), candidate);
        self.place_all(&records)
    }

    /// Places these systems.
    pub fn place_all(&self, records: &Records) -> Arc<Placement> {
        let facts = self.facts(records);
        self.placements.place(records, facts, &self.local_node)
    }

    /// What placement must know of all nodes.
    pub fn facts(&self, records: &Records) -> Vec<NodeFacts> {
        let registry = self.registry();
        let aliases = self.sessions.aliases();
        let ran = records.values().flat_map(|record| &record.nodes);
        let names: BTreeSet<&String> = aliases
            .keys()
            .chain(registry.nodes.keys())
            .chain(ran)
            .collect();
        names
            .into_iter()
            .map(|name| NodeFacts {
                name: name.clone(),
                aliases: aliases.get(name).cloned().unwrap_or_default(),
            })
            .collect()
    }
}
