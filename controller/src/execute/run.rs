//! One run of a plan.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use futures_util::StreamExt;
use futures_util::future::BoxFuture;
use futures_util::stream::{BoxStream, FuturesUnordered, SelectAll};
use rts_agent_api::messages::{Batch, BatchEvent, GateReport, Seen, StepOutcome};
use rts_plan::plan::{Plan, Step, StepId};
use tokio::sync::Semaphore;

use super::cut::cut;
use super::deadline::{self, StartTimeouts};
use super::follow::{ACCEPT, Broken, Report, follow};
use crate::fault::Faults;
use crate::fleet::{AT_ONCE, Agent};

/// Tries after which a gate that does not open is told of.
const GATE_WARNING: u32 = 3;
/// Pause before a gate report is tried again, at first and at most.
const GATE_PAUSE: (Duration, Duration) = (Duration::from_millis(100), Duration::from_secs(2));

/// An agent that takes part, and a future that ends when it is lost.
pub struct Peer {
    /// The agent.
    pub agent: Arc<dyn Agent>,
    /// What it takes steps for.
    pub accepted: Accepted,
    /// Ends when the node's session ends.
    pub lost: BoxFuture<'static, ()>,
}

/// What an agent takes steps for.
#[derive(Debug, Clone)]
pub struct Accepted {
    /// The generation that its ledger holds.
    pub generation: u64,
    /// What was seen of it when the steps were planned; `None` when nobody looked.
    pub seen: Option<Seen>,
}

/// Cluster uid and epoch of the store in whose name steps are carried out.
pub type Store<'a> = (&'a str, u64);

/// Where each step of a run is.
#[derive(Debug, Default)]
pub struct Progress {
    /// Steps that run.
    pub running: BTreeSet<StepId>,
    /// Steps that ended.
    pub ended: BTreeMap<StepId, StepOutcome>,
    /// How many of them succeeded.
    pub succeeded: usize,
}

/// The same, written by the run and read by others. Held for moments.
#[derive(Debug, Clone, Default)]
pub struct SharedProgress(Arc<Mutex<Progress>>);

impl SharedProgress {
    /// To look at it, or to change it.
    pub fn lock(&self) -> MutexGuard<'_, Progress> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Carries out one plan.
pub struct Executor<'a> {
    plan: &'a Plan,
    plan_id: &'a str,
    agents: BTreeMap<String, Arc<dyn Agent>>,
    /// Step → nodes that wait for it.
    gates: BTreeMap<StepId, Vec<String>>,
    /// Steps whose end nobody asked for yet.
    fresh: Vec<StepId>,
    reports: SelectAll<BoxStream<'static, Report>>,
    releases: FuturesUnordered<BoxFuture<'static, ()>>,
    /// Where it is.
    progress: SharedProgress,
    /// Node → its steps.
    steps_of: BTreeMap<&'a str, Vec<StepId>>,
    /// Nodes whose agent refused its steps or was lost.
    pub faults: Faults,
}

impl<'a> Executor<'a> {
    /// Starts the batches. Steps of nodes without a peer fail with the reason that is given for the node.
    pub fn start(
        plan: &'a Plan,
        plan_id: &'a str,
        store: Store<'_>,
        peers: BTreeMap<String, Peer>,
        absent: &BTreeMap<String, String>,
        starts: &StartTimeouts,
        progress: SharedProgress,
    ) -> Self {
        let accepted = peers
            .iter()
            .map(|(n, p)| (n.clone(), p.accepted.clone()))
            .collect();
        let deadline = deadline::of(plan, starts).as_millis();
        let deadline = u64::try_from(deadline).unwrap_or(u64::MAX);
        let mut batches = cut(plan, plan_id, store, &accepted, deadline);
        let mut run = Self {
            plan,
            plan_id,
            agents: BTreeMap::new(),
            gates: waiting_for(&batches),
            fresh: Vec::new(),
            reports: SelectAll::new(),
            releases: FuturesUnordered::new(),
            progress,
            steps_of: BTreeMap::new(),
            faults: Faults::new(),
        };
        let turns = Arc::new(Semaphore::new(AT_ONCE));
        for (node, peer) in peers {
            if let Some(batch) = batches.remove(&node) {
                run.agents.insert(node.clone(), Arc::clone(&peer.agent));
                run.reports
                    .push(follow(node, batch, peer, Arc::clone(&turns)));
            }
        }
        for step in &plan.steps {
            let own = run.steps_of.entry(&step.node).or_default();
            own.push(step.id);
            if !run.agents.contains_key(&step.node) {
                let reason = absent
                    .get(&step.node)
                    .cloned()
                    .unwrap_or_else(|| format!("node {} has no agent now", step.node));
                run.ended(step.id, skipped(reason));
            }
        }
        run
    }

    /// Waits for news. False when the run is over.
    pub async fn next(&mut self) -> bool {
        loop {
            tokio::select! {
                biased;
                // Each report makes a few of them at most: they hold nothing up.
                Some(()) = self.releases.next(), if !self.releases.is_empty() => {}
                report = self.reports.next() => {
                    let Some(report) = report else { return false };
                    self.take(report);
                    return true;
                }
            }
        }
    }

