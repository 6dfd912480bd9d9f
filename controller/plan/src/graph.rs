//! The graph of steps: collects them with their edges, then numbers them in a deterministic topological order.
//!
//! Edges join steps, never components. Hard edges are needs, start orders and end orders; preferences are soft and give
//! way.

mod preferences;

use std::collections::{BTreeMap, BTreeSet};

pub(crate) use self::preferences::{Dropped, Preference};
use crate::desired::SystemRef;
use crate::plan::{Because, Limit, OnTimeout, Rule, Step, StepId, Work};

/// Index of a step before it has its number.
pub(crate) type Ix = usize;

/// What stands before a step because of an order.
#[derive(Debug, Clone, Default)]
pub(crate) struct Gate {
    /// Must have succeeded.
    pub needs: BTreeSet<Ix>,
    /// Must have started.
    pub starts: BTreeSet<Ix>,
    /// Must have ended.
    pub ends: BTreeSet<Ix>,
    /// How long it waits for some of them.
    pub limits: Vec<GateLimit>,
    /// Which rule put which of them there.
    pub because: Vec<(Ix, Rule)>,
    /// Milliseconds to sleep.
    pub wait_ms: u32,
    /// Why it cannot be done now.
    pub waits: Option<String>,
}

/// How long a step waits for others.
#[derive(Debug, Clone)]
pub(crate) struct GateLimit {
    pub steps: BTreeSet<Ix>,
    /// Milliseconds, above 0.
    pub ms: u32,
    pub then: OnTimeout,
}

#[derive(Debug)]
struct Draft {
    node: String,
    target: String,
    system: Option<SystemRef>,
    work: Work,
    reason: String,
    gate: Gate,
    prefers: BTreeSet<(Ix, Preference)>,
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
    /// Preferences that gave way.
    pub dropped: Vec<Dropped>,
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
        own.ends.extend(gate.ends);
        own.limits.extend(gate.limits);
        own.because.extend(gate.because);
        own.wait_ms = own.wait_ms.max(gate.wait_ms);
    }

    /// `step` should start after `on` has started.
    pub fn prefer(&mut self, step: Ix, on: Ix, why: Preference) {
        if step != on {
            self.drafts[step].prefers.insert((on, why));
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
        let hard = gate.needs.iter().chain(&gate.starts).chain(&gate.ends);
        let soft = self.prefers.iter().map(|(on, _)| on);
        hard.chain(soft).copied().collect()
    }

    fn into_step(self, id: StepId, ids: &BTreeMap<Ix, StepId>) -> Step {
        let number = |set: &BTreeSet<Ix>| {
            let mut numbers: Vec<_> = set.iter().filter_map(|ix| ids.get(ix).copied()).collect();
            numbers.sort_unstable();
            numbers
        };
        let because = self.because(ids);
        let gate = &self.gate;
        let ends = &gate.ends - &gate.needs;
        let preferred = self.prefers.iter().map(|(on, _)| on);
        let starts = gate.starts.iter().chain(preferred).copied();
        let more = |ix: &Ix| gate.needs.contains(ix) || ends.contains(ix);
        let starts: BTreeSet<Ix> = starts.filter(|ix| !more(ix)).collect();
        let limits = gate.limits.iter().map(|limit| Limit {
            steps: number(&limit.steps),
            ms: limit.ms,
            then: limit.then,
        });
        Step {
            id,
            needs: number(&gate.needs),
            after_start_of: number(&starts),
            after_end_of: number(&ends),
            limits: limits.filter(|limit| !limit.steps.is_empty()).collect(),
            because,
            node: self.node,
            target: self.target,
            system: self.system,
            wait_ms: self.gate.wait_ms,
            reason: self.reason,
            work: self.work,
        }
    }

    /// The rules of orders; a preference counts where no order says anything.
    fn because(&self, ids: &BTreeMap<Ix, StepId>) -> Vec<Because> {
        let ordered: BTreeSet<Ix> = self.gate.because.iter().map(|(ix, _)| *ix).collect();
        let soft = self.prefers.iter().filter(|(on, _)| !ordered.contains(on));
        let soft = soft.map(|(on, why)| (*on, why.rule(&self.work)));
        let all = self.gate.because.iter().copied().chain(soft);
        let because = |(ix, rule)| {
            let step = *ids.get(&ix)?;
            Some(Because { step, rule })
        };
        let mut all: Vec<Because> = all.filter_map(because).collect();
        all.sort_unstable();
        all.dedup();
        all
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
