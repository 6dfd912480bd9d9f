//! The loop: observe, place, plan, carry out, until nothing is left to do or everything left is blocked.
//!
//! It works from state alone: whatever woke it, it looks at everything again. What a plan has to do for one system is
//! carried out by a run of its own ([`runs`]), so that the loop goes on looking, and other systems go on, while one
//! takes its time. A system is planned from what was seen after its last run had ended.

mod backoff;
mod by_system;
mod deaths;
mod drift;
mod node_specs;
mod results;
mod runs;
mod side;
mod slots;
mod teardown;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use futures_util::FutureExt;
use rts_host::timing::TARGET;
use rts_plan::observed::{NodeObserved, Observed};
use rts_plan::plan::Plan;
use tokio::time::Instant;
use tracing::{Instrument, info_span};

use crate::core::Core;
use crate::fault::{self, Fault, Faults};
use crate::ledger::settle::Settling;
use crate::moved;
use crate::placement::Placement;
use crate::store::SystemRecord;

pub use self::backoff::{Backoff, Entry, target_of};
use self::by_system::Plans;
pub use self::by_system::by_system;
use self::drift::Drifts;
pub use self::node_specs::NodeSpecs;
use self::runs::{Revisions, Runs};
use self::side::Unfinished;
pub use self::teardown::is_free_of;

/// The loop looks at everything this often, whatever happens, and asks every agent for all it has.
const SLOW_TICK: Duration = Duration::from_secs(5);
/// The same while something is being carried out.
const BUSY_TICK: Duration = Duration::from_secs(1);
/// While steps are carried out, what agents tell leads to another round only after so many times what the last one took.
const SPARING: u32 = 5;
/// A node that did not answer once is asked again so soon.
const ASK_AGAIN: Duration = Duration::from_millis(250);

/// What the loop does next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    /// Look again at once.
    Again,
    /// Look again when something changed or is due.
    Rest,
}

/// The loop's own memory. Nothing in it is needed after a restart.
pub struct Reconciler {
    core: Arc<Core>,
    specs: NodeSpecs,
    runs: Runs,
    settling: Settling,
    drifts: Drifts,
    /// When the last plan was begun: what was not to be tried then is planned again once it may be.
    planned: Instant,
    /// What the last round took.
    took: Duration,
}

impl Reconciler {
    /// A loop that has not begun.
    pub fn new(core: Arc<Core>) -> Self {
        Self {
            specs: NodeSpecs::new(Arc::clone(&core)),
            runs: Runs::new(Arc::clone(&core)),
            settling: Settling::new(Arc::clone(&core)),
            drifts: Drifts::new(Arc::clone(&core)),
            planned: Instant::now(),
            took: Duration::ZERO,
            core,
        }
    }

    /// Runs for ever.
    pub async fn run(mut self) {
        loop {
            let began = Instant::now();
            self.core.pulse.beat();
            let next = self.round().await;
            self.took = began.elapsed();
            self.core.metrics.reconciled(self.took);
            self.core.pulse.beat();
            if next == Next::Rest {
                self.rest().await;
            }
        }
    }

    /// Sleeps until something changed, something may be tried again, or the tick.
    async fn rest(&self) {
        // A large fleet tells something all the time.
        let mut desired = self.core.watch_desired();
        desired.mark_unchanged();
        tokio::select! {
            biased;
            _ = desired.changed() => return,
            () = self.core.pace.rest() => {}
        }
        // While steps are carried out, agents tell of little else, and there is little to do about it.
        let quiet = match self.runs.any() {
            true => (self.took * SPARING).min(SLOW_TICK),
            false => Duration::ZERO,
        };
        let unsure = self.core.sessions.any_unsure();
        let tick = if unsure {
            ASK_AGAIN
        } else if self.runs.any() {
            BUSY_TICK.max(quiet)
        } else if self.core.sessions.any_may_be_back() || self.core.world().waits_for_silence() {
            // That the wait is over is told when it is.
            BUSY_TICK
        } else {
            SLOW_TICK
        };
        let now = Instant::now();
        let tick = now + tick;
        let due = self.core.backoff().next(self.planned);
        let until = due.map_or(tick, |at| at.min(tick));
        tokio::select! {
            biased;
            () = self.core.wake.notified() => {}
            () = self.told(quiet) => {}
            () = tokio::time::sleep_until(until) => {}
        }
    }

    /// Waits until an agent has told something, but not before so long.
    async fn told(&self, quiet: Duration) {
        if !quiet.is_zero() {
            tokio::time::sleep(quiet).await;
        }
        self.core.news.notified().await;
    }

