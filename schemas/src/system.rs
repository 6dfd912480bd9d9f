//! The one model that every reader lowers to and every later step works from.
//!
//! Words are those of OMG RTC 1.0 and OpenRTM-aist. Nothing here knows a file format or a running process.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Lowest rate of an execution context, in Hz.
pub const MIN_RATE: f64 = 0.001;

/// Highest rate of an execution context, in Hz; real profiles ask for it to mean "as fast as it can".
pub const MAX_RATE: f64 = 1_000_000.0;

/// Why a number cannot be a rate in Hz; `None` when it can.
pub fn rate_problem(rate: f64) -> Option<String> {
    // A comparison with NaN is false.
    let fits = (MIN_RATE..=MAX_RATE).contains(&rate);
    (!fits).then(|| format!("a rate is a number of hertz from {MIN_RATE} to {MAX_RATE}"))
}

/// A whole system as its author described it: components, connectors and orders.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SystemSpec {
    /// System name: a DNS label (at most 63 of `a-z0-9-`).
    pub name: String,
    /// The id as the profile writes it (`RTSystem:vendor:name:version`), kept for display and clash detection.
    #[serde(default)]
    pub full_id: String,
    /// Components, in the order of the file. Instance names are unique.
    pub components: Vec<ComponentSpec>,
    /// Composite components, which stand for components of the system. Nothing of their own runs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub composites: Vec<CompositeSpec>,
    /// Connectors, in the order of the file. Names are unique.
    #[serde(default)]
    pub connectors: Vec<ConnectorSpec>,
    /// Orders that the profile writes down; these are hard.
    #[serde(default)]
    pub orders: Orders,
}

/// One RT-Component of a system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ComponentSpec {
    /// Instance name, unique in the system and on its node (`ConsoleIn0`).
    pub instance: String,
    /// Type name, by which the module is found (`ConsoleIn`).
    #[serde(rename = "type")]
    pub type_name: String,
    /// Component id as written (`RTC:vendor:category:type:version`).
    #[serde(default)]
    pub full_id: String,
    /// A required component that is missing makes the system unhealthy; another is only a warning.
    #[serde(default = "yes")]
    pub required: bool,
    /// Ports that the profile declares. A module may have more.
    #[serde(default)]
    pub ports: Vec<PortSpec>,
    /// Configuration sets and the active one.
    #[serde(default)]
    pub configuration: Configuration,
    /// The execution context the component runs in.
    #[serde(default)]
    pub execution_context: ExecutionContextSpec,
    /// Where it runs: node and manager process.
    #[serde(default)]
    pub placement: Placement,
    /// What happens when it fails or loses a peer.
    #[serde(default)]
    pub policy: Policy,
    /// The package that brings its module.
    #[serde(default, skip_serializing_if = "Package::is_default")]
    pub package: Package,
    /// Whether a stand-in takes its place (`rtsctl.standIn`), and how that behaves.
    #[serde(default, skip_serializing_if = "StandInSpec::is_default")]
    pub stand_in: StandInSpec,
    /// What it may use of its node.
    #[serde(default, skip_serializing_if = "Resources::is_default")]
    pub resources: Resources,
}

impl Default for ComponentSpec {
    /// A required component without a name.
    fn default() -> Self {
        Self {
            instance: String::new(),
            type_name: String::new(),
            full_id: String::new(),
            required: true,
            ports: Vec::new(),
            configuration: Configuration::default(),
            execution_context: ExecutionContextSpec::default(),
            placement: Placement::default(),
            policy: Policy::default(),
            package: Package::default(),
            stand_in: StandInSpec::default(),
            resources: Resources::default(),
        }
    }
}

/// A composite component: other components of the system under one name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct CompositeSpec {
    /// Instance name: no component has it.
    pub instance: String,
    /// Type name as the profile has it.
    #[serde(rename = "type", default)]
    pub type_name: String,
    /// Component id as written.
    #[serde(default)]
    pub full_id: String,
    /// As the profile says it; what counts is what its members are.
    #[serde(default = "yes")]
    pub required: bool,
    /// What its members share.
    pub kind: CompositeKind,
    /// Components and other composites, in the order in which they run.
    #[serde(default)]
    pub members: Vec<String>,
    /// Ports of its members by which it may be connected, as `Instance.port`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exported_ports: Vec<String>,
    /// Kind and rate of the execution context of its members, when they share one.
    #[serde(default)]
    pub execution_context: ExecutionContextSpec,
}

