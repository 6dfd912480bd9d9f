//! How long one component waits for others.
//!
//! Conditions are ANDed. A step is gone on without only when nothing else awaits it without a limit: another `Preceding`,
//! or a number in another list; the number beside a `Preceding` counts for less. Of several time-outs the longest holds
//! then. Who waits for a request alone is content with more than the request.

use std::collections::{BTreeMap, BTreeSet};

use super::walk::Passed;
use super::{Timeout, Wait};
use crate::graph::{Gate, GateLimit, Ix};
use crate::plan::{OnTimeout, OrderName, Rule};

/// What one component waits for, by what limits it.
#[derive(Debug, Default)]
pub(super) struct Limits {
    /// By number of the time-out.
    limited: BTreeMap<usize, (Rule, BTreeSet<Ix>)>,
    /// By a `Preceding` without a time-out.
    firm: BTreeSet<Ix>,
    /// By a sequence number of a list.
    numbered: BTreeMap<OrderName, BTreeSet<Ix>>,
}

impl Limits {
    pub fn add(&mut self, wait: Wait, source: &Passed<'_>) {
        match (wait.timeout, wait.rule) {
            (Some(timeout), rule) => {
                let limited = self.limited.entry(timeout);
                let (_, steps) = limited.or_insert_with(|| (rule, BTreeSet::new()));
                steps.extend(&source.own);
            }
            (None, Rule::Sequence { order }) => {
                let numbered = self.numbered.entry(order).or_default();
                numbered.extend(&source.through.needs);
                numbered.extend(&source.through.ends);
            }
            (None, _) => self.firm.extend(&source.own),
        }
    }

    pub fn settle(self, timeouts: &[Timeout], gate: &Gate) -> Vec<GateLimit> {
        let mut limits: Vec<GateLimit> = Vec::new();
        for (timeout, (rule, steps)) in &self.limited {
            let mut steps = steps.clone();
            let Timeout { ms, then } = timeouts[*timeout];
            if let Rule::Async { .. } = rule {
                steps.retain(|ix| !gate.needs.contains(ix) && !gate.ends.contains(ix));
            }
            if then == OnTimeout::GoOn {
                steps.retain(|ix| !self.is_firm(*rule, *ix));
            }
            limits.push(GateLimit { steps, ms, then });
        }
        keep_longest(&mut limits);
        limits.retain(|limit| !limit.steps.is_empty());
        limits
    }

    fn is_firm(&self, rule: Rule, ix: Ix) -> bool {
        let own = match rule {
            Rule::Sync { order } | Rule::Async { order } => Some(order),
            _ => None,
        };
        let mut others = self
            .numbered
            .iter()
            .filter(|(order, _)| Some(**order) != own);
        self.firm.contains(&ix) || others.any(|(_, steps)| steps.contains(&ix))
    }
}

/// Leaves each step that can be gone on without to the longest of its limits.
fn keep_longest(limits: &mut [GateLimit]) {
    let mut longest: BTreeMap<Ix, (u32, usize)> = BTreeMap::new();
    for (number, limit) in limits.iter().enumerate() {
        for ix in &limit.steps {
            let best = longest.entry(*ix).or_insert((limit.ms, number));
            *best = (*best).max((limit.ms, number));
        }
    }
    for (number, limit) in limits.iter_mut().enumerate() {
        if limit.then == OnTimeout::GoOn {
            limit.steps.retain(|ix| longest[ix].1 == number);
        }
    }
}
