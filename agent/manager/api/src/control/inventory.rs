//! What is in a manager: modules, components, and both kinds of ends of their connectors.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::{RealtimeInfo, SystemId};

/// What a module says of itself.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ModuleInfo {
    /// Type name.
    pub type_name: String,
    /// Vendor.
    pub vendor: String,
    /// Category.
    pub category: String,
    /// Version.
    pub version: String,
    /// One line.
    pub description: String,
    /// Path that was opened.
    pub path: String,
    /// Ports that its components have.
    pub ports: Vec<PortInfo>,
    /// Parameters with their defaults.
    pub parameters: BTreeMap<String, String>,
    /// What more it says of parameters.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub facts: BTreeMap<String, ParameterFacts>,
    /// `periodic`, `eventDriven` or `other` when nothing else is said; empty from a manager that does not tell.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub execution_kind: String,
    /// `PERIODIC`, `SPORADIC` or `EVENT_DRIVEN`; empty from a manager that does not tell.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub activity_type: String,
    /// IDL source of the types that are its own.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub idl: String,
    /// Most instances in one process; none for any number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_instances: Option<u32>,
}

/// What a module says of a parameter, beside its default. What is empty is not said.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ParameterFacts {
    /// Type as an RTC Profile names it (`double`, `std::vector<int>`).
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub value_type: String,
    /// Unit.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// Constraint as an RTC Profile has it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub constraint: String,
    /// One line.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
}

/// A port of a component.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct PortInfo {
    /// Bare name.
    pub name: String,
    /// `in` or `out`; of a port of a stand-in that nothing can be connected to also `service` and `undetermined`.
    pub direction: String,
    /// IDL repository id; empty where it is not known.
    pub data_type: String,
}

/// Everything in a manager.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ManagerInventory {
    /// Type names of open modules.
    pub modules: BTreeSet<String>,
    /// Type name → digest of the file that was opened for it, as given. Also of modules that were forgotten since: their
    /// code stays mapped, and another file cannot take its place.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub opened: BTreeMap<String, String>,
    /// Components.
    pub components: Vec<ComponentInfo>,
    /// Who looks at ports or writes to them, outside of connectors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub taps: Vec<TapInfo>,
}

/// A connection that looks at a port, or writes to one.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TapInfo {
    /// The port as `Instance.port`.
    pub port: String,
    /// `print` or `inject`.
    pub way: String,
}

/// A component in a manager.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ComponentInfo {
    /// Instance name.
    pub instance: String,
    /// Type name.
    pub type_name: String,
    /// System that it was created for.
    pub system: Option<SystemId>,
    /// Unique id of this creation.
    pub incarnation: String,
    /// As given at creation.
    pub recreate_hash: String,
    /// It is a stand-in.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stand_in: bool,
    /// As given at creation.
    pub restarts: u32,
    /// Wall-clock creation, RFC 3339.
    pub created: String,
    /// `Created`, `Inactive`, `Active`, `Error`.
    pub state: String,
    /// Why it is in Error, or its last complaint.
    pub message: Option<String>,
    /// Configuration sets as they are.
    pub sets: BTreeMap<String, BTreeMap<String, String>>,
    /// Active set.
    pub active: String,
    /// Parameters with the module's defaults.
    #[serde(default)]
    pub defaults: BTreeMap<String, String>,
    /// The callback that runs now, when it has run for a second or longer.
    #[serde(default)]
    pub busy: Option<Busy>,
    /// `keep`, `deactivate` or `stop` when a peer is lost; none from a manager of version 1, which keeps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on_disconnect: Option<String>,
    /// `periodic`, `eventDriven` or `other`.
    pub execution_kind: String,
    /// The execution context that it shares; none for its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub execution_context: Option<ExecutionContextInfo>,
    /// Rate in Hz.
    pub rate: f64,
    /// `on_execute` calls.
    pub executions: u64,
    /// How its execution context keeps its time; none before the first cycle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timing: Option<TimingInfo>,
    /// What its execution context has of the machine; none where nothing was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub realtime: Option<RealtimeInfo>,
    /// Ports.
    pub ports: Vec<PortInfo>,
    /// Connectors of its out-ports.
    pub connectors: Vec<ConnectorInfo>,
    /// Bindings of its in-ports.
    pub bindings: Vec<BindingInfo>,
    /// What a person changed since the plan last did; none from a manager that does not keep it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_hand: Option<ByHandInfo>,
}

