//! Cuts a plan into one batch per node, with gates where a step needs another node's step. Pure.

use std::collections::{BTreeMap, BTreeSet};

use rts_agent_api::messages::Batch;
use rts_plan::plan::{Plan, StepId};

/// Steps that an agent carries out at once.
const PARALLELISM: u32 = 16;

/// Batches by node, in the name of a store (its cluster uid and epoch). A node whose NodeSpec generation is not given gets none.
pub fn cut(
    plan: &Plan,
    plan_id: &str,
    store: (&str, u64),
    generations: &BTreeMap<String, u64>,
    deadline_ms: u64,
) -> BTreeMap<String, Batch> {
    let node_of: BTreeMap<StepId, &str> =
        plan.steps.iter().map(|s| (s.id, s.node.as_str())).collect();
    let mut batches = BTreeMap::new();
    for step in &plan.steps {
        let Some(generation) = generations.get(&step.node) else {
            continue;
        };
        let batch = batches.entry(step.node.clone()).or_insert_with(|| Batch {
            plan_id: plan_id.to_owned(),
            cluster_uid: store.0.to_owned(),
            epoch: store.1,
            generation: *generation,
            steps: Vec::new(),
            gates: Vec::new(),
            deadline_ms,
            parallelism: PARALLELISM,
        });
        batch.steps.push(step.clone());
        let needed = step.needs.iter().chain(&step.after_start_of);
        let foreign = needed.filter(|id| node_of.get(id) != Some(&step.node.as_str()));
        batch.gates.extend(foreign);
    }
    for batch in batches.values_mut() {
        let gates: BTreeSet<_> = batch.gates.drain(..).collect();
        batch.gates.extend(gates);
    }
    batches
}
