//! Where a component runs.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

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