impl Default for CompositeSpec {
    /// A group without name and members.
    fn default() -> Self {
        Self {
            instance: String::new(),
            type_name: String::new(),
            full_id: String::new(),
            required: true,
            kind: CompositeKind::Grouping,
            members: Vec::new(),
            exported_ports: Vec::new(),
            execution_context: ExecutionContextSpec::default(),
        }
    }
}

/// What the members of a composite component share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub enum CompositeKind {
    /// One execution context.
    PeriodicECShared,
    /// One execution context and one state.
    PeriodicStateShared,
    /// Nothing but the name.
    Grouping,
}

impl CompositeKind {
    /// By its name in RTS Profile 0.2, or in 0.1.
    pub fn of(text: &str) -> Option<Self> {
        match text {
            "PeriodicECShared" | "ECShared" => Some(Self::PeriodicECShared),
            "PeriodicStateShared" | "AllShared" => Some(Self::PeriodicStateShared),
            "Grouping" | "NonShared" => Some(Self::Grouping),
            _ => None,
        }
    }

    /// Its name in RTS Profile 0.2.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::PeriodicECShared => "PeriodicECShared",
            Self::PeriodicStateShared => "PeriodicStateShared",
            Self::Grouping => "Grouping",
        }
    }

    /// Whether its members run on one execution context.
    pub fn shares_context(self) -> bool {
        self != Self::Grouping
    }

    /// Whether its members share their state.
    pub fn shares_state(self) -> bool {
        self == Self::PeriodicStateShared
    }
}

/// A declared port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct PortSpec {
    /// Bare name, without the instance prefix (`out`).
    pub name: String,
    /// Data or service.
    pub kind: PortKind,
    /// Direction of a data port, when the profile says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<Direction>,
    /// Data type as an IDL repository id (`IDL:RTC/TimedLong:1.0`), when the profile says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data_type: Option<String>,
}

/// Kind of a port or connector.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
#[serde(rename_all = "camelCase")]
pub enum PortKind {
    /// Samples flow one way.
    Data,
    /// Calls of an IDL interface.
    Service,
}

/// Direction of a data port, seen from its component.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
)]
#[serde(rename_all = "camelCase")]
pub enum Direction {
    /// DataInPort.
    In,
    /// DataOutPort.
    Out,
}

/// Configuration sets of a component: name → (parameter → value as text).
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Configuration {
    /// Name of the active set; `None` leaves the component's own choice (`default`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub active: Option<String>,
    /// The sets. RTC pseudo sets (`__widget__`, `__type__`, …) are metadata and not here.
    #[serde(default)]
    pub sets: BTreeMap<String, BTreeMap<String, String>>,
}

/// An execution context (OMG RTC 1.0, 5.2.2.5).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ExecutionContextSpec {
    /// Id as the profile writes it (`0`).
    #[serde(default = "zero")]
    pub id: String,
    /// What drives it.
    #[serde(default)]
    pub kind: ExecutionKind,
    /// Rate in Hz, from [`MIN_RATE`] to [`MAX_RATE`]; `None` leaves the module's default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Name of the one that it shares with other components of its manager (`rtsctl.executionContext.name`); none for one of
    /// its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Place among the components of a shared one: lower numbers run first, those with the same by name
    /// (`rtsctl.executionContext.order`).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub order: i32,
    /// The composite whose members share their state with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shared_state: Option<String>,
}

impl Default for ExecutionContextSpec {
    fn default() -> Self {
        Self {
            id: zero(),
            kind: ExecutionKind::default(),
            rate: None,
            name: None,
            order: 0,
            shared_state: None,
        }
    }
}

impl ExecutionContextSpec {
    /// The one that it shares with others, as a plan tells it; none for one of its own.
    pub fn shared(&self) -> Option<SharedExecutionContext> {
        let name = self.name.clone()?;
        Some(SharedExecutionContext {
            name,
            order: self.order,
            shared_state: self.shared_state.clone(),
        })
    }
}

/// An execution context that components of one manager share, at one of them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SharedExecutionContext {
    /// Its name.
    pub name: String,
    /// Place among its components: lower numbers run first, those with the same by name.
    #[serde(default)]
    pub order: i32,
    /// The composite whose members share their state with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shared_state: Option<String>,
}

