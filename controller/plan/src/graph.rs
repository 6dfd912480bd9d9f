//! The graph of steps: collects them with their edges, then numbers them in a deterministic topological order.
//!
//! Edges join steps, never components. Hard edges are needs and start orders; preferences are soft and give way.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::algo::tarjan_scc;
use petgraph::graph::DiGraph;

use crate::desired::SystemRef;
use crate::plan::{Step, StepId, Work};

/// Index of a step before it has its number.
pub(crate) type Ix = usize;

/// What stands before a step because of an order.
#[derive(Debug, Clone, Default)]
pub(crate) struct Gate {
    /// Must have succeeded.
    pub needs: BTreeSet<Ix>,
    /// Must have started.
    pub starts: BTreeSet<Ix>,
    /// Milliseconds to sleep.
    pub wait_ms: u32,
    /// Why it cannot be done now.
    pub waits: Option<String>,
}

#[derive(Debug)]
struct Draft {
    node: String,
    target: String,
    system: Option<SystemRef>,
    work: Work,
    reason: String,
    gate: Gate,
    prefers: BTreeSet<Ix>,
}

/// Steps without numbers.
#[derive(Debug, Default)]
pub(crate) struct Steps {
    drafts: Vec<Draft>,
}

/// A step to add.
pub(crate) struct NewStep<'a> {
    pub node: &'a str,
    pub target: String,
    pub system: Option<&'a SystemRef>,
    pub work: Work,
    pub reason: String,
}

/// Numbered steps.
pub(crate) struct Numbered {
    pub steps: Vec<Step>,
    /// Groups of targets whose preferences were dropped.
    pub dropped: Vec<Vec<String>>,
    /// Targets of steps that can never start. Empty unless an order graph was built wrongly.
    pub stuck: Vec<String>,
}

impl Steps {
    pub fn add(&mut self, new: NewStep<'_>) -> Ix {
        self.drafts.push(Draft {
            node: new.node.to_owned(),
            target: new.target,
            system: new.system.cloned(),
            work: new.work,
            reason: new.reason,
            gate: Gate::default(),
            prefers: BTreeSet::new(),
        });
        self.drafts.len() - 1
    }

    /// `step` starts after all of `on` have succeeded.
    pub fn need(&mut self, step: Ix, on: impl IntoIterator<Item = Ix>) {
        self.drafts[step].gate.needs.extend(on);
    }

    /// `step` obeys an order.
    pub fn gate(&mut self, step: Ix, gate: Gate) {
        let own = &mut self.drafts[step].gate;
        own.needs.extend(gate.needs);
        own.starts.extend(gate.starts);
        own.wait_ms = own.wait_ms.max(gate.wait_ms);
    }

    /// `step` should start after `on` has started.
    pub fn prefer(&mut self, step: Ix, on: Ix) {
        if step != on {
            self.drafts[step].prefers.insert(on);
        }
    }

    /// Drops preferences inside cycles and numbers the steps.
    pub fn number(mut self) -> Numbered {
        let dropped = self.drop_preferences();
        let order = self.order();
        let mut ids: BTreeMap<Ix, StepId> = BTreeMap::new();
        for (ix, id) in order.iter().zip(1..) {
            ids.insert(*ix, id);
        }
        let mut stuck = BTreeSet::new();
        let mut steps = Vec::with_capacity(order.len());
        for (ix, draft) in self.drafts.into_iter().enumerate() {
            let Some(&id) = ids.get(&ix) else {
                stuck.insert(draft.target);
                continue;
            };
            steps.push(draft.into_step(id, &ids));
        }
        steps.sort_by_key(|step| step.id);
        Numbered {
            steps,
            dropped,
            stuck: stuck.into_iter().collect(),
        }
    }

    fn drop_preferences(&mut self) -> Vec<Vec<String>> {
        let mut graph: DiGraph<(), ()> = DiGraph::with_capacity(self.drafts.len(), 0);
        let nodes: Vec<_> = self.drafts.iter().map(|_| graph.add_node(())).collect();
        for (ix, draft) in self.drafts.iter().enumerate() {
            for before in draft.before() {
                graph.add_edge(nodes[before], nodes[ix], ());
            }
        }
        let mut dropped = Vec::new();
        for members in tarjan_scc(&graph) {
            let members: BTreeSet<Ix> = members.into_iter().map(|n| n.index()).collect();
            if members.len() < 2 {
                continue;
            }
            for ix in &members {
                self.drafts[*ix].prefers.retain(|on| !members.contains(on));
            }
            let targets: BTreeSet<_> = members.iter().map(|ix| &self.drafts[*ix].target).collect();
            dropped.push(targets.into_iter().cloned().collect());
        }
        dropped.sort();
        dropped
    }

    /// Kahn's algorithm, always taking the first ready step by kind, node and target.
    fn order(&self) -> Vec<Ix> {
        let mut after: Vec<Vec<Ix>> = vec![Vec::new(); self.drafts.len()];
        let mut open: Vec<usize> = vec![0; self.drafts.len()];
        for (ix, draft) in self.drafts.iter().enumerate() {
            for before in draft.before() {
                after[before].push(ix);
                open[ix] += 1;
            }
        }
        let key = |ix: Ix| {
            let draft = &self.drafts[ix];
            (rank(&draft.work), &draft.node, &draft.target, ix)
        };
        let mut ready: BTreeSet<_> = (0..self.drafts.len())
            .filter(|ix| open[*ix] == 0)
            .map(key)
            .collect();
        let mut order = Vec::with_capacity(self.drafts.len());
        while let Some((_, _, _, ix)) = ready.pop_first() {
            order.push(ix);
            for &next in &after[ix] {
                open[next] -= 1;
                if open[next] == 0 {
                    ready.insert(key(next));
                }
            }
        }
        order
    }
}

impl Draft {
    fn before(&self) -> BTreeSet<Ix> {
        let gate = &self.gate;
        let all = gate.needs.iter().chain(&gate.starts).chain(&self.prefers);
        all.copied().collect()
    }

    fn into_step(self, id: StepId, ids: &BTreeMap<Ix, StepId>) -> Step {
        let number = |set: &BTreeSet<Ix>| {
            let mut numbers: Vec<_> = set.iter().filter_map(|ix| ids.get(ix).copied()).collect();
            numbers.sort_unstable();
            numbers
        };
        let starts = self.gate.starts.union(&self.prefers).copied().collect();
        let starts = &starts - &self.gate.needs;
        Step {
            id,
            needs: number(&self.gate.needs),
            after_start_of: number(&starts),
            after_end_of: Vec::new(),
            limits: Vec::new(),
            because: Vec::new(),
            node: self.node,
            target: self.target,
            system: self.system,
            wait_ms: self.gate.wait_ms,
            reason: self.reason,
            work: self.work,
        }
    }
}

/// Place of a kind of work in a plan: take-down first, in reverse order. Every edge leads to the same or a higher rank.
fn rank(work: &Work) -> u8 {
    match work {
        Work::Deactivate { .. } => 0,
        Work::Disconnect { .. } => 1,
        Work::Delete { .. } => 2,
        Work::UnloadModule { .. } => 3,
        Work::StopManager { .. } => 4,
        Work::Install { .. } => 5,
        Work::StartManager { .. } => 6,
        Work::LoadModule { .. } => 7,
        Work::Create { .. } => 8,
        Work::Configure { .. } => 9,
        Work::Reset { .. } => 10,
        Work::Connect { .. } => 11,
        Work::Activate { .. } => 12,
    }
}
