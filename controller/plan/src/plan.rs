//! A plan is a value: changes for people, steps for executors, and what could not be planned and why.

mod step;
mod work;

use std::collections::BTreeMap;

use rts_schemas::system::DriftPolicy;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use self::step::{Because, Limit, OnTimeout, OrderName, Rule, Step, StepId};
pub use self::work::Work;

/// What to do. Empty when observed equals desired.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Plan {
    /// Differences between desired and observed, sorted by target.
    pub changes: Vec<Change>,
    /// Steps in an order that respects all needs; ids count from 1 in that order.
    pub steps: Vec<Step>,
    /// Processes that restart, and what else that stops.
    pub restarts: Vec<Restart>,
    /// What cannot be planned now, and why.
    pub waiting_on: Vec<WaitingOn>,
    /// What a person changed by hand since the system was applied, and what becomes of it. What is repaired is among the
    /// changes too; the rest is no difference.
    #[serde(default)]
    pub drift: Vec<Drift>,
    /// Remarks: what was made by hand, dropped preferences.
    pub notes: Vec<String>,
    /// The chain of steps that takes longest, until all that is brought up is up, first to last; see
    /// [`crate::critical_path`].
    #[serde(default)]
    pub critical_path: Vec<StepId>,
}

impl Plan {
    /// True when nothing differs, as far as can be seen.
    pub fn is_empty(&self) -> bool {
        self.changes.is_empty() && self.steps.is_empty()
    }

    /// SHA-256 over what would be done: targets, actions, fields and steps, without words and remarks. Two plans with one
    /// digest do the same, in the same order, to the same processes.
    pub fn digest(&self) -> String {
        let changes: Vec<_> = self
            .changes
            .iter()
            .map(|c| (c.action, &c.target, &c.system, &c.fields))
            .collect();
        let steps: Vec<_> = self
            .steps
            .iter()
            .map(|s| {
                let before = (&s.needs, &s.after_start_of, &s.after_end_of, &s.limits);
                (s.id, &s.node, &s.target, &s.work, before, s.wait_ms)
            })
            .collect();
        crate::place::digest_of(&(changes, steps))
    }

    /// True when nothing differs and nothing is waited for.
    pub fn in_step(&self) -> bool {
        self.is_empty() && self.waiting_on.is_empty()
    }
}

/// What a person changed by hand in one target.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Drift {
    /// `component/Filter0`, `connector/Sine0.out-Filter0.in`.
    pub target: String,
    /// System the target belongs to.
    pub system: String,
    /// What becomes of it (`rtsctl.drift` of the component, or of the connector's source).
    pub policy: DriftPolicy,
    /// What kind of difference it is.
    pub kind: DriftKind,
    /// What it is, in words (`was disconnected by hand`).
    pub reason: String,
    /// The fields that differ: `old` is desired, `new` is found. Names as in [`Change::fields`]; `state` for the
    /// lifecycle state. Of a connector that nobody desired: `source`, `target` and `properties.…`, all new.
    #[serde(default)]
    pub fields: Vec<FieldChange>,
}

/// Kind of a [`Drift`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub enum DriftKind {
    /// It is there, and differs.
    Changed,
    /// A connector that is there and not desired.
    Extra,
    /// A connector that is desired and not there.
    Missing,
}

/// One difference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Change {
    /// What happens to the target.
    pub action: Action,
    /// `component/Sine0`, `connector/Sine0.out-Filter0.in`, `manager/hello.main`.
    pub target: String,
    /// System the target belongs to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub system: Option<String>,
    /// Node of a manager: its system may have one of that name on each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// Why.
    pub reason: String,
    /// The fields that differ.
    #[serde(default)]
    pub fields: Vec<FieldChange>,
}

/// Kind of a change.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
#[serde(rename_all = "camelCase")]
pub enum Action {
    /// It is not there yet.
    Add,
    /// It is changed in place.
    Change,
    /// It is there and should not be.
    Remove,
    /// It must be stopped and made again.
    Restart,
}

/// One field of a change, as text.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct FieldChange {
    /// Path of the field (`configuration.default.gain`).
    pub field: String,
    /// Observed value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub old: Option<String>,
    /// Desired value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub new: Option<String>,
}

/// A process that stops and starts, or a component that is made again in a process that stays.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Restart {
    /// Node name.
    pub node: String,
    /// `hello.main`.
    pub manager: String,
    /// Process id that ends; `None` when the process goes on and only components are made again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pid: Option<u32>,
    /// Components that are made again.
    pub components: Vec<String>,
    /// Components of systems in it that stop and are not made again now.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub also_stopped: Vec<String>,
    /// Connectors that are cut by it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub connectors: Vec<String>,
    /// Components that stay, and lose a peer meanwhile.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub affected: Vec<Affected>,
    /// Why.
    pub reason: String,
}

/// A component that stays while one that it is connected with is made again. It stays as it is: the plan cuts the
/// connectors first, and what is planned is no loss for a policy (`rtsctl.onDisconnect`) to act on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Affected {
    /// Instance name.
    pub instance: String,
    /// Node name.
    pub node: String,
    /// Its process: `hello.main`.
    pub manager: String,
    /// It lacks samples; otherwise only its own go nowhere.
    pub starved: bool,
}

/// Something that has to wait.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct WaitingOn {
    /// What waits (`component/Motor0`).
    pub target: String,
    /// For what.
    pub reason: String,
    /// It is expected to pass by itself within moments (a question under way): nobody should act on it yet.
    #[serde(default)]
    pub transient: bool,
}

/// A system that can never be started as written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// Hard orders form a cycle; all its members are named.
    #[error("the {order} orders of system {system} form a cycle of {}", members.join(", "))]
    Cycle {
        /// System name.
        system: String,
        /// `Activation`, `StartUp`, …
        order: String,
        /// Instance names, sorted, each once; the first is repeated nowhere.
        members: Vec<String>,
    },
}

/// Blocked targets: what failed before and must not be tried again yet. [`target::on`](crate::target::on) → reason.
pub type Blocked = BTreeMap<String, String>;