/// `ExecutionKind` of OMG RTC 1.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub enum ExecutionKind {
    /// `on_execute` at a fixed rate.
    #[default]
    Periodic,
    /// `on_execute` when an event arrives.
    EventDriven,
    /// Anything else, such as a simulator that ticks it.
    Other,
}

impl ExecutionKind {
    /// As the control protocol writes it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Periodic => "periodic",
            Self::EventDriven => "eventDriven",
            Self::Other => "other",
        }
    }
}

/// Where a component runs. Everything is optional: see "Placement" in the architecture.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Placement {
    /// Node that was named outright (`rtsctl.node`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<String>,
    /// Host that the profile hints at (pathUri, else IOR); never dialled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub host: Option<String>,
    /// Manager name (`rtsctl.manager`, else a name made from the IOR's host:port).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub manager: Option<String>,
    /// A process of its own (`rtsctl.isolated`).
    #[serde(default)]
    pub isolated: bool,
}

/// Failure policies of a component.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Policy {
    /// When its process died (`rtsctl.restart`).
    #[serde(default)]
    pub restart: RestartPolicy,
    /// When a peer is lost (`rtsctl.onDisconnect`).
    #[serde(default)]
    pub on_disconnect: OnDisconnect,
    /// Reset it when it is in Error (`rtsctl.resetOnError`).
    #[serde(default)]
    pub reset_on_error: bool,
    /// Most restarts of it within [`Policy::restart_window_ms`] (`rtsctl.restartLimit`); none for no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restart_limit: Option<u32>,
    /// Milliseconds in which restarts are counted (`rtsctl.restartWindow`); none for [`RESTART_WINDOW_MS`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restart_window_ms: Option<u64>,
    /// Milliseconds that `on_initialize` and `on_activated` may take (`rtsctl.startTimeout`); none for
    /// [`START_TIMEOUT_MS`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_timeout_ms: Option<u64>,
    /// Milliseconds after which a callback that has not returned hangs (`rtsctl.livenessTimeout`); none for
    /// [`LIVENESS_TIMEOUT_MS`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub liveness_timeout_ms: Option<u64>,
    /// When it hangs (`rtsctl.onHang`).
    #[serde(default, skip_serializing_if = "OnHang::is_default")]
    pub on_hang: OnHang,
    /// When a person changed it, or a connector of its out-ports, by hand (`rtsctl.drift`).
    #[serde(default, skip_serializing_if = "DriftPolicy::is_default")]
    pub drift: DriftPolicy,
}

/// A package of modules.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Package {
    /// Its name (`rtsctl.package`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The versions that will do (`rtsctl.version`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
}

impl Package {
    /// Left out when written, so that a program from before this field was known can read the rest.
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// A stand-in for a component: whether there is one, and how it behaves.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct StandInSpec {
    /// When it takes the component's place; never when nothing is said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub when: Option<StandIn>,
    /// Milliseconds that its initialising takes (`rtsctl.standIn.startupTime`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub startup_time_ms: Option<u64>,
    /// What it fails in (`rtsctl.standIn.fail`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fail: Option<StandInFault>,
    /// Milliseconds after its activation at which it brings its process down (`rtsctl.standIn.crashAfter`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crash_after_ms: Option<u64>,
    /// Port → values that it plays, each the texts of its elements: one, but of a sequence any number (`rtsctl.standIn.data`).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub data: BTreeMap<String, Vec<Vec<String>>>,
    /// What the RTC Profile of the component's type says of it, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<RtcFacts>,
}

/// What an RTC Profile says of the components of its type.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct RtcFacts {
    /// Their ports.
    #[serde(default)]
    pub ports: Vec<PortSpec>,
    /// Their parameters with their defaults.
    #[serde(default)]
    pub parameters: BTreeMap<String, String>,
    /// Rate of their execution context in Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
}

impl StandInSpec {
    /// Left out when written, so that a program from before this field was known can read the rest.
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// When it takes the component's place.
    pub fn policy(&self) -> StandIn {
        self.when.unwrap_or(StandIn::Never)
    }
}

/// When a stand-in, which has the ports of a component but not its code, takes its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StandIn {
    /// The component itself runs.
    Never,
    /// Only when its module is not to be had.
    Missing,
    /// In any case.
    Always,
}

