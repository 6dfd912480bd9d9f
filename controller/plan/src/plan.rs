//! A plan is a value: changes for people, steps for executors, and what could not be planned and why.

use std::collections::BTreeMap;

use rts_schemas::system::{Configuration, DriftPolicy, ExecutionKind, OnDisconnect};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::desired::{ManagerKey, PlacedConnector, SystemRef};

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
    /// The chain of steps that takes longest, first to last; see [`crate::critical_path`].
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

/// A component that stays while one that it is connected with is made again.
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
    /// What it does by itself then.
    pub on_disconnect: OnDisconnect,
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

/// One of the seven orders of an RTS Profile.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
#[allow(missing_docs, reason = "named as in the profile")]
pub enum OrderName {
    StartUp,
    ShutDown,
    Activation,
    Deactivation,
    Resetting,
    Initializing,
    Finalizing,
}

impl OrderName {
    /// As the profile spells it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::StartUp => "StartUp",
            Self::ShutDown => "ShutDown",
            Self::Activation => "Activation",
            Self::Deactivation => "Deactivation",
            Self::Resetting => "Resetting",
            Self::Initializing => "Initializing",
            Self::Finalizing => "Finalizing",
        }
    }
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

/// What a step does. Every value that an executor needs is here.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all_fields = "camelCase")]
pub enum Work {
    /// Make sure that the module of a type is on the node.
    Install {
        /// Type name.
        type_name: String,
        /// SHA-256 that the file must have, when it was pinned.
        module_digest: Option<String>,
    },
    /// Start a manager process.
    StartManager {
        /// Which one.
        manager: ManagerKey,
    },
    /// Open a module in a manager.
    LoadModule {
        /// Where.
        manager: ManagerKey,
        /// Type name.
        type_name: String,
        /// SHA-256 that the file must have, when it was pinned.
        module_digest: Option<String>,
    },
    /// Create and initialise a component with its configuration; it ends Inactive.
    Create {
        /// Where.
        manager: ManagerKey,
        /// Instance name.
        instance: String,
        /// Type name.
        type_name: String,
        /// Kept with the component and reported back.
        recreate_hash: String,
        /// Configuration to start with.
        configuration: Configuration,
        /// Kind of its execution context.
        execution_kind: ExecutionKind,
        /// Rate in Hz; `None` leaves the module's default.
        rate: Option<f64>,
        /// What it does by itself when a peer is lost.
        #[serde(default)]
        on_disconnect: OnDisconnect,
    },
    /// Set configuration values, the active set and the rate of a component in place.
    Configure {
        /// Where.
        manager: ManagerKey,
        /// Instance name.
        instance: String,
        /// Values and active set to set; what is not named stays.
        configuration: Configuration,
        /// Rate in Hz; `None` leaves it.
        rate: Option<f64>,
        /// What it does by itself when a peer is lost; `None` leaves it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        on_disconnect: Option<OnDisconnect>,
    },
    /// Connect two ports. Carried out on the node of the source.
    Connect {
        /// The connector, with both ends' places.
        connector: PlacedConnector,
    },
    /// Activate a component.
    Activate {
        /// Where.
        manager: ManagerKey,
        /// Instance name.
        instance: String,
    },
    /// Deactivate a component.
    Deactivate {
        /// Where.
        manager: ManagerKey,
        /// Instance name.
        instance: String,
    },
    /// Take a component out of Error into Inactive.
    Reset {
        /// Where.
        manager: ManagerKey,
        /// Instance name.
        instance: String,
    },
    /// Remove a connector at its source.
    Disconnect {
        /// Manager of the source.
        manager: ManagerKey,
        /// Instance that owns it.
        instance: String,
        /// Connector name.
        connector: String,
    },
    /// Finalise and delete a component.
    Delete {
        /// Where.
        manager: ManagerKey,
        /// Instance name.
        instance: String,
    },
    /// Forget a module that no component uses any more.
    UnloadModule {
        /// Where.
        manager: ManagerKey,
        /// Type name.
        type_name: String,
    },
    /// Stop a manager process and wait until it and its group are gone.
    StopManager {
        /// Which one.
        manager: ManagerKey,
        /// The start that is meant: another one is left alone.
        incarnation: String,
    },
}

impl Work {
    /// The process that it is done in; none for what concerns two, or none.
    pub fn manager(&self) -> Option<&ManagerKey> {
        match self {
            Work::Install { .. } | Work::Connect { .. } => None,
            Work::StartManager { manager }
            | Work::LoadModule { manager, .. }
            | Work::UnloadModule { manager, .. }
            | Work::Create { manager, .. }
            | Work::Configure { manager, .. }
            | Work::Activate { manager, .. }
            | Work::Deactivate { manager, .. }
            | Work::Reset { manager, .. }
            | Work::Disconnect { manager, .. }
            | Work::Delete { manager, .. }
            | Work::StopManager { manager, .. } => Some(manager),
        }
    }

    /// Name of the kind, as in JSON.
    pub fn kind(&self) -> &'static str {
        match self {
            Work::Install { .. } => "Install",
            Work::StartManager { .. } => "StartManager",
            Work::LoadModule { .. } => "LoadModule",
            Work::Create { .. } => "Create",
            Work::Configure { .. } => "Configure",
            Work::Connect { .. } => "Connect",
            Work::Activate { .. } => "Activate",
            Work::Deactivate { .. } => "Deactivate",
            Work::Reset { .. } => "Reset",
            Work::Disconnect { .. } => "Disconnect",
            Work::Delete { .. } => "Delete",
            Work::UnloadModule { .. } => "UnloadModule",
            Work::StopManager { .. } => "StopManager",
        }
    }
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
