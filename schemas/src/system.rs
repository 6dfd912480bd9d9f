//! The one model that every reader lowers to and every later step works from.
//!
//! Words are those of OMG RTC 1.0 and OpenRTM-aist. Nothing here knows a file format or a running process.

mod component;
mod composite;
mod configuration;
mod connector;
mod context;
mod orders;
mod placement;
mod policy;
mod port;
mod resources;
mod stand_in;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use self::component::{ComponentSpec, Package};
pub use self::composite::{CompositeKind, CompositeSpec};
pub use self::configuration::Configuration;
pub use self::connector::ConnectorSpec;
pub use self::context::{
    ExecutionContextSpec, ExecutionKind, MAX_RATE, MIN_RATE, SharedExecutionContext, rate_problem,
};
pub use self::orders::{Condition, NO_SEQUENCE, Orders, SendingTiming, WaitFor};
pub use self::placement::Placement;
pub use self::policy::{
    DriftPolicy, LIVENESS_TIMEOUT_MS, OnDisconnect, OnHang, Policy, RESTART_WINDOW_MS,
    RestartPolicy, START_TIMEOUT_MS,
};
pub use self::port::{Direction, PortKind, PortRef, PortSpec};
pub use self::resources::{Realtime, Resources};
pub use self::stand_in::{RtcFacts, StandIn, StandInFault, StandInSpec};

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
