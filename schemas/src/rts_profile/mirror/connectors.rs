//! Connectors, at the root of the profile or in the ports where they start.

use super::properties;
use crate::rts_profile::forms;
use crate::rts_profile::model::{Component, Connector, RtsProfile, Target};
use crate::span::Text;
use crate::system::PortKind;

/// Connectors that lie in the ports of a component, whose source is the port.
pub(super) fn nested(
    data: &[forms::DataPort],
    service: &[forms::ServicePort],
    component: &Component,
    profile: &mut RtsProfile,
) {
    let source = |span, name: &Option<Text>| Target {
        span,
        instance_name: component.instance_name.clone(),
        component_id: component.id.clone(),
        port_name: name.clone(),
        ..Target::default()
    };
    for port in data {
        let source = source(port.span, &port.name);
        let inner = port.connectors.iter();
        let inner = inner.flat_map(|connector| data_connectors(connector, Some(&source)));
        profile.connectors.extend(inner);
    }
    for port in service {
        let source = source(port.span, &port.name);
        let inner = port.connectors.iter();
        let inner = inner.flat_map(|connector| service_connectors(connector, Some(&source)));
        profile.connectors.extend(inner);
    }
}

pub(super) fn data_connectors(
    from: &forms::DataPortConnector,
    implied: Option<&Target>,
) -> Vec<Connector> {
    let source = from.source.as_deref().map(target_port);
    let connector = Connector {
        span: from.span,
        kind: PortKind::Data,
        connector_id: from.connector_id.clone(),
        name: from.name.clone(),
        data_type: from.data_type.clone(),
        interface_type: from.interface_type.clone(),
        dataflow_type: from.dataflow_type.clone(),
        subscription_type: from.subscription_type.clone(),
        push_interval: from.push_interval.clone(),
        source: source.or_else(|| implied.cloned()),
        target: None,
        properties: properties(&from.properties),
    };
    for_each_target(connector, &from.targets)
}

pub(super) fn service_connectors(
    from: &forms::ServicePortConnector,
    implied: Option<&Target>,
) -> Vec<Connector> {
    let source = from.source.as_deref().map(target_port);
    let connector = Connector {
        span: from.span,
        kind: PortKind::Service,
        connector_id: from.connector_id.clone(),
        name: from.name.clone(),
        data_type: None,
        interface_type: None,
        dataflow_type: None,
        subscription_type: None,
        push_interval: None,
        source: source.or_else(|| implied.cloned()),
        target: None,
        properties: properties(&from.properties),
    };
    for_each_target(connector, &from.targets)
}

/// One connector for each target: some real files have several in one element.
fn for_each_target(connector: Connector, targets: &[forms::TargetPort]) -> Vec<Connector> {
    let Some((last, others)) = targets.split_last() else {
        return vec![connector];
    };
    let mut all: Vec<Connector> = others
        .iter()
        .map(|end| Connector {
            target: Some(target_port(end)),
            ..connector.clone()
        })
        .collect();
    all.push(Connector {
        target: Some(target_port(last)),
        ..connector
    });
    all
}

fn target_port(from: &forms::TargetPort) -> Target {
    Target {
        span: from.span,
        instance_name: from.instance_name.clone(),
        component_id: from.component_id.clone(),
        port_name: from.port_name.clone(),
        properties: properties(&from.properties),
        ..Target::default()
    }
}