/// An execution context that components share, at one of them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ExecutionContextInfo {
    /// Its name.
    pub name: String,
    /// Place of this component.
    pub order: i32,
    /// Name of the composite whose members share their state with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shared_state: Option<String>,
    /// All of them, in the order in which they run.
    pub members: Vec<String>,
}

/// What a person changed in a component: marks, opaque here, as the requests brought them.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ByHandInfo {
    /// Of the last `Configure` by hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configured: Option<String>,
    /// Of the `Deactivate` by hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deactivated: Option<String>,
    /// Of each `Disconnect` by hand, by connector name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub disconnected: BTreeMap<String, String>,
}

/// How an execution context keeps its time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct TimingInfo {
    /// Cycles of a periodic one that were not over when the next was due.
    pub overruns: u64,
    /// Cycles in the last whole second; none before there was one, or from a manager that does not count them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reached: Option<u64>,
    /// How long cycles took.
    pub execution: DurationInfo,
    /// How late cycles of a periodic one began.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jitter: Option<DurationInfo>,
}

/// Durations in nanoseconds, the shares to a quarter.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct DurationInfo {
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
    /// How many are below each power of two and not below half of it, where there are any.
    pub buckets: Vec<(u64, u64)>,
}

/// A callback that does not return.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Busy {
    /// Its name (`on_execute`).
    pub callback: String,
    /// Since when, in milliseconds.
    pub milliseconds: u64,
}

/// A connector at its out-port end.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ConnectorInfo {
    /// Connector name.
    pub name: String,
    /// Out-port.
    pub port: String,
    /// Instance with the in-port.
    pub target_instance: String,
    /// In-port.
    pub target_port: String,
    /// Incarnation of the target when it was connected.
    pub target_incarnation: String,
    /// As given.
    pub properties: BTreeMap<String, String>,
    /// As given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_hand: Option<String>,
    /// `Connected`, `Connecting`, `Disconnected`.
    pub state: String,
    /// `direct`, `shm`, `uds` or `tcp`; empty before it was connected.
    pub transport: String,
    /// Samples that it took from its writer.
    pub samples_sent: u64,
    /// Payload bytes sent.
    pub bytes: u64,
    /// Samples that found no room at the out-port end, or went for others.
    pub drops: u64,
    /// Those of them that were never taken: their writer was told.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub refused: u64,
    /// Samples that were written to it in the last whole second.
    #[serde(default)]
    pub rate: u64,
}

/// A connector at its in-port end.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BindingInfo {
    /// Connector name.
    pub connector: String,
    /// In-port.
    pub port: String,
    /// Who may connect, as `Instance.port`; none from a manager that does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// A source is connected.
    pub connected: bool,
    /// Samples that the component has read, each with a higher number than the one before.
    pub samples_received: u64,
    /// Samples dropped from the in-port's queue.
    pub drops: u64,
    /// Jumps in the sequence that the reader saw.
    pub gaps: u64,
    /// Of the samples received; none before the first, or from a manager that does not measure it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latency: Option<Latency>,
}

/// Time from the write to the read of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Latency {
    /// Samples measured.
    pub count: u64,
    /// The shortest, in nanoseconds.
    pub min_ns: u64,
    /// Half of them took no longer; up to twice too high.
    pub median_ns: u64,
    /// 99 of 100 took no longer; up to twice too high.
    pub p99_ns: u64,
    /// The longest.
    pub max_ns: u64,
}

fn is_zero(number: &u64) -> bool {
    *number == 0
}
