//! The loop: observe, place, plan, carry out, until nothing is left to do or everything left is blocked.
//!
//! It works from state alone: whatever woke it, it looks at everything again.

mod backoff;
mod deaths;
mod node_specs;
mod results;
mod teardown;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use rts_plan::Placed;
use rts_plan::observed::Observed;
use rts_plan::plan::Plan;
use tokio::time::Instant;

use crate::core::{Core, RunState};
use crate::execute::{Executor, Peer};

pub use self::backoff::Backoff;
use self::deaths::Deaths;
use self::node_specs::NodeSpecs;

/// The loop looks at everything this often, whatever happens.
const SLOW_TICK: Duration = Duration::from_secs(5);
/// Progress is published at most this often while a plan runs.
const PROGRESS: Duration = Duration::from_millis(50);
/// Runs without any success after which the loop waits before it tries once more.
const FRUITLESS: u32 = 3;

/// What the loop does next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    /// Look again at once.
    Again,
    /// Nothing can be done now.
    Rest,
}

/// The loop's own memory. Nothing in it is needed after a restart.
pub struct Reconciler {
    core: Arc<Core>,
    specs: NodeSpecs,
    deaths: Deaths,
    fruitless: u32,
}

impl Reconciler {
    /// A loop that has not begun.
    pub fn new(core: Arc<Core>) -> Self {
        Self {
            specs: NodeSpecs::new(Arc::clone(&core)),
            core,
            deaths: Deaths::default(),
            fruitless: 0,
        }
    }

    /// Runs for ever.
    pub async fn run(mut self) {
        loop {
            let began = Instant::now();
            let next = self.round().await;
            self.core.metrics.reconciled(began.elapsed());
            if next == Next::Rest {
                self.rest().await;
            }
        }
    }

    /// Sleeps until something changed, something may be tried again, or the slow tick.
    async fn rest(&self) {
        let tick = Instant::now() + SLOW_TICK;
        let until = self.core.backoff().next().map_or(tick, |at| at.min(tick));
        tokio::select! {
            () = self.core.wake.notified() => {}
            () = tokio::time::sleep_until(until) => {}
        }
    }

    async fn round(&mut self) -> Next {
        self.core.backoff().tidy();
        self.core.reserve_revisions().await;
        let mut desired = self.core.watch_desired();
        desired.mark_unchanged();
        let observed = self.core.observe().await;
        // Without an await between them, both speak of the same generations.
        let placed = self.core.place(None);
        let planned = generations(&self.core);
        self.specs.note_nodes(&placed).await;
        let plan = self.plan(&placed, &observed);
        let faults = self.specs.send(&placed.desired).await;
        self.show(placed, planned, observed, &plan, faults);
        if desired.has_changed().unwrap_or(false) {
            return Next::Again;
        }
        if !plan.steps.is_empty() {
            return self.carry_out(&plan, desired).await;
        }
        self.fruitless = 0;
        if teardown::finish(&self.core, &self.specs).await {
            return Next::Again;
        }
        Next::Rest
    }

    /// Plans, and once more when a process that was started not long ago is gone: its next start is delayed.
    fn plan(&mut self, placed: &Placed, observed: &Observed) -> Plan {
        let blocked = self.core.backoff().blocked();
        let plan = rts_plan::plan(&placed.desired, observed, &blocked);
        if !self.deaths.count(&self.core, &plan, observed) {
            return plan;
        }
        let blocked = self.core.backoff().blocked();
        rts_plan::plan(&placed.desired, observed, &blocked)
    }

    fn show(
        &self,
        placed: Placed,
        planned: BTreeMap<String, u64>,
        observed: Observed,
        plan: &Plan,
        faults: BTreeMap<String, String>,
    ) {
        {
            let mut world = self.core.world();
            world.planned = planned;
            world.placed = placed;
            world.observed = observed;
            world.plan = plan.clone();
            world.faults = faults;
            world.run = None;
        }
        self.core.publish();
    }

    /// Carries a plan out. A newer desired state cancels what has not started.
    async fn carry_out(
        &mut self,
        plan: &Plan,
        mut desired: tokio::sync::watch::Receiver<u64>,
    ) -> Next {
        let plan_id = self.core.rng.uuid();
        let faults = self.core.world().faults.clone();
        let peers = self.peers();
        let mut run = Executor::start(plan, &plan_id, peers, &faults);
        self.core.world().run = Some(RunState::default());
        let mut superseded = false;
        let mut publish = tokio::time::interval(PROGRESS);
        publish.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let mut dirty = true;
        loop {
            tokio::select! {
                more = run.next() => {
                    for (step, outcome) in run.take_ended() {
                        results::take(&self.core, step, &outcome, &mut self.deaths);
                    }
                    dirty = true;
                    if !more {
                        break;
                    }
                }
                _ = publish.tick(), if dirty => {
                    dirty = false;
                    self.core.world().run = Some(RunState {
                        running: run.progress.running.clone(),
                        ended: run.progress.ended.clone(),
                    });
                    self.core.publish();
                }
                Ok(()) = desired.changed(), if !superseded => {
                    superseded = true;
                    let placed = self.core.place(None);
                    self.specs.note_nodes(&placed).await;
                    self.specs.send(&placed.desired).await;
                }
            }
        }
        self.after(&run, superseded)
    }

    fn after(&mut self, run: &Executor<'_>, superseded: bool) -> Next {
        let progress = &run.progress;
        {
            let mut world = self.core.world();
            world.run = Some(RunState {
                running: Vec::new(),
                ended: progress.ended.clone(),
            });
            world.faults.extend(run.faults.clone());
        }
        let succeeded = progress
            .ended
            .values()
            .any(|outcome| *outcome == rts_agent_api::messages::StepOutcome::Succeeded);
        if succeeded || superseded {
            self.fruitless = 0;
        } else {
            self.fruitless += 1;
        }
        // A run that did nothing, again and again, must not become a busy loop.
        if self.fruitless >= FRUITLESS {
            self.core.publish();
            return Next::Rest;
        }
        Next::Again
    }

    /// Nodes whose agent has stored the newest NodeSpec.
    fn peers(&self) -> BTreeMap<String, Peer> {
        let sessions = self.core.sessions.all();
        let ready = sessions.into_iter().filter(|(_, entry)| !entry.lost);
        ready
            .filter_map(|(node, entry)| {
                let generation = self.specs.acked(&node, &entry.session.id)?;
                let core = Arc::clone(&self.core);
                let (name, session) = (node.clone(), entry.session.id.clone());
                let peer = Peer {
                    agent: entry.session.agent,
                    generation,
                    lost: Box::pin(async move { core.sessions.ended(&name, &session).await }),
                };
                Some((node, peer))
            })
            .collect()
    }
}

/// System uid → generation.
fn generations(core: &Core) -> BTreeMap<String, u64> {
    let registry = core.registry();
    let records = registry.systems.values();
    records.map(|r| (r.uid.clone(), r.generation)).collect()
}
