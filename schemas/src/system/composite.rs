//! Composite components: others under one name.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::component::yes;
use super::context::ExecutionContextSpec;

/// A composite component: other components of the system under one name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct CompositeSpec {
    /// Instance name: no component has it.
    pub instance: String,
    /// Type name as the profile has it.
    #[serde(rename = "type", default)]
    pub type_name: String,
    /// Component id as written.
    #[serde(default)]
    pub full_id: String,
    /// As the profile says it; what counts is what its members are.
    #[serde(default = "yes")]
    pub required: bool,
    /// What its members share.
    pub kind: CompositeKind,
    /// Components and other composites, in the order in which they run.
    #[serde(default)]
    pub members: Vec<String>,
    /// Ports of its members by which it may be connected, as `Instance.port`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exported_ports: Vec<String>,
    /// Kind and rate of the execution context of its members, when they share one.
    #[serde(default)]
    pub execution_context: ExecutionContextSpec,
}

impl Default for CompositeSpec {
    /// A group without name and members.
    fn default() -> Self {
        Self {
            instance: String::new(),
            type_name: String::new(),
            full_id: String::new(),
            required: true,
            kind: CompositeKind::Grouping,
            members: Vec::new(),
            exported_ports: Vec::new(),
            execution_context: ExecutionContextSpec::default(),
        }
    }
}

/// What the members of a composite component share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub enum CompositeKind {
    /// One execution context.
    PeriodicECShared,
    /// One execution context and one state.
    PeriodicStateShared,
    /// Nothing but the name.
    Grouping,
}

impl CompositeKind {
    /// By its name in RTS Profile 0.2, or in 0.1.
    pub fn of(text: &str) -> Option<Self> {
        match text {
            "PeriodicECShared" | "ECShared" => Some(Self::PeriodicECShared),
            "PeriodicStateShared" | "AllShared" => Some(Self::PeriodicStateShared),
            "Grouping" | "NonShared" => Some(Self::Grouping),
            _ => None,
        }
    }

    /// Its name in RTS Profile 0.2.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::PeriodicECShared => "PeriodicECShared",
            Self::PeriodicStateShared => "PeriodicStateShared",
            Self::Grouping => "Grouping",
        }
    }

    /// Whether its members run on one execution context.
    pub fn shares_context(self) -> bool {
        self != Self::Grouping
    }

    /// Whether its members share their state.
    pub fn shares_state(self) -> bool {
        self == Self::PeriodicStateShared
    }
}