impl StandIn {
    /// As profiles and overlays write it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Never => "never",
            Self::Missing => "missing",
            Self::Always => "always",
        }
    }
}

/// The callback in which a stand-in fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StandInFault {
    /// `on_initialize`: there will be no such component.
    Initialize,
    /// `on_activated`.
    Activate,
    /// `on_execute`, from the first one on.
    Execute,
}

impl StandInFault {
    /// As profiles and overlays write it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Initialize => "initialize",
            Self::Activate => "activate",
            Self::Execute => "execute",
        }
    }
}

/// What a component may use of its node.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Resources {
    /// Processors that its execution context runs on, as cpuset(7) lists them: `2-3,5` (`rtsctl.resources.cpus`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpus: Option<String>,
    /// SCHED_FIFO priority of its execution context, 1 to 99 (`rtsctl.resources.realtimePriority`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub realtime_priority: Option<u8>,
    /// Whether the memory of its process is locked (`rtsctl.resources.lockMemory`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lock_memory: Option<bool>,
    /// Whether it is refused where its node does not permit these; true when nothing is said
    /// (`rtsctl.resources.required`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub required: Option<bool>,
    /// Bytes that its process may have (`rtsctl.resources.memoryLimit`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory_limit_bytes: Option<u64>,
}

impl Resources {
    /// Left out when written, so that a program from before this field was known can read the rest.
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// What of it its execution context is to have; none when nothing is asked for.
    pub fn realtime(&self) -> Option<Realtime> {
        let asked = Realtime {
            cpus: self.cpus.clone(),
            priority: self.realtime_priority,
            lock_memory: self.lock_memory.unwrap_or_default(),
            required: self.required.unwrap_or(true),
        };
        let any = asked.cpus.is_some() || asked.priority.is_some() || asked.lock_memory;
        any.then_some(asked)
    }
}

/// What an execution context is to have of its node so that it keeps its time.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Realtime {
    /// Processors that it runs on, as cpuset(7) lists them; none for all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpus: Option<String>,
    /// SCHED_FIFO priority, 1 to 99; none for the usual scheduling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub priority: Option<u8>,
    /// The memory of its process is locked.
    #[serde(default)]
    pub lock_memory: bool,
    /// Its component is not made where its node does not permit all of it.
    #[serde(default)]
    pub required: bool,
}

/// What happens when what runs was changed by hand since the system was applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DriftPolicy {
    /// It is put back.
    #[default]
    Repair,
    /// It is told and left.
    Ignore,
    /// It becomes part of the stored system.
    Adopt,
}

impl DriftPolicy {
    /// Left out when written, so that a text from before this field was known keeps its digest.
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// As profiles and overlays write it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Repair => "repair",
            Self::Ignore => "ignore",
            Self::Adopt => "adopt",
        }
    }
}

/// Default of [`Policy::restart_window_ms`].
pub const RESTART_WINDOW_MS: u64 = 600_000;

/// Default of [`Policy::start_timeout_ms`].
pub const START_TIMEOUT_MS: u64 = 10_000;

/// Default of [`Policy::liveness_timeout_ms`].
pub const LIVENESS_TIMEOUT_MS: u64 = 5_000;

/// What happens when a component hangs in a callback, or its manager does not answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OnHang {
    /// It is told, and the system is not healthy.
    #[default]
    Report,
    /// Its manager process is replaced, with all that is in it.
    Restart,
}

impl OnHang {
    /// Left out when written, so that a text from before this field was known keeps its digest.
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// As profiles and overlays write it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Report => "report",
            Self::Restart => "restart",
        }
    }
}

/// Restart policy, as Kubernetes names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RestartPolicy {
    /// Whatever the exit status.
    #[default]
    Always,
    /// Only after a failure.
    OnFailure,
    /// Never.
    Never,
}

impl RestartPolicy {
    /// As profiles and overlays write it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Always => "always",
            Self::OnFailure => "on-failure",
            Self::Never => "never",
        }
    }
}

/// What a component does when a connector's other end is lost. Its manager does it at once, with or without agent and
/// controller; the plan brings the component back in order once all its peers are there again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OnDisconnect {
    /// Goes on.
    #[default]
    Keep,
    /// Is deactivated; activated again only when all its connectors are connected.
    Deactivate,
    /// Is deactivated, finalised and deleted; created again only when all its peers can be.
    Stop,
}

