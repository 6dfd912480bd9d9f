//! Steps: what stands before each, and by which rule.

pub use rts_schemas::rts_profile::model::OrderKind as OrderName;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Work;
use crate::desired::SystemRef;

/// Number of a step in its plan, from 1.
pub type StepId = u32;

/// One step of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Step {
    /// Number, from 1.
    pub id: StepId,
    /// Node that carries it out.
    pub node: String,
    /// What it works on (`component/Sine0`).
    pub target: String,
    /// System it is for; `None` for what a person made by hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub system: Option<SystemRef>,
    /// Steps that must have succeeded before it starts.
    pub needs: Vec<StepId>,
    /// Steps that must have *started* before it starts (`ASYNC`, and preferences). One that failed or was skipped holds
    /// nothing up.
    #[serde(default)]
    pub after_start_of: Vec<StepId>,
    /// Steps that must have *ended*, well or not, before it starts: an optional component holds nobody up for longer
    /// than its own try takes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub after_end_of: Vec<StepId>,
    /// How long it waits at most for some of the steps above (`Preceding` with a time-out).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<Limit>,
    /// Milliseconds to sleep after its needs are met (`WaitTime`).
    #[serde(default)]
    pub wait_ms: u32,
    /// Why.
    pub reason: String,
    /// Which rule of an order, or which preference, put which step before it. Steps above that are not named here are
    /// what the work itself rests on (a process before what is loaded into it).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub because: Vec<Because>,
    /// What to do; its tag is the step's `kind`.
    #[serde(flatten)]
    pub work: Work,
}

impl Step {
    /// A step of no system that comes after nothing.
    pub fn new(id: StepId, node: impl Into<String>, target: impl Into<String>, work: Work) -> Self {
        Self {
            id,
            node: node.into(),
            target: target.into(),
            system: None,
            needs: Vec::new(),
            after_start_of: Vec::new(),
            after_end_of: Vec::new(),
            limits: Vec::new(),
            wait_ms: 0,
            reason: String::new(),
            because: Vec::new(),
            work,
        }
    }

    /// It without the rules that put others before it: they are told to people, and are most of what a step weighs.
    pub fn without_reasons(&self) -> Self {
        Self {
            id: self.id,
            node: self.node.clone(),
            target: self.target.clone(),
            system: self.system.clone(),
            needs: self.needs.clone(),
            after_start_of: self.after_start_of.clone(),
            after_end_of: self.after_end_of.clone(),
            limits: self.limits.clone(),
            wait_ms: self.wait_ms,
            reason: self.reason.clone(),
            because: Vec::new(),
            work: self.work.clone(),
        }
    }

    /// All steps that stand before it, in whatever way; one may occur twice.
    pub fn before(&self) -> impl Iterator<Item = StepId> + '_ {
        let all = self.needs.iter().chain(&self.after_start_of);
        all.chain(&self.after_end_of).copied()
    }
}

/// How long a step waits for others. It is counted from when everything else that stands before the step is met.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Limit {
    /// Which; each is also among the step's `needs`, `afterStartOf` or `afterEndOf`.
    pub steps: Vec<StepId>,
    /// Milliseconds, above 0.
    pub ms: u32,
    /// What happens then.
    pub then: OnTimeout,
}

/// What a step does when it has waited for long enough.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub enum OnTimeout {
    /// It fails, and is tried again as what fails is (bringing up).
    Fail,
    /// It goes ahead without them (taking down: nothing is kept alive by an order).
    GoOn,
}

/// Why one step stands before another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Because {
    /// The step before.
    pub step: StepId,
    /// The rule.
    pub rule: Rule,
}

/// A rule by which one step stands before another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "camelCase")]
pub enum Rule {
    /// A lower sequence number.
    Sequence {
        /// Of which order.
        order: OrderName,
    },
    /// `Preceding` with `SYNC`: the other must be in the state.
    Sync {
        /// Of which order.
        order: OrderName,
    },
    /// `Preceding` with `ASYNC` or `NO_SYNC`: the other must have been asked.
    Async {
        /// Of which order.
        order: OrderName,
    },
    /// A preference: a service provider comes up before its consumers, and goes down after them.
    ProviderFirst,
    /// A preference: what a source feeds comes up before the source.
    DownStreamFirst,
    /// A preference: a source goes down before what it feeds.
    UpStreamFirst,
}
