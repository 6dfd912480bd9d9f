//! The modules of the user's nodes, as far as they are known.

use std::collections::BTreeSet;

use rts_agent_api::messages::ModuleResolution;
use rts_controller::simulator::{Scenario, ScenarioNode};
use rts_schemas::system::{ComponentSpec, Direction, PortKind};

use crate::modules::SimModule;

/// The modules of a node: as its agent finds them, or as the components need them.
pub fn modules(scenario: &Scenario, node: &ScenarioNode) -> Vec<SimModule> {
    let types: &BTreeSet<String> = &node.parts.types;
    let found = |name: &String| {
        let known = node.modules.as_ref();
        known.map(|all| all.iter().find(|resolution| resolution.type_name == *name))
    };
    let modules = types.iter().filter_map(|name| match found(name) {
        Some(resolution) => described(scenario, name, resolution?),
        None => Some(guessed(scenario, name)),
    });
    modules.collect()
}

fn described(scenario: &Scenario, name: &str, found: &ModuleResolution) -> Option<SimModule> {
    let file = found.module.as_ref()?;
    let Some(description) = &file.description else {
        let mut module = guessed(scenario, name);
        module.digest.clone_from(&file.digest);
        return Some(module);
    };
    let mut module = SimModule::new(name);
    for port in description
        .ports
        .iter()
        .filter(|port| port.kind == PortKind::Data)
    {
        module = module.port(&port.name, word(port.direction), &port.data_type);
    }
    module.parameters.clone_from(&description.parameters);
    module.digest.clone_from(&file.digest);
    Some(module)
}

/// A module with all that components of its type use.
fn guessed(scenario: &Scenario, name: &str) -> SimModule {
    let mut module = SimModule::new(name);
    for component in components(scenario).filter(|c| c.type_name == name) {
        for port in component
            .ports
            .iter()
            .filter(|port| port.kind == PortKind::Data)
        {
            if !module.ports.iter().any(|known| known.name == port.name) {
                let data_type = port.data_type.as_deref().unwrap_or_default();
                module = module.port(&port.name, word(port.direction), data_type);
            }
        }
        for (parameter, value) in component.configuration.sets.values().flatten() {
            module = module.parameter(parameter, value);
        }
    }
    module
}

fn components(scenario: &Scenario) -> impl Iterator<Item = &ComponentSpec> {
    let stored = scenario
        .before
        .systems
        .values()
        .map(|record| record.spec.as_ref());
    stored
        .chain([&scenario.request.spec])
        .flat_map(|spec| &spec.components)
}

fn word(direction: Option<Direction>) -> &'static str {
    match direction {
        Some(Direction::Out) => "out",
        _ => "in",
    }
}

/// The module with which everything came up.
pub fn before(scenario: &Scenario, module: &SimModule) -> SimModule {
    let records = scenario.before.systems.values();
    let mut pinned = records.filter_map(|record| record.digests.get(&module.type_name));
    let mut before = module.clone();
    if let Some(digest) = pinned.next() {
        before.digest.clone_from(digest);
    }
    before
}
