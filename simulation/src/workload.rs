//! Random systems, and how a user changes them.

mod change;
mod orders;
mod system;

use rts_schemas::system::{ComponentSpec, SystemSpec};

pub use self::change::{Change, change};
pub use self::system::random;

/// Types whose modules every node has. All have the ports `in` and `out`, and the parameters `gain` and `offset`.
pub const TYPES: [&str; 4] = ["Source", "Filter", "Motor", "Misbehaving"];

/// Names of nodes; the first is the controller's own.
pub const NODES: [&str; 3] = ["local", "node1", "node2"];

/// A component of a system.
pub fn component<'a>(spec: &'a SystemSpec, instance: &str) -> Option<&'a ComponentSpec> {
    spec.components.iter().find(|c| c.instance == instance)
}

/// The node on which a component is asked to be.
pub fn node_of(component: &ComponentSpec) -> &str {
    component.placement.node.as_deref().unwrap_or(NODES[0])
}

/// A system without a component, and without all that needs it.
pub fn without(spec: &SystemSpec, instance: &str) -> SystemSpec {
    let mut spec = spec.clone();
    spec.components.retain(|c| c.instance != instance);
    let mut connectors = spec.connectors;
    connectors.retain(|c| c.source.instance != instance && c.target.instance != instance);
    spec.connectors = connectors;
    orders::forget(&mut spec.orders, instance);
    spec
}

#[cfg(test)]
mod tests;
