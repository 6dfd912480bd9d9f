//! Desired state: what every node was told to have.

use std::collections::BTreeMap;

use rts_schemas::stand_in::Shape;
use rts_schemas::system::{ComponentSpec, ConnectorSpec, Orders, Realtime};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Everything that should run, by node.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Desired {
    /// One entry per node that has, or had, anything to run. A node with an empty spec runs nothing.
    pub nodes: BTreeMap<String, NodeSpec>,
}

/// The whole of what one node should run, over all systems. Stored durably by its agent.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct NodeSpec {
    /// Node name.
    pub node: String,
    /// The parts of systems that lie on this node, by system name.
    #[serde(default)]
    pub systems: Vec<NodeSystem>,
}

/// The part of one system that lies on one node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct NodeSystem {
    /// Which system.
    pub system: SystemRef,
    /// Generation of the system that this part was cut from; 0 when it is not known. It tells which of two ledgers is
    /// the newer one for this system.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub generation: u64,
    /// Components of this node.
    pub components: Vec<PlacedComponent>,
    /// Connectors with at least one end on this node.
    #[serde(default)]
    pub connectors: Vec<PlacedConnector>,
    /// Orders of the whole system; names of other nodes' components may occur.
    #[serde(default)]
    pub orders: Orders,
    /// What who plans over this part alone cannot see, by instance: other nodes' components that these orders name, and
    /// other nodes where a component of this part may still run, since it was moved from there and that node has not said
    /// that it is gone. One of those is made by nobody but a controller, who can ask.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub elsewhere: BTreeMap<String, Elsewhere>,
}

/// A component that is, or may be, on another node.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Elsewhere {
    /// Its node.
    pub node: String,
    /// False for one that nobody waits for when it cannot be brought up.
    pub required: bool,
}

impl NodeSystem {
    /// SHA-256 over its JSON, hexadecimal: names the very text of this part, whatever the generation of its system and
    /// wherever its own components may still run.
    pub fn digest(&self) -> String {
        if self.generation == 0 && !self.may_run_elsewhere() {
            return crate::place::digest_of(self);
        }
        crate::place::digest_of(&Self {
            generation: 0,
            ..self.settled()
        })
    }

    /// The same once none of its own components may run elsewhere.
    pub fn settled(&self) -> Self {
        let mut settled = self.clone();
        for own in &self.components {
            settled.elsewhere.remove(&own.spec.instance);
        }
        settled
    }

    fn may_run_elsewhere(&self) -> bool {
        let mut own = self.components.iter();
        !self.elsewhere.is_empty() && own.any(|c| self.elsewhere.contains_key(&c.spec.instance))
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde passes a reference"
)]
fn is_zero(number: &u64) -> bool {
    *number == 0
}

/// A system's name and identity. A system that is deleted and applied again gets a new uid.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SystemRef {
    /// DNS label.
    pub name: String,
    /// UUID.
    pub uid: String,
}

/// A component with its place settled: nothing is left for an executor to choose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct PlacedComponent {
    /// What it is.
    pub spec: ComponentSpec,
    /// Name of its manager process in (system, node).
    pub manager: String,
    /// SHA-256 of the module file that was found when the system was applied.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub module_digest: Option<String>,
    /// What the stand-in is made of that takes its place; none where the component itself runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stand_in: Option<Shape>,
    /// Covers what cannot change in place: type, module digest, manager, execution kind, real time, and all of a stand-in.
    pub recreate_hash: String,
}

impl PlacedComponent {
    /// What its execution context is to have of its node. A stand-in runs everywhere, and needs nothing.
    pub fn realtime(&self) -> Option<Realtime> {
        let own = self.stand_in.is_none();
        own.then(|| self.spec.resources.realtime()).flatten()
    }

    /// SHA-256 over what can be changed in it in place: configuration, active set and rate. A deactivation by hand is
    /// marked with it ([`crate::observed::ByHand`]).
    pub fn settings_digest(&self) -> String {
        let spec = &self.spec;
        crate::place::digest_of(&(&spec.configuration, spec.execution_context.rate))
    }
}

impl PlacedConnector {
    /// SHA-256 over its spec. A change by hand is marked with it ([`crate::observed::ByHand`]).
    pub fn digest(&self) -> String {
        crate::place::digest_of(&self.spec)
    }
}

/// A connector with the nodes and managers of its ends settled. The out-port end owns it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct PlacedConnector {
    /// What it is.
    pub spec: ConnectorSpec,
    /// Where the source end is.
    pub source: EndPlace,
    /// Where the target end is.
    pub target: EndPlace,
    /// Why it is only declared: an end of it is a port of a stand-in that is not known well enough to be connected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub undetermined: Option<String>,
}

/// Where one end of a connector lives. A name, never an address: addresses are resolved at each connect.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct EndPlace {
    /// Node name.
    pub node: String,
    /// Manager name in (system, node).
    pub manager: String,
}

/// Identity of a manager process on a node: (system, name). Systems never share a process. `None` marks a manager that
/// a person started by hand.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ManagerKey {
    /// The system that it belongs to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub system: Option<SystemRef>,
    /// Its name (`main`).
    pub name: String,
}

impl ManagerKey {
    /// The name that people and paths use: `hello.main`, or `NAME` for a manager started by hand.
    pub fn display_name(&self) -> String {
        match &self.system {
            Some(system) => format!("{}.{}", system.name, self.name),
            None => self.name.clone(),
        }
    }
}
