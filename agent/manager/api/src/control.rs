//! Messages of a control connection.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

pub use crate::greeting::Greeting;

/// First frame of a manager on a control connection: also its sign of readiness.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Hello {
    /// Protocol version of this connection: the newest that both sides speak. The manager's own when there is none.
    pub version: u32,
    /// System that it belongs to: (name, uid).
    pub system: Option<SystemId>,
    /// Manager name.
    pub name: String,
    /// Unique id of this start.
    pub incarnation: String,
    /// Process id.
    pub pid: u32,
    /// Wall-clock start, RFC 3339.
    pub started: String,
}

/// Name and uid of a system.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SystemId {
    /// Name.
    pub name: String,
    /// UUID.
    pub uid: String,
}

/// A request. Responses may come in another order than the requests.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Request {
    /// Chosen by the sender; repeated in the response.
    pub id: u64,
    /// The manager answers within this time, with an error if need be.
    pub deadline_ms: u64,
    /// What to do.
    pub body: RequestBody,
}

/// What to do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase", rename_all_fields = "camelCase")]
pub enum RequestBody {
    /// Open a module. Answer: `Module`. Idempotent for the same path.
    LoadModule {
        /// Type name that its descriptor must have.
        type_name: String,
        /// Absolute path of the shared library.
        path: String,
    },
    /// Forget a module (its code stays mapped). Refused while a component uses it. Answer: `Done`.
    UnloadModule {
        /// Type name.
        type_name: String,
    },
    /// Describe the loaded modules. Answer: `Modules`.
    Factories,
    /// Create and initialise a component; it ends Inactive. Answer: `Created`.
    Create(CreateRequest),
    /// Set values, active set and rate in place. Answer: `Done`.
    Configure {
        /// Instance name.
        instance: String,
        /// Set → parameter → value; unnamed ones stay.
        sets: BTreeMap<String, BTreeMap<String, String>>,
        /// New active set.
        active: Option<String>,
        /// New rate in Hz.
        rate: Option<f64>,
        /// `keep`, `deactivate` or `stop` when a peer is lost; none leaves it. Since version 2.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        on_disconnect: Option<String>,
    },
    /// Let the named connector be bound to an in-port: a data connection that says otherwise is refused. Answer: `Bound`.
    Bind(Binding),
    /// Remove a binding and close its connection. Answer: `Done`; also when there is none.
    Unbind {
        /// Connector name.
        connector: String,
    },
    /// Connect an out-port, here or over a socket. Answer: `Done` when the other end has agreed.
    Connect(ConnectRequest),
    /// Remove a connector at its out-port end. Answer: `Done`; also when there is none.
    Disconnect {
        /// Instance that owns it.
        instance: String,
        /// Connector name.
        connector: String,
    },
    /// Activate. Answer: `Done` when it is Active.
    Activate {
        /// Instance name.
        instance: String,
    },
    /// Deactivate. Answer: `Done` when it is Inactive. A component in Error stays there and is no error here.
    Deactivate {
        /// Instance name.
        instance: String,
    },
    /// Error → Inactive. Answer: `Done`.
    Reset {
        /// Instance name.
        instance: String,
    },
    /// Deactivate if need be, finalise, disconnect and delete. Answer: `Done`; also when there is none.
    Delete {
        /// Instance name.
        instance: String,
    },
    /// Everything that there is, counters included. Never waits for a component. Answer: `Inventory`.
    Inventory,
    /// Deactivate and finalise everything within the deadline, answer `Done`, and exit 0.
    Shutdown,
}

impl RequestBody {
    /// Without what a manager that speaks `version` does not know.
    #[must_use]
    pub fn for_version(mut self, version: u32) -> Self {
        if version < 2 {
            match &mut self {
                Self::Configure { on_disconnect, .. }
                | Self::Create(CreateRequest { on_disconnect, .. }) => *on_disconnect = None,
                _ => {}
            }
        }
        self
    }
}

/// Arguments of `Create`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct CreateRequest {
    /// Instance name, unique in the manager.
    pub instance: String,
    /// Type name of a loaded module.
    pub type_name: String,
    /// System that it is created for; none when made by hand.
    pub system: Option<SystemId>,
    /// Kept and reported back.
    pub recreate_hash: String,
    /// Kept and reported back.
    pub restarts: u32,
    /// Set → parameter → value, set before `on_initialize`.
    pub sets: BTreeMap<String, BTreeMap<String, String>>,
    /// Active set.
    pub active: Option<String>,
    /// Only `periodic` is known in this version.
    pub execution_kind: String,
    /// Rate in Hz; none for the module's default.
    pub rate: Option<f64>,
    /// Absolute path of the component's log; opened with O_APPEND.
    pub log_path: String,
    /// `keep` (default), `deactivate` or `stop` when a peer is lost. Since version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on_disconnect: Option<String>,
}

