//! The graph of steps: collects them with their edges, then numbers them in a deterministic topological order.
//!
//! Edges join steps, never components. Hard edges are needs, start orders and end orders; preferences are soft and give
//! way.

mod preferences;

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

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

/// Numbers of steps; none for one that can never start.
struct Ids(Vec<Option<StepId>>);

impl Ids {
    fn get(&self, ix: Ix) -> Option<StepId> {
        self.0[ix]
    }
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

    /// True for a step that is given up when another fails.
    pub fn needs_any(&self, step: Ix) -> bool {
        !self.drafts[step].gate.needs.is_empty()
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
        let mut ids = Ids(vec![None; self.drafts.len()]);
        for (ix, id) in order.iter().zip(1..) {
            ids.0[*ix] = Some(id);
        }
        let mut drafts: Vec<Option<Draft>> = self.drafts.into_iter().map(Some).collect();
        let steps = order.into_iter().filter_map(|ix| {
            let (id, draft) = (ids.get(ix)?, drafts[ix].take()?);
            Some(draft.into_step(id, &ids))
        });
        let steps = steps.collect();
        let stuck: BTreeSet<String> = drafts.into_iter().flatten().map(|d| d.target).collect();
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
        let sorted = self.sorted();
        let mut place: Vec<usize> = vec![0; sorted.len()];
        for (nr, ix) in sorted.iter().enumerate() {
            place[*ix] = nr;
        }
        let free = (0..sorted.len()).filter(|ix| open[*ix] == 0);
        let mut ready: BinaryHeap<Reverse<usize>> = free.map(|ix| Reverse(place[ix])).collect();
        let mut order = Vec::with_capacity(sorted.len());
        while let Some(Reverse(nr)) = ready.pop() {
            let ix = sorted[nr];
            order.push(ix);
            for &next in &after[ix] {
                open[next] -= 1;
                if open[next] == 0 {
                    ready.push(Reverse(place[next]));
                }
            }
        }
        order
    }

    /// All steps by kind, node and target.
    fn sorted(&self) -> Vec<Ix> {
        let mut sorted: Vec<Ix> = (0..self.drafts.len()).collect();
        let key = |ix: Ix| {
            let draft = &self.drafts[ix];
            (rank(&draft.work), &draft.node, &draft.target, ix)
        };
        sorted.sort_unstable_by(|one, other| key(*one).cmp(&key(*other)));
        sorted
    }
}

impl Draft {
    /// What stands before it, each once.
    fn before(&self) -> Vec<Ix> {
        let gate = &self.gate;
        let hard = gate.needs.iter().chain(&gate.starts).chain(&gate.ends);
        let soft = self.prefers.iter().map(|(on, _)| on);
        let mut all: Vec<Ix> = hard.chain(soft).copied().collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    fn into_step(self, id: StepId, ids: &Ids) -> Step {
        let number = |set: &BTreeSet<Ix>| {
            let mut numbers: Vec<_> = set.iter().filter_map(|ix| ids.get(*ix)).collect();
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
    fn because(&self, ids: &Ids) -> Vec<Because> {
        let ordered: BTreeSet<Ix> = self.gate.because.iter().map(|(ix, _)| *ix).collect();
        let soft = self.prefers.iter().filter(|(on, _)| !ordered.contains(on));
        let soft = soft.map(|(on, why)| (*on, why.rule(&self.work)));
        let all = self.gate.because.iter().copied().chain(soft);
        let because = |(ix, rule)| {
            let step = ids.get(ix)?;
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
        Work::Unbind { .. } => 5,
        Work::Install { .. } => 6,
        Work::StartManager { .. } => 7,
        Work::LoadModule { .. } => 8,
        Work::Create { .. } => 9,
        Work::Configure { .. } => 10,
        Work::Reset { .. } => 11,
        Work::Connect { .. } => 12,
        Work::Activate { .. } => 13,
    }
}
