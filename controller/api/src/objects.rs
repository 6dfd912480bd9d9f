//! Objects of the API: `apiVersion, kind, metadata, spec, status`.

use std::collections::BTreeMap;
use std::sync::Arc;

use jiff::Timestamp;
use rts_agent_api::messages::LedgerFence;
use rts_agent_api::session::Transport;
pub use rts_plan::observed::{Activity, Latency, TapObserved, TimingObserved, Usage};
use rts_plan::observed::{PortObserved, RealtimeObserved};
use rts_schemas::system::{
    CompositeKind, Configuration, PortKind, SharedExecutionContext, SystemSpec,
};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Kinds of objects.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
pub enum Kind {
    /// A deployed system. Its spec is shared: it is large, and does not change when the rest does.
    System,
    /// A machine with an agent.
    Node,
    /// An RT-Component.
    Component,
    /// A connector between two ports.
    Connector,
    /// A process that holds components.
    Manager,
    /// Something that happened.
    Event,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 6] = [
        Kind::System,
        Kind::Node,
        Kind::Component,
        Kind::Connector,
        Kind::Manager,
        Kind::Event,
    ];

    /// Lower-case plural, as in paths and on the command line.
    pub fn plural(self) -> &'static str {
        match self {
            Kind::System => "systems",
            Kind::Node => "nodes",
            Kind::Component => "components",
            Kind::Connector => "connectors",
            Kind::Manager => "managers",
            Kind::Event => "events",
        }
    }
}

/// What every object has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Object<Spec, Status> {
    /// [`crate::API_VERSION`].
    pub api_version: String,
    /// Kind.
    pub kind: Kind,
    /// Name, identity, version.
    pub metadata: Metadata,
    /// What is wanted.
    pub spec: Spec,
    /// What is.
    pub status: Status,
}

/// An object without its spec (`spec=false`), for those who follow how it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ObjectState<Status> {
    /// [`crate::API_VERSION`].
    pub api_version: String,
    /// Kind.
    pub kind: Kind,
    /// Name, identity, version.
    pub metadata: Metadata,
    /// What is.
    pub status: Status,
}

impl<Status> ObjectState<Status> {
    /// The object, by who knows its spec.
    pub fn with_spec<Spec>(self, spec: Spec) -> Object<Spec, Status> {
        Object {
            api_version: self.api_version,
            kind: self.kind,
            metadata: self.metadata,
            spec,
            status: self.status,
        }
    }
}

/// Name, identity and version of an object.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Metadata {
    /// Name, unique in its kind (and node or system).
    pub name: String,
    /// Identity: another object of the same name has another.
    #[serde(default)]
    pub uid: String,
    /// Changes with every change but those of counters, heartbeats and ages.
    #[serde(default)]
    pub resource_version: String,
    /// Raised by each change of the spec.
    #[serde(default)]
    pub generation: u64,
    /// Labels.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub labels: BTreeMap<String, String>,
    /// When it was made.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub creation_timestamp: Option<Timestamp>,
    /// When its deletion was asked for; it goes away once everything has stopped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub deletion_timestamp: Option<Timestamp>,
}

/// One aspect of an object's state.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Condition {
    /// CamelCase (`Synced`, `Healthy`, `Progressing`).
    #[serde(rename = "type")]
    pub kind: String,
    /// `True`, `False`, `Unknown`.
    pub status: String,
    /// One CamelCase word.
    pub reason: String,
    /// For people.
    pub message: String,
    /// When `status` last changed.
    #[schema(value_type = String, format = DateTime)]
    pub last_transition_time: Timestamp,
    /// Generation that it speaks of.
    #[serde(default)]
    pub observed_generation: u64,
}

/// A deployed system. Its spec is shared: it is large, and does not change when the rest does.
pub type System = Object<Arc<SystemSpec>, SystemStatus>;
/// A deployed system without its spec.
pub type SystemState = ObjectState<SystemStatus>;
/// A node.
pub type Node = Object<NodeSpecView, NodeStatus>;
/// A component.
pub type Component = Object<ComponentView, ComponentStatus>;
/// A connector.
pub type Connector = Object<ConnectorView, ConnectorStatus>;
/// A manager.
pub type Manager = Object<ManagerView, ManagerStatus>;
/// An event.
pub type Event = Object<EventView, EventStatus>;

/// Where a system is on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
pub enum Phase {
    /// Steps are being carried out, or will be at once.
    #[default]
    Progressing,
    /// Nothing is left to do and everything required is healthy.
    Converged,
    /// Something failed and waits for its next try, or cannot be done.
    Degraded,
    /// Being taken down.
    Terminating,
}

