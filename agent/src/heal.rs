//! Healing without a controller: the agent plans over its own node spec, and executes as it would for a controller.
//!
//! The session is the lease: nothing is begun while a controller is heard of, and what is left of a plan is dropped as
//! soon as one is heard of again.

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
use rts_plan::plan::{Step, StepId};
use rts_plan::{plan, target};
use tokio::time::sleep;

use crate::agent::Agent;
use crate::batches::MAX_DEADLINE;
use crate::events::lock;

pub(crate) use back_off::BackOff;
pub(crate) use lease::Lease;
use patience::patience;

/// How often the agent looks whether it has to act.
const LOOK: Duration = Duration::from_millis(250);
/// A plan that is not done by then, beside what its steps wait on purpose or may take longer than others, is made anew.
const DEADLINE: Duration = Duration::from_secs(120);
/// Most steps at once.
const PARALLELISM: u32 = 16;

/// Heals for as long as the agent runs.
pub(crate) async fn keep(agent: Arc<Agent>) {
    let Some(after) = agent.config.heal_after else {
        return;
    };
    loop {
        sleep(LOOK).await;
        if agent.lease.is_free(after) {
            heal(&agent, after).await;
        } else {
            lock(&agent.failures).clear();
        }
    }
}

async fn heal(agent: &Arc<Agent>, after: Duration) {
    let Some(spec) = agent.ledger.lock().await.held().cloned() else {
        return;
    };
    // What was seen last is enough to see that nothing is to be done, but not to act upon.
    if agent.batches.is_busy() || steps(agent, &spec, agent.inventory.last()).is_empty() {
        return;
    }
    let steps = steps(agent, &spec, agent.observe().await);
    let mut signs = agent.lease.signs();
    if steps.is_empty() || !agent.lease.is_free(after) {
        return;
    }
    agent.events.push(told(agent, steps.len()));
    let deadline = DEADLINE + patience(&steps, &agent.policies());
    let plan_id = format!("heal-{}", agent.inputs.chance.uuid());
    let batch = batch(&spec, plan_id.clone(), steps, deadline.min(MAX_DEADLINE));
    let targets = targets(&batch.steps);
    let entry = match agent.submit(batch).await {
        Ok(entry) => entry,
        // A newer spec has just come.
        Err(e) => {
            tracing::warn!("cannot heal: {e}");
            return;
        }
    };
    tokio::select! {
        biased;
        () = entry.over() => {}
        _ = signs.changed() => {
            let reason = "a controller is there again; it decides";
            agent.batches.cancel(&plan_id, reason).await;
            entry.over().await;
        }
    }
    remember(agent, &targets, entry.results());
}

/// What is to be done now.
fn steps(agent: &Agent, spec: &NodeSpecEnvelope, inventory: Inventory) -> Vec<Step> {
    let node = &agent.config.node;
    let desired = Desired {
        nodes: BTreeMap::from([(node.clone(), spec.spec.clone())]),
    };
    let blocked = lock(&agent.failures).blocked();
    let observed = Observed {
        nodes: BTreeMap::from([(node.clone(), NodeObserved::Known(inventory))]),
    };
    plan(&desired, &observed, &blocked).steps
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
