//! Healing without a controller: the agent plans over its own node spec, and executes as it would for a controller.
//!
//! The session is the lease: nothing is begun while a controller is heard of, and what is left of a plan is dropped as
//! soon as one is heard of again.

mod alone;
mod back_off;
mod lease;
mod patience;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use rts_agent_api::messages::{Batch, BatchEvent, NodeSpecEnvelope, StepOutcome};
use rts_agent_api::session::AgentEvent;
use rts_plan::desired::Desired;
use rts_plan::observed::{Inventory, NodeObserved, Observed};
use rts_plan::plan::{Blocked, Step, StepId};
use rts_plan::{beside, plan, target};
use tokio::sync::watch;
use tokio::time::{Instant, sleep};

use crate::agent::Agent;
use crate::batches::{Entry, MAX_DEADLINE};
use crate::events::lock;
use crate::ledger::Sealed;

pub(crate) use alone::Alone;
pub(crate) use back_off::BackOff;
pub(crate) use lease::Lease;
use patience::patience;

/// How often the agent looks whether it has to act.
const LOOK: Duration = Duration::from_millis(250);
/// So many times as long as the last look took, others come first: greeting the controller above all.
const REST: u32 = 4;
/// But no longer than this: what has died is to be there again.
const MOST: Duration = Duration::from_secs(2);
/// A plan that is not done by then, beside what its steps wait on purpose or may take longer than others, is made anew.
const DEADLINE: Duration = Duration::from_secs(120);
/// Most steps at once.
const PARALLELISM: u32 = 16;

/// A batch of the agent's own.
struct Healing {
    entry: Arc<Entry>,
    /// What its steps are about.
    targets: BTreeMap<StepId, String>,
}

/// Under what nothing was to be done: as long as all of it holds, nothing is.
struct Quiet {
    spec: Arc<Sealed>,
    revision: u64,
}

impl Quiet {
    fn holds(&self, spec: &Arc<Sealed>, revision: u64) -> bool {
        Arc::ptr_eq(&self.spec, spec) && self.revision == revision
    }
}

/// Heals for as long as the agent runs.
pub(crate) async fn keep(agent: Arc<Agent>) {
    let Some(after) = agent.config.heal_after else {
        return;
    };
    let mut healings: Vec<Healing> = Vec::new();
    let (mut quiet, mut rest) = (None, LOOK);
    loop {
        sleep(rest).await;
        let begin = Instant::now();
        let (over, open) = healings.into_iter().partition(|h| h.entry.is_over());
        healings = open;
        let over: Vec<Healing> = over;
        for healing in over {
            remember(&agent, &healing.targets, healing.entry.results());
        }
        if agent.lease.is_free(after) {
            healings.extend(heal(&agent, after, &mut quiet).await);
        } else {
            lock(&agent.failures).clear();
        }
        rest = (begin.elapsed() * REST).clamp(LOOK, MOST);
    }
}

/// Begins what is to be done and can be done beside what is under way: that may wait on purpose.
async fn heal(agent: &Arc<Agent>, after: Duration, quiet: &mut Option<Quiet>) -> Option<Healing> {
    let sealed = agent.ledger.lock().await.sealed().cloned()?;
    let spec = sealed.envelope();
    // Before looking at what is there: what ends meanwhile may not be seen yet.
    let open = agent.batches.beside()?;
    // What was seen last is enough to see that nothing is to be done, but not to act upon.
    let last = agent.inventory.last();
    let revision = last.revision;
    let holds = |quiet: &Quiet| quiet.holds(&sealed, revision);
    if quiet.as_ref().is_some_and(holds) {
        return None;
    }
    let blocked = || lock(&agent.failures).blocked();
    let now = |seen, blocked: &_| beside(&steps(agent, spec, seen, blocked), &open);
    let waits = blocked();
    if now(last, &waits).is_empty() {
        *quiet = (waits.is_empty() && open.is_empty()).then_some(Quiet {
            spec: sealed,
            revision,
        });
        return None;
    }
    let inventory = agent.observe().await;
    let revision = inventory.revision;
    let steps = now(inventory, &blocked());
    let signs = agent.lease.signs();
    if steps.is_empty() || !agent.lease.is_free(after) {
        return None;
    }
    agent.alone.acts(revision);
    agent.events.push(told(agent, steps.len()));
    let deadline = DEADLINE + patience(&steps, &agent.policies());
    let plan_id = format!("heal-{}", agent.inputs.chance.uuid());
    let targets = targets(&steps);
    let batch = batch(spec, plan_id.clone(), steps, deadline.min(MAX_DEADLINE));
    let entry = match agent.submit(batch).await {
        Ok(entry) => entry,
        // A newer spec has just come.
        Err(e) => {
            tracing::warn!("cannot heal: {e}");
            return None;
        }
    };
    tokio::spawn(give_way(agent.clone(), plan_id, entry.clone(), signs));
    Some(Healing { entry, targets })
}

/// Drops what is left of a batch as soon as a controller is heard of.
async fn give_way(
    agent: Arc<Agent>,
    plan_id: String,
    entry: Arc<Entry>,
    mut signs: watch::Receiver<Instant>,
) {
    tokio::select! {
        biased;
        () = entry.over() => {}
        _ = signs.changed() => {
            let reason = "a controller is there again; it decides";
            agent.batches.cancel(&plan_id, reason).await;
        }
    }
}

/// What is to be done now.
fn steps(
    agent: &Agent,
    spec: &NodeSpecEnvelope,
    inventory: Arc<Inventory>,
    blocked: &Blocked,
) -> Vec<Step> {
    let node = &agent.config.node;
    let desired = Desired {
        nodes: BTreeMap::from([(node.clone(), spec.spec.clone())]),
    };
    let observed = Observed {
        nodes: BTreeMap::from([(node.clone(), NodeObserved::Known(inventory))]),
    };
    plan(&desired, &observed, blocked).steps
}

fn batch(spec: &NodeSpecEnvelope, plan_id: String, steps: Vec<Step>, deadline: Duration) -> Batch {
    Batch {
        plan_id,
        cluster_uid: spec.cluster_uid.clone(),
        epoch: spec.epoch,
        generation: spec.generation,
        steps,
        gates: Vec::new(),
        deadline_ms: deadline.as_millis().try_into().unwrap_or(u64::MAX),
        parallelism: PARALLELISM,
        seen: None,
    }
}

fn targets(steps: &[Step]) -> BTreeMap<StepId, String> {
    let key = |step: &Step| (step.id, target::on(&step.node, &step.target));
    steps.iter().map(key).collect()
}

fn remember(agent: &Agent, targets: &BTreeMap<StepId, String>, results: Vec<BatchEvent>) {
    let mut failures = lock(&agent.failures);
    for result in results {
        if let BatchEvent::Finished {
            step,
            outcome: StepOutcome::Failed { reason },
            ..
        } = result
            && let Some(target) = targets.get(&step)
        {
            failures.failed(target.clone(), reason, agent.inputs.chance.unit());
        }
    }
}

fn told(agent: &Agent, steps: usize) -> AgentEvent {
    AgentEvent {
        kind: "Normal".to_owned(),
        reason: "Healing".to_owned(),
        object: target::node(&agent.config.node),
        system: None,
        message: format!("no controller is there; the agent takes {steps} steps by itself"),
    }
}