/// State of a system.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct SystemStatus {
    /// Generation that the rest speaks of.
    pub observed_generation: u64,
    /// Where it is on its way.
    pub phase: Phase,
    /// Observed equals desired.
    pub synced: bool,
    /// Every required component is Active and every connector Connected.
    pub healthy: bool,
    /// Aspects.
    #[serde(default)]
    pub conditions: Vec<Condition>,
    /// Steps of the plan that is being carried out.
    #[serde(default)]
    pub progress: Progress,
    /// What does not go on, and why.
    #[serde(default)]
    pub waiting_on: Vec<Waiting>,
    /// Which host of the profile went to which node, and other remarks.
    #[serde(default)]
    pub notes: Vec<String>,
    /// What runs and is in no spec, and what was changed by hand.
    #[serde(default)]
    pub drift: Vec<String>,
    /// Number of the stored system's last change ([`crate::requests::Expect::index`]). It rises, and names no other
    /// change, also after a teardown.
    #[serde(default)]
    pub check_index: u64,
    /// Of a system that is being taken down: nodes that cannot be asked whether anything of it is left, once nothing is
    /// left on all others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tombstones: Vec<String>,
    /// Nodes that it lies on, or of which something of it may be left.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<String>,
    /// Number of components in the spec.
    #[serde(default)]
    pub components: u32,
    /// Number of those that are Active.
    #[serde(default)]
    pub active: u32,
    /// Number of components whose place a stand-in takes.
    #[serde(default)]
    pub stand_ins: u32,
}

/// Progress of a plan.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Progress {
    /// Steps that have succeeded.
    pub done: u32,
    /// All steps.
    pub total: u32,
    /// What runs now (`Activate component/Sine0`), at most 8.
    #[serde(default)]
    pub running: Vec<String>,
}

/// Something that does not go on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Waiting {
    /// `component/Motor0`.
    pub target: String,
    /// Why.
    pub reason: String,
    /// The system cannot be healthy without it.
    pub required: bool,
    /// It is expected to pass by itself within moments.
    #[serde(default)]
    pub transient: bool,
    /// Tries so far.
    #[serde(default)]
    pub tries: u32,
    /// When it is tried again; none when it waits for something else.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub next_try: Option<Timestamp>,
}

/// What a node is.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct NodeSpecView {
    /// Socket of its agent.
    pub endpoint: String,
    /// Hosts in profiles that mean this node.
    #[serde(default)]
    pub aliases: Vec<String>,
    /// How it is reached, where it is not of this machine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transport: Option<Transport>,
}

/// State of a node.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct NodeStatus {
    /// `Ready`, `NotReady`, `Unknown`; `OnDemand` for one that is reached by SSH when a command needs it.
    pub state: String,
    /// Last heartbeat. Raises no resourceVersion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub last_seen: Option<Timestamp>,
    /// Version of its agent.
    #[serde(default)]
    pub version: String,
    /// Session of its agent.
    #[serde(default)]
    pub session: String,
    /// Managers that run on it.
    #[serde(default)]
    pub managers: u32,
    /// Components that run on it.
    #[serde(default)]
    pub components: u32,
    /// Why it is NotReady, in one CamelCase word: `ForeignLedger`, `StaleController`, `LedgerAhead`, `Silent`, `OnDemand`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The same for people, with how to mend it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
    /// What its ledger holds, when this controller does not agree with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ledger: Option<LedgerFence>,
}

/// What a component is.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ComponentView {
    /// System; empty for one that was created by hand.
    #[serde(default)]
    pub system: String,
    /// Type name.
    #[serde(rename = "type")]
    pub type_name: String,
    /// The system cannot be healthy without it.
    #[serde(default)]
    pub required: bool,
    /// Configuration that is wanted.
    #[serde(default)]
    pub configuration: Configuration,
    /// Of a composite, the components that it stands for; nothing of its own runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub composite: Option<CompositeView>,
}

/// The components that a composite stands for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct CompositeView {
    /// What they share.
    pub kind: CompositeKind,
    /// Instance names, in their order.
    pub members: Vec<String>,
}

