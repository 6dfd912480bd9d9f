//! What takes the place of a component whose module is not to be had.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::port::PortSpec;

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
    pub(super) fn is_default(&self) -> bool {
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
