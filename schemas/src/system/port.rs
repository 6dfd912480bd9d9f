//! Ports, and how an end of a connector names one.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

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