/// State of a component.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ComponentStatus {
    /// `Created|Inactive|Active|Error|Unknown`.
    pub state: String,
    /// Node.
    pub node: String,
    /// Manager (`main`).
    pub manager: String,
    /// Process id of its manager.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pid: Option<u32>,
    /// Times it was made again after its process died.
    #[serde(default)]
    pub restarts: u32,
    /// A stand-in takes its place: none of its own code runs.
    #[serde(default)]
    pub stand_in: bool,
    /// Unique id of this creation.
    #[serde(default)]
    pub incarnation: String,
    /// Why it is not Active, when it should be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub waiting_on: Option<String>,
    /// State before it became Unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_known_state: Option<String>,
    /// Why it is in Error, or its last complaint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
    /// It is in no system's spec, or was changed by hand.
    #[serde(default)]
    pub drift: bool,
    /// What was changed by hand in it (`configuration.default.gain: 1 -> 2`).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drift_fields: Vec<String>,
    /// Configuration as it is.
    #[serde(default)]
    pub configuration: Configuration,
    /// Rate in Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// The execution context that it shares with others, and its place there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub execution_context: Option<SharedExecutionContext>,
    /// All components of the one that it shares, in the order in which they run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub runs_with: Vec<String>,
    /// `on_execute` calls. A counter.
    #[serde(default)]
    pub executions: u64,
    /// How its execution context keeps its time; none before the first cycle. Counters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timing: Option<TimingObserved>,
    /// What its execution context has of its node; none where nothing was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub realtime: Option<RealtimeObserved>,
    /// Ports that it really has.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ports: Vec<PortObserved>,
    /// When this incarnation was created.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub created: Option<Timestamp>,
}

/// What a connector is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ConnectorView {
    /// System.
    #[serde(default)]
    pub system: String,
    /// Data or service.
    pub kind: PortKind,
    /// `Instance.port`.
    pub source: String,
    /// `Instance.port`.
    pub target: String,
    /// IDL repository id.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data_type: Option<String>,
    /// Properties.
    #[serde(default)]
    pub properties: BTreeMap<String, String>,
}

/// State of a connector.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ConnectorStatus {
    /// `Connected|Connecting|Disconnected|Unknown`.
    pub state: String,
    /// `direct`, `uds`.
    #[serde(default)]
    pub transport: String,
    /// A counter.
    #[serde(default)]
    pub samples_sent: u64,
    /// A counter.
    #[serde(default)]
    pub samples_received: u64,
    /// A counter.
    #[serde(default)]
    pub bytes: u64,
    /// A counter.
    #[serde(default)]
    pub drops: u64,
    /// Jumps in the sequence that the reader saw. A counter.
    #[serde(default)]
    pub gaps: u64,
    /// Samples written in the last whole second.
    #[serde(default)]
    pub rate: u64,
    /// From the write to the read of samples; none before the first, and between two nodes, which have no common clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latency: Option<Latency>,
    /// Why it is not Connected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub waiting_on: Option<String>,
    /// One of its ends is a port of a stand-in of which the direction or the type is not known: it is not made.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub undetermined: bool,
    /// It is in no system's spec, or was changed by hand.
    #[serde(default)]
    pub drift: bool,
    /// What was changed by hand in it; of one that is missing or was made by hand, just that.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drift_fields: Vec<String>,
}

/// What a manager is.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ManagerView {
    /// System; empty for one that was started by hand.
    #[serde(default)]
    pub system: String,
}

/// State of a manager.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ManagerStatus {
    /// Node.
    pub node: String,
    /// Process id.
    pub pid: u32,
    /// `Ready`, or `Unresponsive`.
    pub state: String,
    /// Instance names.
    #[serde(default)]
    pub components: Vec<String>,
    /// Type names of open modules.
    #[serde(default)]
    pub modules: Vec<String>,
    /// Unique id of this start.
    #[serde(default)]
    pub incarnation: String,
    /// When it started.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub started: Option<Timestamp>,
    /// What goes on in it besides what is planned. Raises no resourceVersion.
    #[serde(flatten)]
    pub activity: Activity,
}

/// What happened.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct EventView {
    /// System, when it belongs to one.
    #[serde(default)]
    pub system: String,
    /// `Normal` or `Warning`.
    #[serde(rename = "type")]
    pub kind: String,
    /// One CamelCase word.
    pub reason: String,
    /// `component/Sine0`.
    pub object: String,
    /// For people.
    pub message: String,
}

/// An event has no state but when it happened.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct EventStatus {
    /// When.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>, format = DateTime)]
    pub time: Option<Timestamp>,
}

/// A list of objects.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct List<T> {
    /// [`crate::API_VERSION`].
    pub api_version: String,
    /// `List`.
    pub kind: String,
    /// Version from which a watch goes on.
    pub metadata: ListMetadata,
    /// The objects, sorted by name (events: by time).
    pub items: Vec<T>,
}

/// Version of a list.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ListMetadata {
    /// The store's revision when the list was made.
    pub resource_version: String,
}
