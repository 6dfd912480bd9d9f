//! Observed state: what the agents found when they were asked. Never what was sent to them.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rts_schemas::system::{
    Configuration, Direction, ExecutionKind, OnDisconnect, PortKind, PortRef, Realtime,
    SharedExecutionContext,
};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::desired::{ManagerKey, SystemRef};

/// Everything that was observed, by node. A node that is not here is unknown.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observed {
    /// One entry per node that was asked.
    pub nodes: BTreeMap<String, NodeObserved>,
}

/// Answer of one node. A silent agent is unknown, never empty.
#[derive(Debug, Clone, PartialEq)]
pub enum NodeObserved {
    /// The agent did not answer.
    Unknown {
        /// Why, for people.
        reason: String,
    },
    /// The agent's inventory. Shared: it is most of what is known, and many look at it.
    Known(Arc<Inventory>),
}

/// What really runs on a node, collected by its agent by asking every manager.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Inventory {
    /// Node name.
    pub node: String,
    /// Raised by the agent when anything but a counter changed.
    pub revision: u64,
    /// Manager processes that are alive.
    pub managers: Vec<ManagerObserved>,
    /// Components that are not brought up again, since their process ended by itself and their restart policy or its
    /// limit forbids it. Decided and kept durably by the agent until the system changes.
    #[serde(default)]
    pub held: Vec<Held>,
}

/// A component that is not brought up again.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Held {
    /// Its system.
    pub system: SystemRef,
    /// Instance name.
    pub instance: String,
    /// [`NodeSystem::digest`] of the part of its system under which this was decided: another part ends it. None ends
    /// with nothing.
    ///
    /// [`NodeSystem::digest`]: crate::desired::NodeSystem::digest
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Why, and how to mend it.
    pub reason: String,
}

/// A live manager process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ManagerObserved {
    /// Which one.
    pub key: ManagerKey,
    /// Unique id of this start.
    pub incarnation: String,
    /// Process id.
    pub pid: u32,
    /// Wall-clock start, RFC 3339; for display.
    pub started: String,
    /// False when it did not answer in time (stopped, hanging); its contents are then those last seen.
    pub responsive: bool,
    /// True when it does not answer and may hold more than the contents here: it has never answered since its agent knows
    /// it, or not since something was to be made in it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub unseen: bool,
    /// Why its process must be replaced: something in it hangs for longer than its policy allows and asks for that
    /// (`rtsctl.onHang: restart`). Decided by the agent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expired: Option<String>,
    /// Type names of loaded modules.
    pub modules: BTreeSet<String>,
    /// Type name → SHA-256 of the module file that it opened, as far as it knows; also of modules that it forgot since,
    /// whose code stays mapped all the same.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub opened: BTreeMap<String, String>,
    /// Components that it holds.
    pub components: Vec<ComponentObserved>,
    /// What goes on in it besides. Raises no revision.
    #[serde(default, skip_serializing_if = "Activity::is_empty")]
    pub activity: Activity,
}

/// What goes on in a manager process, and is nothing that anybody plans.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Activity {
    /// Who looks at ports, or writes to them, outside of connectors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub taps: Vec<TapObserved>,
    /// What the process uses of its machine; none where nobody knows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub usage: Option<Usage>,
}

impl Activity {
    /// True when nothing is known of it.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Somebody looks at a port (`rtsctl port print`), or writes to one.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct TapObserved {
    /// The port.
    pub port: String,
    /// `print` or `inject`.
    pub way: String,
}

/// What a process uses of its machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Usage {
    /// Processor time of all its threads, in milliseconds. A counter.
    pub cpu_ms: u64,
    /// Memory that is its own and in use, in bytes.
    pub memory: u64,
}

/// Lifecycle state of a component (OMG RTC 1.0, 5.2.2.3).
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
pub enum LifeCycleState {
    /// Made, not initialised.
    Created,
    /// Initialised; does nothing.
    Inactive,
    /// Its `on_execute` runs.
    Active,
    /// Stopped by its own failure.
    Error,
}

