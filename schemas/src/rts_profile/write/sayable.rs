//! The system as a profile can say it.

use std::collections::{HashMap, HashSet};

use crate::system::{
    ComponentSpec, ConnectorSpec, Direction, PortKind, PortRef, PortSpec, SystemSpec,
};

/// The same system, in what a profile can say. A system that came from a profile is not changed.
///
/// A profile lists data ports and data connectors before those of services, and only connects ports that it declares.
/// A connector that does not say its data type has that of its ports, and a process of its own needs no manager's name.
pub fn sayable(spec: &SystemSpec) -> SystemSpec {
    let mut spec = spec.clone();
    declare_ends(&mut spec);
    for component in &mut spec.components {
        component.ports.sort_by_key(|port| port.kind);
        if component.placement.isolated {
            component.placement.manager = None;
        }
    }
    spec.connectors.sort_by_key(|connector| connector.kind);
    let types = data_types(&spec.components);
    for connector in &mut spec.connectors {
        connector.data_type = data_type(connector, &types);
    }
    spec
}

/// Declares the ports that connectors end at, where their components do not.
fn declare_ends(spec: &mut SystemSpec) {
    let mut declared: HashSet<PortRef> = HashSet::new();
    for component in &spec.components {
        declared.extend(component.ports.iter().map(|port| end(component, port)));
    }
    let index: HashMap<String, usize> = spec
        .components
        .iter()
        .enumerate()
        .map(|(index, component)| (component.instance.clone(), index))
        .collect();
    for connector in &spec.connectors {
        let ends = [
            (&connector.source, Direction::Out),
            (&connector.target, Direction::In),
        ];
        for (end, direction) in ends {
            let component = index.get(&end.instance);
            let component = component.and_then(|index| spec.components.get_mut(*index));
            if let Some(component) = component
                && declared.insert(end.clone())
            {
                let is_data = connector.kind == PortKind::Data;
                component.ports.push(PortSpec {
                    name: end.port.clone(),
                    kind: connector.kind,
                    direction: is_data.then_some(direction),
                    data_type: connector.data_type.clone().filter(|_| is_data),
                });
            }
        }
    }
}

fn end(component: &ComponentSpec, port: &PortSpec) -> PortRef {
    PortRef {
        instance: component.instance.clone(),
        port: port.name.clone(),
    }
}

/// The types of the ports that say one.
fn data_types(components: &[ComponentSpec]) -> HashMap<PortRef, String> {
    let ports = components.iter().flat_map(|component| {
        let ports = component.ports.iter();
        ports.filter_map(|port| Some((end(component, port), port.data_type.clone()?)))
    });
    ports.collect()
}

fn data_type(connector: &ConnectorSpec, types: &HashMap<PortRef, String>) -> Option<String> {
    if connector.kind == PortKind::Service {
        return None;
    }
    let of = |end: &PortRef| types.get(end).cloned();
    let own = connector.data_type.clone();
    own.or_else(|| of(&connector.source))
        .or_else(|| of(&connector.target))
}
