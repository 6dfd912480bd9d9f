//! Cuts a plan into one batch per node, with gates where a step needs another node's step. Pure.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use rts_agent_api::messages::Batch;
use rts_plan::plan::{Plan, StepId};

use super::run::{Accepted, Store};

/// Steps that an agent carries out at once.
const PARALLELISM: u32 = 16;

/// Batches by node, in the name of a store (its cluster uid and epoch). A node of which is not given what it accepts gets none.
pub fn cut(
    plan: &Plan,
    plan_id: &str,
    store: Store<'_>,
    accepted: &BTreeMap<String, Accepted>,
    deadline_ms: u64,
) -> BTreeMap<String, Batch> {
    let steps = plan.steps.iter();
    let node_of: HashMap<StepId, &str> = steps.map(|s| (s.id, s.node.as_str())).collect();
    let mut batches = BTreeMap::new();
    for step in &plan.steps {
        let Some(Accepted { generation, seen }) = accepted.get(&step.node) else {
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
            seen: seen.clone(),
        });
        // An agent never reads them.
        batch.steps.push(step.without_reasons());
        let foreign = |id: &StepId| node_of.get(id) != Some(&step.node.as_str());
        let foreign = step.before().filter(foreign);
        batch.gates.extend(foreign);
    }
    for batch in batches.values_mut() {
        let gates: BTreeSet<_> = batch.gates.drain(..).collect();
        batch.gates.extend(gates);
    }
    batches
}

#[cfg(test)]
mod tests {
    use rts_plan::plan::{Because, OrderName, Rule, Step, Work};

    use super::*;

    fn step(id: StepId, node: &str) -> Step {
        Step::new(
            id,
            node,
            format!("package/T{id}@{node}"),
            Work::Install {
                type_name: format!("T{id}"),
                module_digest: None,
            },
        )
    }

    #[test]
    fn every_edge_from_another_node_is_a_gate_once() {
        let mut last = step(4, "local");
        last.needs = vec![1];
        last.after_start_of = vec![2];
        last.after_end_of = vec![2, 3];
        let order = OrderName::Activation;
        let rule = Rule::Sync { order };
        last.because = vec![Because { step: 1, rule }];
        let steps = vec![step(1, "local"), step(2, "robot"), step(3, "robot"), last];
        let plan = Plan {
            steps,
            ..Plan::default()
        };
        let accepts = |generation| Accepted {
            generation,
            seen: None,
        };
        let accepted = [
            ("local".to_owned(), accepts(5)),
            ("robot".to_owned(), accepts(6)),
        ];
        let batches = cut(&plan, "p", ("c", 1), &accepted.into(), 1_000);
        assert_eq!(batches["local"].gates, [2, 3]);
        assert!(batches["robot"].gates.is_empty());
        assert_eq!(
            (batches["robot"].generation, batches["local"].steps.len()),
            (6, 2)
        );
        assert!(batches["local"].steps.iter().all(|s| s.because.is_empty()));
    }
}
