//! Which steps of a batch may start. Knows numbers only: no clock, no work.

mod fault;
mod node;

use std::collections::{BTreeMap, BTreeSet};

use rts_plan::plan::{Step, StepId};

pub(crate) use fault::BatchFault;
pub(crate) use node::Missing;
use node::{News, Node, State};

/// The time of a limit starts to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Armed {
    /// Whose.
    pub step: StepId,
    /// Which of its limits.
    pub limit: usize,
    /// Milliseconds.
    pub ms: u32,
}

/// Steps that wait, and what for.
#[derive(Debug)]
pub(crate) struct Queue {
    nodes: BTreeMap<StepId, Node>,
    /// Who waits for whom, in whatever way.
    dependents: BTreeMap<StepId, BTreeSet<StepId>>,
    started: BTreeSet<StepId>,
    ready: BTreeSet<StepId>,
    armed: Vec<Armed>,
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
            armed: Vec::new(),
            left: steps.len(),
        };
        let ids: BTreeSet<_> = steps.iter().map(|s| s.id).collect();
        for step in steps {
            fault::check(step, &ids, &gates)?;
            for need in step.before() {
                queue.dependents.entry(need).or_default().insert(step.id);
            }
            let before = queue.nodes.insert(step.id, Node::new(step));
            if before.is_some() || gates.contains(&step.id) {
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

    /// Limits whose time starts now; each is given out once. When it is over, [`Queue::expire`] is to be told.
    pub fn take_armed(&mut self) -> Vec<Armed> {
        std::mem::take(&mut self.armed)
    }

    /// True when every step has ended.
    pub fn is_over(&self) -> bool {
        self.left == 0
    }

    /// Notes that a step, here or behind a gate, has started.
    pub fn started(&mut self, id: StepId) {
        if self.started.insert(id) {
            self.tell(id, News::Started);
        }
    }

    /// Notes that a step, here or behind a gate, has succeeded.
    pub fn succeeded(&mut self, id: StepId) {
        self.end(id);
        self.tell(id, News::Succeeded);
    }

    /// Notes that a step, here or behind a gate, has failed. Gives the steps that can never start now, each with the
    /// step that failed. Steps that only wait for the start or the end of a lost one wait for it no longer, and neither
    /// do those that go on without it when it takes too long.
    pub fn failed(&mut self, id: StepId) -> Vec<(StepId, StepId)> {
        self.end(id);
        let mut skipped = Vec::new();
        let mut lost = vec![id];
        while let Some(cause) = lost.pop() {
            for dependent in self.tell(cause, News::Lost) {
                self.end(dependent);
                skipped.push((dependent, id));
                lost.push(dependent);
            }
        }
        skipped.sort_unstable();
        skipped
    }

    /// Notes that the time of a limit is over. Gives the steps that were waited for in vain, when its own step fails for
    /// that: [`Queue::failed`] is then to be told of it.
    pub fn expire(&mut self, id: StepId, limit: usize) -> Vec<Missing> {
        let Some(node) = self.nodes.get_mut(&id) else {
            return Vec::new();
        };
        if node.state != State::Waiting {
            return Vec::new();
        }
        let missing = node.expire(limit);
        self.settle(id);
        missing
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

    /// Tells news of a step to who waits for it. Gives those that can never start now.
    fn tell(&mut self, id: StepId, news: News) -> Vec<StepId> {
        let dependents = self.dependents.get(&id);
        let dependents: Vec<_> = dependents.into_iter().flatten().copied().collect();
        let mut hopeless = Vec::new();
        for dependent in dependents {
            let Some(node) = self.nodes.get_mut(&dependent) else {
                continue;
            };
            if node.state != State::Waiting {
                continue;
            }
            if node.hear(id, news) {
                self.settle(dependent);
            } else {
                hopeless.push(dependent);
            }
        }
        hopeless
    }

    /// Makes a step ready if it waits for nothing more, and starts the time of its limits if it waits for nothing else.
    fn settle(&mut self, id: StepId) {
        let Some(node) = self.nodes.get_mut(&id) else {
            return;
        };
        if node.state != State::Waiting {
            return;
        }
        if node.is_free() {
            node.state = State::Begun;
            self.ready.insert(id);
        } else if node.arm() {
            let limits = node.limits().map(|(limit, ms)| Armed {
                step: id,
                limit,
                ms,
            });
            self.armed.extend(limits);
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
