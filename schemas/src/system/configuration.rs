//! Configuration sets.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

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
