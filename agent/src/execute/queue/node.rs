//! One step of a queue: what it still waits for.

use std::collections::BTreeSet;

use rts_plan::plan::{Limit, OnTimeout, Step, StepId};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// Waits for others.
    Waiting,
    /// Was given out, or is under way.
    Begun,
    /// Has ended somehow.
    Over,
}

/// What became of another step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum News {
    Started,
    Succeeded,
    /// Failed, or will never be tried.
    Lost,
}

/// Steps that are waited for, by what is waited for. One may be in several.
#[derive(Debug, Default)]
struct Open {
    success: BTreeSet<StepId>,
    start: BTreeSet<StepId>,
    end: BTreeSet<StepId>,
}

impl Open {
    fn is_empty(&self) -> bool {
        self.success.is_empty() && self.start.is_empty() && self.end.is_empty()
    }

    fn contains(&self, id: StepId) -> bool {
        self.success.contains(&id) || self.start.contains(&id) || self.end.contains(&id)
    }

    /// What was lost is waited for no longer, except for its success, which never comes.
    fn hear(&mut self, id: StepId, news: News) {
        self.start.remove(&id);
        if news != News::Started {
            self.end.remove(&id);
        }
        if news == News::Succeeded {
            self.success.remove(&id);
        }
    }

    fn forget(&mut self, id: StepId) {
        self.success.remove(&id);
        self.start.remove(&id);
        self.end.remove(&id);
    }
}

/// A step.
#[derive(Debug)]
pub(super) struct Node {
    /// What it waits for without a limit.
    free: Open,
    /// What it waits for for a limited time.
    limited: Open,
    limits: Vec<Limit>,
    /// The time of its limits runs.
    armed: bool,
    pub state: State,
}

impl Node {
    pub fn new(step: &Step) -> Self {
        let named = step.limits.iter().flat_map(|limit| &limit.steps);
        let named: BTreeSet<StepId> = named.copied().collect();
        let part = |ids: &[StepId]| ids.iter().partition(|id| named.contains(id));
        let (limited_success, success) = part(&step.needs);
        let (limited_start, start) = part(&step.after_start_of);
        let (limited_end, end) = part(&step.after_end_of);
        Self {
            free: Open {
                success,
                start,
                end,
            },
            limited: Open {
                success: limited_success,
                start: limited_start,
                end: limited_end,
            },
            limits: step.limits.clone(),
            armed: false,
            state: State::Waiting,
        }
    }

    /// Takes news of another step. False when it can never start now.
    #[must_use]
    pub fn hear(&mut self, id: StepId, news: News) -> bool {
        self.free.hear(id, news);
        self.limited.hear(id, news);
        if news != News::Lost {
            return true;
        }
        if self.goes_on_without(id) {
            self.limited.forget(id);
        }
        !self.free.contains(id) && !self.limited.contains(id)
    }

    fn goes_on_without(&self, id: StepId) -> bool {
        let mut limits = self.limits.iter();
        limits.any(|limit| limit.then == OnTimeout::GoOn && limit.steps.contains(&id))
    }

    /// True when nothing stands before it any more.
    pub fn is_free(&self) -> bool {
        self.free.is_empty() && self.limited.is_empty()
    }

    /// True once, when only what is limited still stands before it: the time of its limits starts.
    pub fn arm(&mut self) -> bool {
        let arms = !self.armed && self.free.is_empty() && !self.limited.is_empty();
        self.armed |= arms;
        arms
    }

    /// Its limits: their numbers, and milliseconds.
    pub fn limits(&self) -> impl Iterator<Item = (usize, u32)> {
        let limits = self.limits.iter().enumerate();
        limits.map(|(number, limit)| (number, limit.ms))
    }

    /// The time of a limit is over: steps of it that have not ended are waited for no longer, or are given back when it
    /// is not to go on without them.
    pub fn expire(&mut self, number: usize) -> Vec<Missing> {
        let Some(limit) = self.limits.get(number) else {
            return Vec::new();
        };
        let steps = limit.steps.iter().copied();
        let open: Vec<StepId> = steps.filter(|id| self.limited.contains(*id)).collect();
        if limit.then == OnTimeout::GoOn {
            open.iter().for_each(|id| self.limited.forget(*id));
            return Vec::new();
        }
        let missing = open.into_iter().map(|step| Missing {
            step,
            start_only: !self.limited.success.contains(&step) && !self.limited.end.contains(&step),
        });
        missing.collect()
    }
}

/// A step that was waited for in vain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Missing {
    /// Which.
    pub step: StepId,
    /// Only its start was waited for.
    pub start_only: bool,
}
