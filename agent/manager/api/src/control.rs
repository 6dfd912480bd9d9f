//! Messages of a control connection.

mod failure;
mod inventory;
mod realtime;
mod request;
mod stand_in;

use serde::{Deserialize, Serialize};

pub use self::failure::{Failure, FailureCode};
pub use self::inventory::{
    BindingInfo, Busy, ByHandInfo, ComponentInfo, ConnectorInfo, DurationInfo,
    ExecutionContextInfo, Latency, ManagerInventory, ModuleInfo, ParameterFacts, PortInfo, TapInfo,
    TimingInfo,
};
pub use self::realtime::{RealtimeInfo, RealtimeRequest};
pub use self::request::{
    Binding, ConnectRequest, CreateRequest, ExecutionContextRequest, Request, RequestBody,
};
pub use self::stand_in::StandInShape;
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
    Module(Box<ModuleInfo>),
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