/// A component that exists in a manager.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ComponentObserved {
    /// Instance name.
    pub instance: String,
    /// Type name.
    #[serde(rename = "type")]
    pub type_name: String,
    /// The system it was created for; `None` when a person created it by hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub system: Option<SystemRef>,
    /// Unique id of this creation.
    pub incarnation: String,
    /// The hash that it was created with.
    pub recreate_hash: String,
    /// It is a stand-in.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stand_in: bool,
    /// State now.
    pub state: LifeCycleState,
    /// Why it is in Error, or what it last complained about.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
    /// How often it was created again after its process died.
    pub restarts: u32,
    /// Wall-clock creation, RFC 3339; for display.
    pub created: String,
    /// Configuration sets as they are now, with the module's defaults filled in.
    pub configuration: Configuration,
    /// Parameters with the module's defaults.
    #[serde(default)]
    pub defaults: BTreeMap<String, String>,
    /// The callback that does not return (`has been in on_execute for 11 s`); none while all is well. Its seconds
    /// raise no revision.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hangs: Option<String>,
    /// What it does by itself when a peer is lost.
    #[serde(default)]
    pub on_disconnect: OnDisconnect,
    /// Kind of its execution context.
    pub execution_kind: ExecutionKind,
    /// The execution context that it shares; none for its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub execution_context: Option<SharedExecutionContext>,
    /// All components of the one that it shares, in the order in which they run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub runs_with: Vec<String>,
    /// Rate of its execution context in Hz.
    pub rate: f64,
    /// `on_execute` calls since creation. A counter: raises no revision.
    pub executions: u64,
    /// How its execution context keeps its time; none before the first cycle. Raises no revision.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timing: Option<TimingObserved>,
    /// What its execution context has of its node; none where nothing was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub realtime: Option<RealtimeObserved>,
    /// Ports that it really has.
    pub ports: Vec<PortObserved>,
    /// Connectors of which it is the source (data: the out-port end).
    pub connectors: Vec<ConnectorObserved>,
    /// Ends of connectors at its in-ports, with and without a source. None from an agent that does not say.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bindings: Vec<BindingObserved>,
    /// What a person changed in it since the plan last did.
    #[serde(default, skip_serializing_if = "ByHand::is_empty")]
    pub by_hand: ByHand,
}

/// What an execution context was to have of its node, and what it has.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct RealtimeObserved {
    /// What was asked for.
    pub asked: Realtime,
    /// How it is scheduled (`SCHED_FIFO`, `SCHED_OTHER`).
    pub scheduler: String,
    /// Its priority; 0 without SCHED_FIFO.
    pub priority: u8,
    /// Processors that it may run on, as cpuset(7) lists them.
    pub cpus: String,
    /// The memory of its process is locked.
    pub memory_locked: bool,
    /// What was asked for and is not permitted, and why.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub denied: Vec<String>,
}

/// How an execution context keeps its time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct TimingObserved {
    /// Cycles of a periodic one that were not over when the next was due.
    pub overruns: u64,
    /// Cycles in the last whole second; none before there was one, or from a manager that does not count them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reached: Option<u64>,
    /// How long cycles took.
    pub execution: DurationsObserved,
    /// How late cycles of a periodic one began.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jitter: Option<DurationsObserved>,
}

/// Durations in nanoseconds, the shares to a quarter.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct DurationsObserved {
    /// How many.
    pub count: u64,
    /// Half are below.
    pub median: u64,
    /// 99 of 100 are below.
    pub p99: u64,
    /// 999 of 1000 are below; 0 from a manager that does not say.
    #[serde(default)]
    pub p999: u64,
    /// The longest.
    pub max: u64,
    /// `[below, count]`: how many are below each power of two and not below half of it, where there are any.
    pub buckets: Vec<(u64, u64)>,
}

