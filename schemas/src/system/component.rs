//! One RT-Component of a system, and the package that brings it.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::configuration::Configuration;
use super::context::ExecutionContextSpec;
use super::placement::Placement;
use super::policy::Policy;
use super::port::PortSpec;
use super::resources::Resources;
use super::stand_in::StandInSpec;

/// One RT-Component of a system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ComponentSpec {
    /// Instance name, unique in the system and on its node (`ConsoleIn0`).
    pub instance: String,
    /// Type name, by which the module is found (`ConsoleIn`).
    #[serde(rename = "type")]
    pub type_name: String,
    /// Component id as written (`RTC:vendor:category:type:version`).
    #[serde(default)]
    pub full_id: String,
    /// A required component that is missing makes the system unhealthy; another is only a warning.
    #[serde(default = "yes")]
    pub required: bool,
    /// Ports that the profile declares. A module may have more.
    #[serde(default)]
    pub ports: Vec<PortSpec>,
    /// Configuration sets and the active one.
    #[serde(default)]
    pub configuration: Configuration,
    /// The execution context the component runs in.
    #[serde(default)]
    pub execution_context: ExecutionContextSpec,
    /// Where it runs: node and manager process.
    #[serde(default)]
    pub placement: Placement,
    /// What happens when it fails or loses a peer.
    #[serde(default)]
    pub policy: Policy,
    /// The package that brings its module.
    #[serde(default, skip_serializing_if = "Package::is_default")]
    pub package: Package,
    /// Whether a stand-in takes its place (`rtsctl.standIn`), and how that behaves.
    #[serde(default, skip_serializing_if = "StandInSpec::is_default")]
    pub stand_in: StandInSpec,
    /// What it may use of its node.
    #[serde(default, skip_serializing_if = "Resources::is_default")]
    pub resources: Resources,
}

impl Default for ComponentSpec {
    /// A required component without a name.
    fn default() -> Self {
        Self {
            instance: String::new(),
            type_name: String::new(),
            full_id: String::new(),
            required: true,
            ports: Vec::new(),
            configuration: Configuration::default(),
            execution_context: ExecutionContextSpec::default(),
            placement: Placement::default(),
            policy: Policy::default(),
            package: Package::default(),
            stand_in: StandInSpec::default(),
            resources: Resources::default(),
        }
    }
}

/// A package of modules.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Package {
    /// Its name (`rtsctl.package`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The versions that will do (`rtsctl.version`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
}

impl Package {
    /// Left out when written, so that a program from before this field was known can read the rest.
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

pub(super) fn yes() -> bool {
    true
}