    async fn round(&mut self) -> Next {
        // It looks at everything.
        let _ = self.core.news.notified().now_or_never();
        self.runs.collect();
        let (busy, long) = (self.runs.busy(), self.runs.long());
        self.core.backoff().tidy();
        self.core.reserve_revisions().await;
        let mut desired = self.core.watch_desired();
        desired.mark_unchanged();
        moved::trust(&self.core).await;
        let fenced = self.settling.settle();
        // Without an await between them, both speak of the same generations.
        let placed = self.core.place(None);
        let stamps = stamps(&self.core);
        self.specs.note_nodes(&placed).await;
        let sent = self.specs.send(&placed, &fenced);
        let span = info_span!(target: TARGET, "node specs");
        let mut faults = sent.instrument(span).await;
        let fenced = fenced.into_iter();
        faults.extend(fenced.map(|(node, why)| (node, Fault::refused(why))));
        // What is seen from here on was there after the agents had stored what they are judged by.
        let look = self.core.look(SLOW_TICK);
        let observed = look.instrument(info_span!(target: TARGET, "look")).await;
        moved::seen(&self.core, &self.specs, &observed, &busy).await;
        let since = Instant::now();
        self.planned = since;
        let span = info_span!(target: TARGET, "plan");
        let planned = self.plan(&placed, &observed, &busy, &long);
        let (plan, plans) = planned.instrument(span).await;
        let untold = self.specs.untold(&placed.desired, &faults);
        let planned = stamps
            .iter()
            .filter(|(uid, _)| !untold.contains(*uid))
            .map(|(uid, stamp)| (uid.clone(), stamp.generation))
            .collect();
        self.drifts.take(&plan, &observed, &stamps);
        let seen = revisions(&observed);
        self.show(placed, planned, observed, &plan, faults);
        self.core.pace.took(since);
        if desired.has_changed().unwrap_or(false) {
            return Next::Again;
        }
        let forgotten = teardown::finish(&self.core, &self.specs, &busy).await;
        self.runs
            .start(plans, &stamps, &busy, &long, &self.specs, &seen);
        if forgotten { Next::Again } else { Next::Rest }
    }

    /// Plans, and once more when a process that was started not long ago is gone: its next start is delayed.
    async fn plan(
        &self,
        placed: &Arc<Placement>,
        observed: &Observed,
        busy: &BTreeSet<String>,
        long: &BTreeMap<String, Vec<Unfinished>>,
    ) -> (Arc<Plan>, Plans) {
        let planned = || async {
            let records = self.core.registry().systems.clone();
            let blocked = moved::blocked(&self.core, &records, observed, None);
            let plan = Arc::new(moved::plan(placed, observed, blocked).await);
            let plans = by_system(&plan);
            (plan, plans)
        };
        let (plan, plans) = planned().await;
        let free = side::free(&plans, busy, long);
        if !deaths::count(&self.core, &placed.desired, &free, observed, busy) {
            return (plan, plans);
        }
        planned().await
    }

    fn show(
        &mut self,
        placed: Arc<Placement>,
        planned: BTreeMap<String, u64>,
        observed: Observed,
        plan: &Arc<Plan>,
        mut faults: Faults,
    ) {
        let _span = info_span!(target: TARGET, "publish").entered();
        faults.extend(self.runs.faults());
        let slots = self.runs.slots();
        {
            let mut world = self.core.world();
            world.planned = planned;
            world.placed = placed;
            world.silence.seen(&observed);
            world.observed = observed;
            world.stale = false;
            world.plan = Arc::clone(plan);
            world.faults = fault::aged(faults, &world.faults);
            world.runs.retain(|slot, _| slots.contains(slot));
            world.resting = self.runs.resting();
            world.unadopted = self.drifts.refused();
        }
        self.core.publish();
    }
}

/// What was seen of each node that told.
fn revisions(observed: &Observed) -> Revisions {
    let told = |(node, seen): (&String, &NodeObserved)| match seen {
        NodeObserved::Known(inventory) => Some((node.clone(), inventory.revision)),
        _ => None,
    };
    observed.nodes.iter().filter_map(told).collect()
}

/// What a system was told to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stamp {
    /// Generation.
    generation: u64,
    /// Its end was asked for.
    deleting: bool,
}

impl Stamp {
    fn of(record: &SystemRecord) -> Self {
        Self {
            generation: record.generation,
            deleting: record.deleted.is_some(),
        }
    }
}

/// What a system is told to be now, by uid.
fn stamp(core: &Core, uid: &str) -> Option<Stamp> {
    let registry = core.registry();
    let record = registry.systems.values().find(|record| record.uid == uid);
    record.map(|record| Stamp::of(record))
}

/// System uid → stamp.
fn stamps(core: &Core) -> BTreeMap<String, Stamp> {
    let registry = core.registry();
    let records = registry.systems.values();
    records.map(|r| (r.uid.clone(), Stamp::of(r))).collect()
}
