//! One random system.

use rts_schemas::system::{
    ComponentSpec, Configuration, ConnectorSpec, ExecutionContextSpec, OnDisconnect, OnHang,
    Orders, Placement, Policy, PortKind, PortRef, RestartPolicy, SystemSpec,
};

use super::{NODES, TYPES, orders};
use crate::seed::Stream;

/// A system of this name on some of the first `nodes` nodes. `letter` begins the names of its components, so that no two
/// systems have one of the same name.
pub fn random(stream: &Stream, name: &str, letter: char, nodes: usize) -> SystemSpec {
    let count = stream.between(1, 5);
    let components: Vec<ComponentSpec> = (0..count)
        .map(|n| component(stream, &format!("{letter}{n}"), nodes))
        .collect();
    let connectors = connectors(stream, &components);
    let mut spec = SystemSpec {
        composites: Vec::new(),
        name: name.to_owned(),
        full_id: format!("RTSystem:sim:{name}:1.0"),
        components,
        connectors,
        orders: Orders::default(),
    };
    spec.orders = orders::random(stream, &spec);
    spec
}

/// A random component of this name.
pub(super) fn component(stream: &Stream, instance: &str, nodes: usize) -> ComponentSpec {
    let type_name = stream.pick(&TYPES).copied().unwrap_or(TYPES[0]);
    let node = NODES[stream.between(0, (nodes.max(1) - 1) as u64) as usize];
    let manager = stream.pick(&["", "", "a", "b"]).copied().unwrap_or("");
    let isolated = stream.chance(0.25);
    ComponentSpec {
        instance: instance.to_owned(),
        type_name: type_name.to_owned(),
        full_id: String::new(),
        required: stream.chance(0.85),
        ports: Vec::new(),
        configuration: configuration(stream),
        execution_context: ExecutionContextSpec {
            rate: stream
                .pick(&[None, Some(10.0), Some(100.0)])
                .copied()
                .flatten(),
            ..ExecutionContextSpec::default()
        },
        placement: Placement {
            node: Some(node.to_owned()),
            host: None,
            manager: (!manager.is_empty() && !isolated).then(|| manager.to_owned()),
            isolated,
        },
        policy: policy(stream),
        ..ComponentSpec::default()
    }
}

fn configuration(stream: &Stream) -> Configuration {
    let mut configuration = Configuration::default();
    for parameter in ["gain", "offset"] {
        let value = stream.between(0, 9);
        if stream.chance(0.4) {
            let set = configuration.sets.entry("default".to_owned()).or_default();
            set.insert(parameter.to_owned(), value.to_string());
        }
    }
    configuration
}

fn policy(stream: &Stream) -> Policy {
    let restarts = [
        RestartPolicy::Always,
        RestartPolicy::Always,
        RestartPolicy::Always,
        RestartPolicy::OnFailure,
        RestartPolicy::Never,
    ];
    let losses = [
        OnDisconnect::Keep,
        OnDisconnect::Keep,
        OnDisconnect::Deactivate,
        OnDisconnect::Stop,
    ];
    let limit = stream.between(1, 4) as u32;
    Policy {
        restart: stream.pick(&restarts).copied().unwrap_or_default(),
        on_disconnect: stream.pick(&losses).copied().unwrap_or_default(),
        reset_on_error: stream.chance(0.6),
        restart_limit: stream.chance(0.15).then_some(limit),
        on_hang: if stream.chance(0.6) {
            OnHang::Restart
        } else {
            OnHang::Report
        },
        ..Policy::default()
    }
}

/// Connectors between components, on one node or on two; cycles are usual.
fn connectors(stream: &Stream, components: &[ComponentSpec]) -> Vec<ConnectorSpec> {
    let mut all = Vec::new();
    for source in components {
        for target in components {
            if stream.chance(0.3) && source.instance != target.instance {
                all.push(connector(&source.instance, &target.instance));
            }
        }
    }
    all
}

/// A connector from one component to another.
pub(super) fn connector(source: &str, target: &str) -> ConnectorSpec {
    let end = |instance: &str, port: &str| PortRef {
        instance: instance.to_owned(),
        port: port.to_owned(),
    };
    ConnectorSpec {
        name: format!("{source}.out-{target}.in"),
        kind: PortKind::Data,
        source: end(source, "out"),
        target: end(target, "in"),
        data_type: None,
        properties: [].into(),
    }
}