/// An in-port end that waits for its connector.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Binding {
    /// Connector name, unique in the system.
    pub connector: String,
    /// Instance with the in-port.
    pub instance: String,
    /// In-port.
    pub port: String,
    /// Source as `Instance.port`.
    pub source: String,
}

/// Arguments of `Connect`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ConnectRequest {
    /// Connector name.
    pub connector: String,
    /// Instance with the out-port, in this manager.
    pub instance: String,
    /// Out-port.
    pub port: String,
    /// Instance with the in-port.
    pub target_instance: String,
    /// In-port.
    pub target_port: String,
    /// Control socket of the target's manager; none when it is this one.
    pub target_socket: Option<String>,
    /// Incarnation that the target must have.
    pub target_incarnation: String,
    /// Connector properties, reported back.
    pub properties: BTreeMap<String, String>,
}

/// Answer to a request.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Response {
    /// Id of the request.
    pub id: u64,
    /// Outcome.
    pub result: Result<ResponseBody, Failure>,
}

/// What a manager sends after its hello.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "camelCase")]
pub enum FromManager {
    /// Answer to a request.
    Response(Response),
    /// Something changed that is not a counter: ask for the inventory.
    Changed(Changed),
}

/// Something happened by itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Changed {
    /// `component/NAME` or `connector/NAME`.
    pub target: String,
    /// For people (`went to Error: on_execute returned BAD_PARAMETER`).
    pub message: String,
    /// The CamelCase word of an event that people should see; none when the inventory shows all. Since version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// A good answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", content = "value", rename_all = "camelCase")]
pub enum ResponseBody {
    /// Nothing to say.
    Done,
    /// A module was opened.
    Module(ModuleInfo),
    /// Modules that are open.
    Modules(Vec<ModuleInfo>),
    /// A component was created.
    Created {
        /// Its incarnation.
        incarnation: String,
    },
    /// A binding was made.
    Bound {
        /// Incarnation of the component that owns the in-port.
        incarnation: String,
    },
    /// Everything.
    Inventory(ManagerInventory),
}

/// What a module says of itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
}

/// A port of a component.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct PortInfo {
    /// Bare name.
    pub name: String,
    /// `in` or `out`.
    pub direction: String,
    /// IDL repository id.
    pub data_type: String,
}

/// Everything in a manager.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ManagerInventory {
    /// Type names of open modules.
    pub modules: BTreeSet<String>,
    /// Components.
    pub components: Vec<ComponentInfo>,
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
    /// `periodic`.
    pub execution_kind: String,
    /// Rate in Hz.
    pub rate: f64,
    /// `on_execute` calls.
    pub executions: u64,
    /// Ports.
    pub ports: Vec<PortInfo>,
    /// Connectors of its out-ports.
    pub connectors: Vec<ConnectorInfo>,
    /// Bindings of its in-ports.
    pub bindings: Vec<BindingInfo>,
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
    /// `Connected`, `Connecting`, `Disconnected`.
    pub state: String,
    /// `direct` or `uds`.
    pub transport: String,
    /// Samples put into its queue.
    pub samples_sent: u64,
    /// Payload bytes sent.
    pub bytes: u64,
    /// Samples dropped from its queue.
    pub drops: u64,
}

/// A connector at its in-port end.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BindingInfo {
    /// Connector name.
    pub connector: String,
    /// In-port.
    pub port: String,
    /// A source is connected.
    pub connected: bool,
    /// Samples that the component has read.
    pub samples_received: u64,
    /// Samples dropped from the in-port's queue.
    pub drops: u64,
    /// Jumps in the sequence that the reader saw.
    pub gaps: u64,
}

/// A refusal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "camelCase")]
#[error("{message}")]
pub struct Failure {
    /// What kind.
    pub code: FailureCode,
    /// For people: what, why, and how to mend it.
    pub message: String,
}

/// Kind of a refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum FailureCode {
    /// No such instance, module, port.
    NotFound,
    /// It is there already and differs, or is in use.
    Conflict,
    /// The request makes no sense (unknown parameter, type mismatch).
    Invalid,
    /// dlopen, the descriptor or the ABI version failed.
    LoadFailed,
    /// A callback returned an error or panicked.
    ComponentFailed,
    /// A callback did not return in time.
    Deadline,
    /// The other end of a connector refused or is gone.
    PeerFailed,
    /// The manager itself failed.
    Internal,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_to_an_older_manager_has_no_newer_fields() {
        let configure = RequestBody::Configure {
            instance: "A".to_owned(),
            sets: BTreeMap::new(),
            active: None,
            rate: None,
            on_disconnect: Some("stop".to_owned()),
        };
        let text =
            |version| serde_json::to_string(&configure.clone().for_version(version)).unwrap();
        assert!(text(2).contains(r#""onDisconnect":"stop""#));
        assert!(!text(1).contains("onDisconnect"));
    }
}
