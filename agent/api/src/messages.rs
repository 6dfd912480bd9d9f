//! Messages of the agent API.

mod act;
mod bind;
mod port;
mod timings;

use std::collections::BTreeMap;

use rts_plan::desired::NodeSpec;
use rts_plan::observed::PortObserved;
use rts_plan::plan::{Step, StepId};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use self::act::{Act, ActRequest, Acted, MAX_TICKS};
pub use self::bind::{BindRequest, Bound};
pub use self::port::{InjectLine, InjectQuery, Injected, PortEvent};
pub use self::timings::{TimedSpan, Timings, TimingsQuery, micros};

/// Who an agent is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct NodeInfo {
    /// Node name.
    pub node: String,
    /// Program version.
    pub version: String,
    /// [`crate::PROTOCOL_VERSION`].
    pub protocol_version: u32,
    /// Unique id of this start of the agent.
    pub session: String,
    /// Process id.
    pub pid: u32,
}

/// A node's whole desired set and the fence that guards it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct NodeSpecEnvelope {
    /// Uid of the controller's store.
    pub cluster_uid: String,
    /// Raised each time a store is created or restored.
    pub epoch: u64,
    /// One monotone number per node over all its systems.
    pub generation: u64,
    /// SHA-256 over the JSON of `spec`, hexadecimal.
    pub digest: String,
    /// The ledger of another store that this one replaces, word by word as the agent told it; the agent refuses when
    /// its ledger is another by now. None: a ledger of another store is never replaced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub take_over: Option<LedgerFence>,
    /// The set.
    pub spec: NodeSpec,
}

/// What an agent's ledger holds: whose, and how new.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct LedgerFence {
    /// Uid of the store that it came from.
    pub cluster_uid: String,
    /// That store's epoch.
    pub epoch: u64,
    /// Generation of the node.
    pub generation: u64,
    /// SHA-256 over the JSON of the spec, hexadecimal.
    pub digest: String,
}

/// Which part of a component's log is wanted.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct LogQuery {
    /// Lines from the end, at most 10000; none for 200, or for all with `since` or `previous`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tail: Option<usize>,
    /// Stay, and send what is added, across rotations and restarts.
    #[serde(default)]
    pub follow: bool,
    /// Of the incarnation before the newest only; not with `follow`.
    #[serde(default)]
    pub previous: bool,
    /// Only lines from this time on, RFC 3339.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub since: Option<String>,
}

/// Answer to a [`NodeSpecEnvelope`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct NodeSpecReceipt {
    /// Generation that the ledger now holds.
    pub generation: u64,
    /// False when it held the very same already.
    pub changed: bool,
}

/// One node's part of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Batch {
    /// Unique id of the plan.
    pub plan_id: String,
    /// Uid of the controller's store; the agent refuses another than its ledger's.
    pub cluster_uid: String,
    /// Epoch of the controller's store; the agent refuses another than its ledger's.
    pub epoch: u64,
    /// The NodeSpec generation that the plan was made for; the agent refuses another.
    pub generation: u64,
    /// Steps of this node, in order; their needs may name steps of other nodes (`gates`).
    pub steps: Vec<Step>,
    /// Steps of other nodes that steps here need; reported by [`GateReport`].
    #[serde(default)]
    pub gates: Vec<StepId>,
    /// The whole batch ends within this time, failing what is not done.
    pub deadline_ms: u64,
    /// At most this many steps at once; at least 1.
    pub parallelism: u32,
    /// What was seen of this node when it was planned; the agent refuses it when it has acted alone since.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen: Option<Seen>,
}

/// Which inventory of a node a plan was made from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Seen {
    /// Session of the agent that told it.
    pub session: String,
    /// Revision of the inventory.
    pub revision: u64,
}

/// News of steps of other nodes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct GateReport {
    /// Steps that have started.
    #[serde(default)]
    pub started: Vec<StepId>,
    /// Steps that have succeeded.
    #[serde(default)]
    pub succeeded: Vec<StepId>,
    /// Steps that failed or were skipped: what needs them is skipped.
    #[serde(default)]
    pub failed: Vec<StepId>,
}

