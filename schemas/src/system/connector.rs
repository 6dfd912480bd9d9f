//! Connectors.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::port::{PortKind, PortRef};

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
