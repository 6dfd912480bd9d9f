//! Connectors, at the root of the profile or in the ports where they start.

use super::properties;
use crate::rts_profile::forms;
use crate::rts_profile::model::{Component, Connector, Property, RtsProfile, Target};
use crate::span::Text;
use crate::system::PortKind;

/// Longest names that the connectors of a port get from it, in bytes: each of them has its own copy.
const LONGEST: usize = 256;

/// Most that the connectors to further targets get from the first, in bytes.
const COPIED: usize = 16 << 10;

/// Connectors that lie in the ports of a component, whose source is the port.
pub(super) fn nested(
    data: &[forms::DataPort],
    service: &[forms::ServicePort],
    component: &Component,
    profile: &mut RtsProfile,
) {
    let length = |text: &Option<Text>| text.as_ref().map_or(0, |text| text.value.len());
    let own = length(&component.instance_name) + length(&component.id);
    let source = |span, name: &Option<Text>| {
        (own + length(name) <= LONGEST).then(|| Target {
            span,
            instance_name: component.instance_name.clone(),
            component_id: component.id.clone(),
            port_name: name.clone(),
            ..Target::default()
        })
    };
    for port in data {
        let source = source(port.span, &port.name);
        let inner = port.connectors.iter();
        let inner = inner.flat_map(|connector| data_connectors(connector, source.as_ref()));
        profile.connectors.extend(inner);
    }
    for port in service {
        let source = source(port.span, &port.name);
        let inner = port.connectors.iter();
        let inner = inner.flat_map(|connector| service_connectors(connector, source.as_ref()));
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

/// One connector for each target: some real files have several in one element. Where that would copy more than any of
/// them has, further connectors have no more than their ends.
fn for_each_target(connector: Connector, targets: &[forms::TargetPort]) -> Vec<Connector> {
    let Some((last, others)) = targets.split_last() else {
        return vec![connector];
    };
    let copied = match others.len().saturating_mul(weight(&connector)) <= COPIED {
        true => connector.clone(),
        false => bare(&connector),
    };
    let mut all: Vec<Connector> = others
        .iter()
        .map(|end| Connector {
            target: Some(target_port(end)),
            ..copied.clone()
        })
        .collect();
    all.push(Connector {
        target: Some(target_port(last)),
        ..connector
    });
    all
}

/// Bytes of text in what a copy has, and something for each property.
fn weight(connector: &Connector) -> usize {
    const PROPERTY: usize = 96;
    let length = |text: &Option<Text>| text.as_ref().map_or(0, |text| text.value.len());
    let properties = |all: &[Property]| -> usize {
        let one = |p: &Property| PROPERTY + length(&p.name) + length(&p.value);
        all.iter().map(one).sum()
    };
    let source = connector.source.as_ref().map_or(0, |source| {
        length(&source.instance_name)
            + length(&source.component_id)
            + length(&source.port_name)
            + properties(&source.properties)
    });
    let texts = [
        &connector.connector_id,
        &connector.name,
        &connector.data_type,
        &connector.interface_type,
        &connector.dataflow_type,
        &connector.subscription_type,
        &connector.push_interval,
    ];
    let own: usize = texts.into_iter().map(length).sum();
    own + source + properties(&connector.properties)
}

fn bare(connector: &Connector) -> Connector {
    Connector {
        span: connector.span,
        kind: connector.kind,
        connector_id: None,
        name: None,
        data_type: None,
        interface_type: None,
        dataflow_type: None,
        subscription_type: None,
        push_interval: None,
        source: None,
        target: None,
        properties: Vec::new(),
    }
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