    /// Steps that ended since the last call.
    pub fn take_ended(&mut self) -> Vec<(&'a Step, StepOutcome)> {
        let progress = self.progress.lock();
        let fresh = std::mem::take(&mut self.fresh).into_iter();
        fresh
            .filter_map(|id| Some((step(self.plan, id)?, progress.ended.get(&id)?.clone())))
            .collect()
    }

    fn take(&mut self, report: Report) {
        match report {
            Report::Event(node, BatchEvent::Started { step }) if self.owns(&node, step) => {
                self.progress.lock().running.insert(step);
                self.release(step, |id| GateReport {
                    started: vec![id],
                    succeeded: Vec::new(),
                    failed: Vec::new(),
                });
            }
            Report::Event(node, BatchEvent::Finished { step, outcome, .. })
                if self.owns(&node, step) =>
            {
                self.ended(step, outcome);
            }
            Report::Event(..) => {}
            Report::Over(node, why) => {
                if let Some(why) = &why {
                    tracing::warn!(node, reason = why.reason(), "batch broken off");
                    self.faults.insert(node.clone(), why.fault());
                }
                let never = || Broken::Failed("its agent never told of it".to_owned());
                let why = why.unwrap_or_else(never);
                for id in self.steps_of.remove(node.as_str()).unwrap_or_default() {
                    let (is_over, runs) = {
                        let progress = self.progress.lock();
                        (
                            progress.ended.contains_key(&id),
                            progress.running.contains(&id),
                        )
                    };
                    if !is_over {
                        self.ended(id, broken_off(&why, runs));
                    }
                }
                self.agents.remove(&node);
            }
        }
    }

    /// The first outcome of a step counts.
    fn ended(&mut self, step: StepId, outcome: StepOutcome) {
        let good = outcome == StepOutcome::Succeeded;
        {
            let mut progress = self.progress.lock();
            progress.running.remove(&step);
            if progress.ended.contains_key(&step) {
                return;
            }
            progress.ended.insert(step, outcome);
            progress.succeeded += usize::from(good);
        }
        self.fresh.push(step);
        self.release(step, |id| GateReport {
            started: Vec::new(),
            succeeded: if good { vec![id] } else { Vec::new() },
            failed: if good { Vec::new() } else { vec![id] },
        });
    }

    fn owns(&self, node: &str, id: StepId) -> bool {
        step(self.plan, id).is_some_and(|step| step.node == node)
    }

    /// Tells the nodes that wait for this step.
    fn release(&mut self, id: StepId, report: impl Fn(StepId) -> GateReport) {
        for node in self.gates.get(&id).into_iter().flatten() {
            let Some(agent) = self.agents.get(node) else {
                continue;
            };
            let agent = Arc::clone(agent);
            let plan_id = self.plan_id.to_owned();
            let report = report(id);
            let node = node.clone();
            self.releases.push(Box::pin(async move {
                let mut pause = GATE_PAUSE.0;
                let mut tries = 0_u32;
                // Whoever waits behind the gate has nothing else to end it but the deadline. The run's end ends this.
                loop {
                    let sent = tokio::time::timeout(ACCEPT, agent.release(&plan_id, &report));
                    let why = match sent.await {
                        Ok(Ok(())) => return,
                        Ok(Err(e)) => e.to_string(),
                        Err(_) => "no answer".to_owned(),
                    };
                    tries = tries.saturating_add(1);
                    if tries == GATE_WARNING {
                        tracing::warn!(node, step = id, why, "a gate cannot be opened; going on");
                    }
                    tokio::time::sleep(pause).await;
                    pause = (pause * 2).min(GATE_PAUSE.1);
                }
            }));
        }
    }
}

/// Step → nodes whose batches wait for it.
fn waiting_for(batches: &BTreeMap<String, Batch>) -> BTreeMap<StepId, Vec<String>> {
    let mut gates: BTreeMap<StepId, Vec<String>> = BTreeMap::new();
    for (node, batch) in batches {
        for gate in &batch.gates {
            gates.entry(*gate).or_default().push(node.clone());
        }
    }
    gates
}

/// A step of a plan by its id.
pub fn step(plan: &Plan, id: StepId) -> Option<&Step> {
    let index = usize::try_from(id).ok()?.checked_sub(1)?;
    plan.steps
        .get(index)
        .filter(|step| step.id == id)
        .or_else(|| plan.steps.iter().find(|step| step.id == id))
}

/// What becomes of a step whose batch was broken off. One that ran has failed, unless nobody can know: whether it did is seen
/// when its node is looked at again, and until then it is no reason to wait before the next try.
fn broken_off(why: &Broken, runs: bool) -> StepOutcome {
    match why {
        Broken::Failed(reason) if runs => StepOutcome::Failed {
            reason: reason.clone(),
        },
        _ => skipped(why.reason().to_owned()),
    }
}

fn skipped(reason: String) -> StepOutcome {
    StepOutcome::Skipped {
        because_of: None,
        reason,
    }
}