/// One line of a batch's results.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(
    tag = "type",
    rename_all = "camelCase",
    rename_all_fields = "camelCase"
)]
pub enum BatchEvent {
    /// First line.
    Accepted {
        /// Format of the stream: `rtsctl.dev/v1`.
        api_version: String,
        /// Id of the plan.
        plan_id: String,
    },
    /// A step has started.
    Started {
        /// Which.
        step: StepId,
    },
    /// A step has ended.
    Finished {
        /// Which.
        step: StepId,
        /// How.
        outcome: StepOutcome,
        /// How long it took, waits excluded, in microseconds.
        micros: u64,
    },
    /// Last line: all steps have ended.
    End,
}

/// How a step ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(
    tag = "result",
    rename_all = "camelCase",
    rename_all_fields = "camelCase"
)]
pub enum StepOutcome {
    /// Done, or found done already.
    Succeeded,
    /// Failed.
    Failed {
        /// For people: what, why, how to mend it.
        reason: String,
    },
    /// Not tried.
    Skipped {
        /// The step whose failure is the cause, or none when the batch was cancelled or ran out of time.
        because_of: Option<StepId>,
        /// For people.
        reason: String,
    },
}

/// Types whose modules are wanted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ResolveRequest {
    /// Type names.
    pub types: Vec<String>,
}

/// Where a module is, or where it was looked for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ModuleResolution {
    /// Type name.
    pub type_name: String,
    /// The module; none when it cannot be found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub module: Option<ModuleFile>,
    /// Files that were looked for, in order.
    #[serde(default)]
    pub searched: Vec<String>,
}

/// A module file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ModuleFile {
    /// Absolute path on the node.
    pub path: String,
    /// SHA-256, hexadecimal.
    pub digest: String,
    /// What it says of itself, asked in a process of its own; none when it cannot be opened.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<ModuleDescription>,
}

/// What a module says of itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ModuleDescription {
    /// Ports that its components have.
    pub ports: Vec<PortObserved>,
    /// Parameters with their defaults.
    pub parameters: BTreeMap<String, String>,
    /// Which values it allows, of parameters of which it says so.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub limits: BTreeMap<String, ParameterLimits>,
}

/// Which values a module allows, as an RTC Profile has it. What is empty is not said.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ParameterLimits {
    /// Type (`double`).
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub value_type: String,
    /// Constraint (`0<=x<=10`).
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub constraint: String,
}

/// Loads a module by hand.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ModuleRequest {
    /// Type name; its module is searched for in the module paths.
    #[serde(rename = "type")]
    pub type_name: String,
}

/// A module that a manager has opened.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Factory {
    /// Type name.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Vendor.
    pub vendor: String,
    /// Category.
    pub category: String,
    /// Version.
    pub version: String,
    /// One line.
    pub description: String,
    /// File.
    pub path: String,
    /// `name:direction:type` of each port.
    pub ports: Vec<String>,
    /// Parameters and their defaults.
    pub parameters: BTreeMap<String, String>,
}

/// Creates a component by hand, as OpenRTM's `create_component` does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct CreateByHand {
    /// Type name.
    #[serde(rename = "type")]
    pub type_name: String,
    /// Instance name; none for the type name and the first free number.
    #[serde(default)]
    pub instance: Option<String>,
    /// Parameters of the default configuration set, set before `on_initialize`.
    #[serde(default)]
    pub parameters: BTreeMap<String, String>,
    /// Rate in Hz.
    #[serde(default)]
    pub rate: Option<f64>,
}

/// What was made by hand.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct CreatedByHand {
    /// Node.
    pub node: String,
    /// Manager, as [`rts_plan::desired::ManagerKey::display_name`] shows it.
    pub manager: String,
    /// Instance name.
    pub instance: String,
}
