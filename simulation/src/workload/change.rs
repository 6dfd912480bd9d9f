//! What a user changes in a system between two applies. A change of what is not there is none.

use rts_schemas::system::{ComponentSpec, ConnectorSpec, SystemSpec};
use serde::{Deserialize, Serialize};

use super::system::{component, connector};
use super::{NODES, without};
use crate::seed::Stream;

/// One change of a spec.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", rename_all_fields = "camelCase")]
pub enum Change {
    /// Nothing: the same is applied again.
    None,
    /// A value of the default configuration set.
    Configure {
        /// Component.
        instance: String,
        /// Parameter.
        parameter: String,
        /// Value.
        value: String,
    },
    /// The rate of a component, in Hz.
    Rate {
        /// Component.
        instance: String,
        /// Rate.
        rate: u32,
    },
    /// A new component.
    Add(Box<ComponentSpec>),
    /// A component goes, and what needs it.
    Remove {
        /// Component.
        instance: String,
    },
    /// A new connector.
    Connect {
        /// Component of the out-port.
        source: String,
        /// Component of the in-port.
        target: String,
    },
    /// A connector goes.
    Disconnect {
        /// Component of the out-port.
        source: String,
        /// Component of the in-port.
        target: String,
    },
    /// A property of all connectors of a component's out-port.
    Property {
        /// Component of the out-port.
        source: String,
        /// Value of `dataport.subscription_type`.
        value: String,
    },
    /// Another manager; empty for one of its own.
    Manager {
        /// Component.
        instance: String,
        /// Manager.
        manager: String,
    },
    /// Another node. Its connectors stay.
    Move {
        /// Component.
        instance: String,
        /// Node.
        node: String,
    },
}

impl Change {
    /// Makes it.
    pub fn make(&self, spec: &SystemSpec) -> SystemSpec {
        let mut spec = spec.clone();
        let find = |spec: &mut SystemSpec, name: &str, change: &dyn Fn(&mut ComponentSpec)| {
            spec.components
                .iter_mut()
                .filter(|c| c.instance == name)
                .for_each(change);
        };
        match self {
            Self::None => {}
            Self::Configure {
                instance,
                parameter,
                value,
            } => find(&mut spec, instance, &|c| {
                let set = c
                    .configuration
                    .sets
                    .entry("default".to_owned())
                    .or_default();
                set.insert(parameter.clone(), value.clone());
            }),
            Self::Rate { instance, rate } => find(&mut spec, instance, &|c| {
                c.execution_context.rate = Some(f64::from(*rate));
            }),
            Self::Add(new) => {
                if super::component(&spec, &new.instance).is_none() {
                    spec.components.push((**new).clone());
                }
            }
            // A system without components is refused.
            Self::Remove { instance } if spec.components.len() > 1 => {
                spec = without(&spec, instance);
            }
            Self::Remove { .. } => {}
            Self::Connect { source, target } => connect(&mut spec, source, target),
            Self::Disconnect { source, target } => {
                let name = connector(source, target).name;
                spec.connectors.retain(|c| c.name != name);
            }
            Self::Property { source, value } => {
                let own = |c: &&mut ConnectorSpec| c.source.instance == *source;
                for connector in spec.connectors.iter_mut().filter(own) {
                    let key = "dataport.subscription_type".to_owned();
                    connector.properties.insert(key, value.clone());
                    // Said of every kind: only a periodic one goes by it.
                    let key = "dataport.publisher.push_rate".to_owned();
                    connector.properties.insert(key, "10.0".to_owned());
                }
            }
            Self::Manager { instance, manager } => find(&mut spec, instance, &|c| {
                c.placement.isolated = manager.is_empty();
                c.placement.manager = (!manager.is_empty()).then(|| manager.clone());
            }),
            Self::Move { instance, node } => find(&mut spec, instance, &|c| {
                c.placement.node = Some(node.clone());
            }),
        }
        spec
    }
}

fn connect(spec: &mut SystemSpec, source: &str, target: &str) {
    let new = connector(source, target);
    let there = |name: &str| super::component(spec, name).is_some();
    if source != target
        && there(source)
        && there(target)
        && !spec.connectors.iter().any(|c| c.name == new.name)
    {
        spec.connectors.push(new);
    }
}

/// A random change of a system as it was first applied.
pub fn change(stream: &Stream, spec: &SystemSpec, nodes: usize) -> Change {
    let names: Vec<String> = spec.components.iter().map(|c| c.instance.clone()).collect();
    let pick = || stream.pick(&names).cloned().unwrap_or_default();
    let (instance, target) = (pick(), pick());
    let value = stream.between(0, 99);
    let letter = instance.chars().next().unwrap_or('A');
    let new = component(stream, &format!("{letter}{}", 5 + value % 4), nodes);
    let node = NODES[stream.between(0, (nodes.max(1) - 1) as u64) as usize].to_owned();
    let one_of = |all: &[&str]| {
        stream
            .pick(all)
            .map_or_else(String::new, |s| (*s).to_owned())
    };
    let parameter = one_of(&["gain", "offset"]);
    let subscription = one_of(&["flush", "new", "periodic"]);
    let manager = one_of(&["", "a", "b", "main"]);
    match stream.between(0, 13) {
        0 => Change::None,
        1..=3 => Change::Configure {
            instance,
            parameter,
            value: value.to_string(),
        },
        4 => Change::Rate { instance, rate: 20 },
        5 | 6 => Change::Add(Box::new(new)),
        7 | 8 => Change::Remove { instance },
        9 => Change::Connect {
            source: instance,
            target,
        },
        10 => Change::Disconnect {
            source: instance,
            target,
        },
        11 => Change::Property {
            source: instance,
            value: subscription,
        },
        12 => Change::Manager { instance, manager },
        _ => Change::Move { instance, node },
    }
}
