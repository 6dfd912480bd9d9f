//! Changes by hand of what runs.

use std::collections::BTreeMap;

use rts_schemas::system::{DriftPolicy, PortRef};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A change by hand of what runs, as rtconf, rtact, rtdeact, rtreset, rtcon and rtdis make it. Of components with and
/// without a system.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ActRequest {
    /// What to do.
    pub act: Act,
    /// Only check whether it can be done.
    #[serde(default)]
    pub dry_run: bool,
}

/// Most cycles of one act.
pub const MAX_TICKS: u32 = 1_000_000;

/// What a person does to what runs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(
    tag = "act",
    rename_all = "camelCase",
    rename_all_fields = "camelCase",
    deny_unknown_fields
)]
pub enum Act {
    /// Inactive → Active.
    Activate {
        /// Instance name.
        instance: String,
    },
    /// Active → Inactive.
    Deactivate {
        /// Instance name.
        instance: String,
    },
    /// Error → Inactive.
    Reset {
        /// Instance name.
        instance: String,
    },
    /// Runs cycles of an Active component that is driven from outside.
    Tick {
        /// Instance name.
        instance: String,
        /// How many, from 1 to [`MAX_TICKS`].
        cycles: u32,
    },
    /// Sets configuration values, the active set, or both.
    Configure {
        /// Instance name.
        instance: String,
        /// Set that the values belong to; none for the active one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        set: Option<String>,
        /// Parameter → value.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        values: BTreeMap<String, String>,
        /// Set to make the active one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        active: Option<String>,
    },
    /// Connects an out-port with an in-port.
    Connect {
        /// Out-port.
        source: PortRef,
        /// In-port.
        target: PortRef,
        /// Connector name; none for `Source.port-Target.port`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        name: Option<String>,
        /// Connector properties by their OpenRTM names.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        properties: BTreeMap<String, String>,
    },
    /// Removes a connector.
    Disconnect {
        /// Instance that has its out-port.
        instance: String,
        /// Connector name.
        connector: String,
    },
}

impl Act {
    /// The instance whose node does it: the source's for connectors.
    pub fn instance(&self) -> &str {
        match self {
            Self::Activate { instance }
            | Self::Deactivate { instance }
            | Self::Reset { instance }
            | Self::Tick { instance, .. }
            | Self::Configure { instance, .. }
            | Self::Disconnect { instance, .. } => instance,
            Self::Connect { source, .. } => &source.instance,
        }
    }
}

/// An act was done.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Acted {
    /// Node.
    pub node: String,
    /// `component/Filter0`, `connector/Sine0.out-Filter0.in`.
    pub target: String,
    /// False when it was so already, or for a dry run.
    pub changed: bool,
    /// System that the target belongs to; none for what was made by hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub system: Option<String>,
    /// What becomes of the change (`rtsctl.drift`); none without a system, or where nothing differs from it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub policy: Option<DriftPolicy>,
    /// Remarks for the person.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
}