/// What a person changed in a component, each with a mark that says what was desired at that moment: once something
/// else is desired, the change is no drift any more, but simply what the new wish replaces. Kept by the manager, to
/// which a mark is a text without a meaning.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ByHand {
    /// Configuration values or the active set were set by hand: which, and what was desired of each
    /// ([`Mark`](crate::mark::Mark)).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configured: Option<String>,
    /// It was deactivated by hand, over [`PlacedComponent::settings_digest`]. Whatever is desired of it later, this
    /// counts until it is activated or made again: that it is to be Active never changes.
    ///
    /// [`PlacedComponent::settings_digest`]: crate::desired::PlacedComponent::settings_digest
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deactivated: Option<String>,
    /// Connectors of its out-ports that were disconnected by hand: name → [`PlacedConnector::digest`].
    ///
    /// [`PlacedConnector::digest`]: crate::desired::PlacedConnector::digest
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub disconnected: BTreeMap<String, String>,
}

impl ByHand {
    /// True when nothing was changed by hand.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// A port that a component really has.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct PortObserved {
    /// Bare name.
    pub name: String,
    /// Data or service.
    pub kind: PortKind,
    /// Direction of a data port.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<Direction>,
    /// IDL repository id of its type.
    pub data_type: String,
}

/// A connector as its owning end sees it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ConnectorObserved {
    /// Connector name.
    pub name: String,
    /// Source end; its instance is the component that lists it.
    pub source: PortRef,
    /// Target end.
    pub target: PortRef,
    /// Incarnation of the target component when it was connected: shows a restarted end.
    pub target_incarnation: String,
    /// Properties that it was made with.
    pub properties: BTreeMap<String, String>,
    /// Made by a person: over [`PlacedConnector::digest`] of the desired connector of this name, or over the empty text
    /// where none was desired. None for one that a plan made.
    ///
    /// [`PlacedConnector::digest`]: crate::desired::PlacedConnector::digest
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_hand: Option<String>,
    /// State now.
    pub state: ConnectorState,
    /// Kind of transport (`direct` in one process, `uds` between processes).
    pub transport: String,
    /// Samples written to the connector. A counter.
    pub samples_sent: u64,
    /// Samples read by the in-port's component, as last reported by the other end. A counter.
    pub samples_received: u64,
    /// Payload bytes sent. A counter.
    pub bytes: u64,
    /// Samples dropped from a full buffer. A counter.
    pub drops: u64,
    /// Jumps in the sequence that the reader saw. A counter.
    #[serde(default)]
    pub gaps: u64,
    /// Samples written in the last whole second.
    #[serde(default)]
    pub rate: u64,
    /// Of the samples received; none before the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latency: Option<Latency>,
}

/// Time from the write of a sample to the read of it, over one connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Latency {
    /// Samples measured. A counter.
    pub count: u64,
    /// The shortest, in nanoseconds.
    pub min_ns: u64,
    /// Half of them took no longer; up to twice too high.
    pub median_ns: u64,
    /// 99 of 100 took no longer; up to twice too high.
    pub p99_ns: u64,
    /// The longest, in nanoseconds.
    pub max_ns: u64,
}

/// The end of a connector at an in-port, which lets its source connect. It stays there without one until it is unbound.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct BindingObserved {
    /// Connector name.
    pub connector: String,
    /// Bare name of the in-port.
    pub port: String,
    /// Who may connect; none from a manager that does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<PortRef>,
    /// A source is connected.
    pub connected: bool,
    /// Samples read by the in-port's component over the connection. A counter.
    #[serde(default)]
    pub samples_received: u64,
    /// Samples dropped from the in-port's full buffer. A counter.
    #[serde(default)]
    pub drops: u64,
    /// Jumps in the sequence that the reader saw. A counter.
    #[serde(default)]
    pub gaps: u64,
}

/// State of a connector.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
pub enum ConnectorState {
    /// Both ends agreed; samples can flow.
    Connected,
    /// Being made.
    Connecting,
    /// The other end is gone.
    Disconnected,
}
