//! What faults may speak of.

use rts_controller::simulator::Scenario;

use crate::words::Names;

/// The names of a scenario.
pub fn names(scenario: &Scenario) -> Names {
    let mut names = Names::default();
    for node in &scenario.nodes {
        names.nodes.insert(node.name.clone());
        names.instances.extend(node.parts.instances.iter().cloned());
        for manager in &node.parts.managers {
            let nodes = names.managers.entry(manager.clone()).or_default();
            nodes.insert(node.name.clone());
        }
        for type_name in &node.parts.types {
            let nodes = names.types.entry(type_name.clone()).or_default();
            nodes.insert(node.name.clone());
        }
    }
    names
}
