//! Which steps of a batch may start. Knows numbers only: no clock, no work.

use std::collections::{BTreeMap, BTreeSet};

use rts_plan::plan::{Step, StepId};

/// A batch that makes no sense.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum BatchFault {
    /// A number occurs twice.
    #[error("step {0} occurs twice, or is a gate too")]
    Twice(StepId),
    /// A need that nobody meets.
    #[error("step {step} needs step {need}, which is neither in the batch nor a gate")]
    Unknown {
        /// Which step.
        step: StepId,
        /// What it needs.
        need: StepId,
    },
    /// Steps that wait for each other, perhaps.
    #[error("step {step} needs step {need}, which comes after it")]
    Backwards {
        /// Which step.
        step: StepId,
        /// What it needs.
        need: StepId,
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Waits for others.
    Waiting,
    /// Was given out, or is under way.
    Begun,
    /// Has ended somehow.
    Over,
}

#[derive(Debug)]
struct Node {
    needs: BTreeSet<StepId>,
    starts: BTreeSet<StepId>,
    state: State,
}

/// Steps that wait, and what for.
#[derive(Debug)]
pub(crate) struct Queue {
    nodes: BTreeMap<StepId, Node>,
    /// Who waits for whom, in either way.
    dependents: BTreeMap<StepId, BTreeSet<StepId>>,
    started: BTreeSet<StepId>,
    ready: BTreeSet<StepId>,
    left: usize,
}

impl Queue {
    /// Checks the steps and what they need.
    pub fn new(steps: &[Step], gates: &[StepId]) -> Result<Self, BatchFault> {
        let gates: BTreeSet<_> = gates.iter().copied().collect();
        let mut queue = Self {
            nodes: BTreeMap::new(),
            dependents: BTreeMap::new(),
            started: BTreeSet::new(),
            ready: BTreeSet::new(),
            left: steps.len(),
        };
        let ids: BTreeSet<_> = steps.iter().map(|s| s.id).collect();
        for step in steps {
            for need in step.needs.iter().chain(&step.after_start_of).copied() {
                let id = step.id;
                if !ids.contains(&need) && !gates.contains(&need) {
                    return Err(BatchFault::Unknown { step: id, need });
                }
                if need >= id {
                    return Err(BatchFault::Backwards { step: id, need });
                }
                queue.dependents.entry(need).or_default().insert(id);
            }
            let node = Node {
                needs: step.needs.iter().copied().collect(),
                starts: step.after_start_of.iter().copied().collect(),
                state: State::Waiting,
            };
            if queue.nodes.insert(step.id, node).is_some() || gates.contains(&step.id) {
                return Err(BatchFault::Twice(step.id));
            }
            queue.settle(step.id);
        }
        Ok(queue)
    }

    /// Steps that may start now; each is given out once.
    pub fn take_ready(&mut self) -> BTreeSet<StepId> {
        std::mem::take(&mut self.ready)
    }

    /// True when every step has ended.
    pub fn is_over(&self) -> bool {
        self.left == 0
    }

    /// Notes that a step, here or behind a gate, has started.
    pub fn started(&mut self, id: StepId) {
        if self.started.insert(id) {
            for dependent in self.dependents_of(id) {
                if let Some(node) = self.nodes.get_mut(&dependent) {
                    node.starts.remove(&id);
                }
                self.settle(dependent);
            }
        }
    }

    /// Notes that a step, here or behind a gate, has succeeded.
    pub fn succeeded(&mut self, id: StepId) {
        self.end(id);
        for dependent in self.dependents_of(id) {
            if let Some(node) = self.nodes.get_mut(&dependent) {
                node.needs.remove(&id);
            }
            self.settle(dependent);
        }
    }

    /// Notes that a step, here or behind a gate, has failed. Gives the steps that can never start now, each with the
    /// step that failed. Steps that only wait for the start of a lost one wait for it no longer.
    pub fn failed(&mut self, id: StepId) -> Vec<(StepId, StepId)> {
        self.end(id);
        let mut skipped = Vec::new();
        let mut lost = vec![id];
        while let Some(cause) = lost.pop() {
            for dependent in self.dependents_of(cause) {
                let Some(node) = self.nodes.get_mut(&dependent) else {
                    continue;
                };
                if !node.needs.contains(&cause) {
                    node.starts.remove(&cause);
                    self.settle(dependent);
                } else if node.state == State::Waiting {
                    self.end(dependent);
                    skipped.push((dependent, id));
                    lost.push(dependent);
                }
            }
        }
        skipped.sort_unstable();
        skipped
    }

    /// Ends every step that has not started and gives their numbers.
    pub fn cancel(&mut self) -> Vec<StepId> {
        let ids: Vec<_> = self
            .nodes
            .iter()
            .filter(|(id, n)| n.state != State::Over && !self.started.contains(id))
            .map(|(id, _)| *id)
            .collect();
        for id in &ids {
            self.end(*id);
        }
        ids
    }

    fn dependents_of(&self, id: StepId) -> Vec<StepId> {
        let dependents = self.dependents.get(&id);
        dependents.map_or_else(Vec::new, |d| d.iter().copied().collect())
    }

    /// Makes a step ready if it waits for nothing more.
    fn settle(&mut self, id: StepId) {
        if let Some(node) = self.nodes.get_mut(&id)
            && node.state == State::Waiting
            && node.needs.is_empty()
            && node.starts.is_empty()
        {
            node.state = State::Begun;
            self.ready.insert(id);
        }
    }

    fn end(&mut self, id: StepId) {
        self.ready.remove(&id);
        if let Some(node) = self.nodes.get_mut(&id)
            && node.state != State::Over
        {
            node.state = State::Over;
            self.left -= 1;
        }
    }
}