impl OnDisconnect {
    /// The word in profiles and messages.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Keep => "keep",
            Self::Deactivate => "deactivate",
            Self::Stop => "stop",
        }
    }
}

/// A connector between two ports.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ConnectorSpec {
    /// Unique name in the system, made of the ends: `Sine0.out-Filter0.in`.
    pub name: String,
    /// Data or service.
    pub kind: PortKind,
    /// The out-port end (data) or the first end as written (service).
    pub source: PortRef,
    /// The in-port end (data) or the second end as written (service).
    pub target: PortRef,
    /// Data type as an IDL repository id, when the profile says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data_type: Option<String>,
    /// Connector properties by their OpenRTM names (`dataport.subscription_type`, …), without transient ones.
    #[serde(default)]
    pub properties: BTreeMap<String, String>,
}

/// One end of a connector.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct PortRef {
    /// Instance name of the component.
    pub instance: String,
    /// Bare port name.
    pub port: String,
}

impl std::fmt::Display for PortRef {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.instance, self.port)
    }
}

/// The seven orders of an RTS Profile; each is a list of conditions, empty when the profile is silent.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Orders {
    /// `rts:StartUp`.
    #[serde(default)]
    pub start_up: Vec<Condition>,
    /// `rts:ShutDown`.
    #[serde(default)]
    pub shut_down: Vec<Condition>,
    /// `rts:Activation`.
    #[serde(default)]
    pub activation: Vec<Condition>,
    /// `rts:Deactivation`.
    #[serde(default)]
    pub deactivation: Vec<Condition>,
    /// `rts:Resetting`.
    #[serde(default)]
    pub resetting: Vec<Condition>,
    /// `rts:Initializing`.
    #[serde(default)]
    pub initializing: Vec<Condition>,
    /// `rts:Finalizing`.
    #[serde(default)]
    pub finalizing: Vec<Condition>,
}

impl Orders {
    /// All of them with their names in JSON.
    pub fn by_name(&self) -> [(&'static str, &[Condition]); 7] {
        let Orders {
            start_up,
            shut_down,
            activation,
            deactivation,
            resetting,
            initializing,
            finalizing,
        } = self;
        [
            ("startUp", start_up),
            ("shutDown", shut_down),
            ("activation", activation),
            ("deactivation", deactivation),
            ("resetting", resetting),
            ("initializing", initializing),
            ("finalizing", finalizing),
        ]
    }
}

/// `sequence` of a condition that has no place in the sequence: it neither waits for lower numbers nor do higher ones wait
/// for it. A number that tools with 32 bits still read, as the last of all.
pub const NO_SEQUENCE: u32 = i32::MAX as u32;

/// One `rts:targets` entry. Several conditions of one component are ANDed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Condition {
    /// Instance name of the component that waits.
    pub target: String,
    /// `sequence`: lower numbers go first; gaps are allowed. [`NO_SEQUENCE`] for none.
    pub sequence: u32,
    /// What it waits for besides its place in the sequence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wait: Option<WaitFor>,
}

/// The choice inside `rts:targets`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(
    tag = "kind",
    rename_all = "camelCase",
    rename_all_fields = "camelCase",
    deny_unknown_fields
)]
pub enum WaitFor {
    /// Sleep, then act (`rts:WaitTime`).
    Time {
        /// Milliseconds.
        milliseconds: u32,
    },
    /// Wait for other components (`rts:Preceding`).
    Preceding {
        /// SYNC waits for the state, the others for the request.
        timing: SendingTiming,
        /// Milliseconds; 0 means "no time-out of its own".
        // Said here too: the schema of the API does not know `rename_all_fields`.
        #[serde(rename = "timeoutMs")]
        timeout_ms: u32,
        /// Instance names.
        components: Vec<String>,
    },
}

/// `rts:sendingTiming`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub enum SendingTiming {
    /// After the others have reached the state.
    Sync,
    /// After the others' request was sent (`ASYNC`, `NO_SYNC`).
    Async,
}

fn yes() -> bool {
    true
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes a reference"
)]
fn is_zero(number: &i32) -> bool {
    *number == 0
}

fn zero() -> String {
    "0".to_owned()
}
