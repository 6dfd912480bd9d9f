//! Forms → mirror: whatever the version and the format, the checks and the lowering see one shape.

mod connectors;
mod start_up;

use super::forms::{self, Shape, v01};
use super::model::{
    Component, Condition, ConfigurationSet, ExecutionContext, Group, Order, OrderKind, Port,
    Preceding, Property, RtsProfile, Target,
};
use connectors::{data_connectors, nested, service_connectors};
use start_up::start_up;

pub(super) use start_up::duration;

/// The mirror of a profile.
pub(super) fn mirror(shape: &Shape) -> RtsProfile {
    match shape {
        Shape::V02(profile) => profile_02(profile),
        Shape::V01(profile) => profile_01(profile),
    }
}

macro_rules! head {
    ($from:expr) => {
        RtsProfile {
            span: $from.span,
            id: $from.id.clone(),
            version: $from.version.clone(),
            abstract_text: $from.abstract_text.clone(),
            comment: $from.comment.clone(),
            creation_date: $from.creation_date.clone(),
            update_date: $from.update_date.clone(),
            properties: properties(&$from.properties),
            ..RtsProfile::default()
        }
    };
}

macro_rules! component {
    ($from:expr) => {
        Component {
            span: $from.span,
            id: $from.id.clone(),
            instance_name: $from.instance_name.clone(),
            path_uri: $from.path_uri.clone(),
            composite_type: $from.composite_type.clone(),
            is_required: $from.is_required.clone(),
            active_configuration_set: $from.active_configuration_set.clone(),
            data_ports: $from.data_ports.iter().map(data_port).collect(),
            service_ports: $from.service_ports.iter().map(service_port).collect(),
            configuration_sets: $from.configuration_sets.iter().map(set).collect(),
            execution_contexts: $from.execution_contexts.iter().map(context).collect(),
            participants: $from.participants.iter().flat_map(participants).collect(),
            properties: properties(&$from.properties),
        }
    };
}

fn profile_02(from: &forms::Profile) -> RtsProfile {
    let mut profile = head!(from);
    profile.components.reserve_exact(from.components.len());
    for component in &from.components {
        let mirrored = component!(component);
        nested(
            &component.data_ports,
            &component.service_ports,
            &mirrored,
            &mut profile,
        );
        profile.components.push(mirrored);
    }
    profile.groups = from.groups.iter().map(group).collect();
    for connector in &from.data_port_connectors {
        profile.connectors.extend(data_connectors(connector, None));
    }
    for connector in &from.service_port_connectors {
        profile
            .connectors
            .extend(service_connectors(connector, None));
    }
    let lists = [
        &from.start_up,
        &from.shut_down,
        &from.activation,
        &from.deactivation,
        &from.resetting,
        &from.initializing,
        &from.finalizing,
    ];
    for (kind, list) in OrderKind::ALL.into_iter().zip(lists) {
        let orders = list.iter().map(|order| Order {
            span: order.span,
            kind,
            conditions: order.targets.iter().map(condition).collect(),
        });
        profile.orders.extend(orders);
    }
    in_order_of_the_file(&mut profile, !from.extra.get().node_order.is_empty());
    profile
}

fn profile_01(from: &v01::Profile) -> RtsProfile {
    let mut profile = head!(from);
    profile.components.reserve_exact(from.components.len());
    for component in &from.components {
        let mirrored = component!(component);
        nested(
            &component.data_ports,
            &component.service_ports,
            &mirrored,
            &mut profile,
        );
        profile.components.push(mirrored);
    }
    let conditions: Vec<Condition> = from.components.iter().filter_map(start_up).collect();
    if let Some(first) = conditions.first() {
        profile.orders.push(Order {
            span: first.span,
            kind: OrderKind::StartUp,
            conditions,
        });
    }
    in_order_of_the_file(&mut profile, true);
    profile
}

/// Different elements may stand in any order in XML, and the checks speak in the order of the file.
fn in_order_of_the_file(profile: &mut RtsProfile, mixed: bool) {
    if mixed {
        profile
            .connectors
            .sort_by_key(|connector| connector.span.start);
        profile.orders.sort_by_key(|order| order.span.start);
    }
}

fn properties(from: &[forms::Property]) -> Vec<Property> {
    let property = |p: &forms::Property| Property {
        span: p.span,
        name: p.name.clone(),
        value: p.value.clone(),
    };
    from.iter().map(property).collect()
}

fn data_port(from: &forms::DataPort) -> Port {
    Port {
        span: from.span,
        name: from.name.clone(),
        properties: properties(&from.properties),
    }
}

fn service_port(from: &forms::ServicePort) -> Port {
    Port {
        span: from.span,
        name: from.name.clone(),
        properties: properties(&from.properties),
    }
}

fn set(from: &forms::ConfigurationSet) -> ConfigurationSet {
    let data = from.data.iter().map(|data| Property {
        span: data.span,
        name: data.name.clone(),
        value: data.data.clone(),
    });
    ConfigurationSet {
        span: from.span,
        id: from.id.clone(),
        data: data.collect(),
    }
}

fn context(from: &forms::ExecutionContext) -> ExecutionContext {
    ExecutionContext {
        span: from.span,
        id: from.id.clone(),
        kind: from.kind.clone(),
        rate: from.rate.clone(),
        properties: properties(&from.properties),
    }
}

fn participants(from: &forms::Participants) -> Vec<Target> {
    if from.participant.is_empty() {
        return vec![Target {
            span: from.span,
            instance_name: from.instance_name.clone(),
            component_id: from.component_id.clone(),
            properties: properties(&from.properties),
            ..Target::default()
        }];
    }
    from.participant.iter().map(target).collect()
}

fn target(from: &forms::TargetComponent) -> Target {
    Target {
        span: from.span,
        instance_name: from.instance_name.clone(),
        component_id: from.component_id.clone(),
        properties: properties(&from.properties),
        ..Target::default()
    }
}

fn target_context(from: &forms::TargetExecutionContext) -> Target {
    Target {
        span: from.span,
        id: from.id.clone(),
        instance_name: from.instance_name.clone(),
        component_id: from.component_id.clone(),
        properties: properties(&from.properties),
        ..Target::default()
    }
}

fn group(from: &forms::Group) -> Group {
    Group {
        span: from.span,
        id: from.group_id.clone(),
        members: from.members.iter().map(target).collect(),
    }
}

fn condition(from: &forms::Condition) -> Condition {
    Condition {
        span: from.span,
        sequence: from.sequence.clone(),
        target: from.target_component.as_deref().map(target_context),
        wait_time: from.wait_time.as_ref().and_then(|w| w.wait_time.clone()),
        preceding: from.preceding.as_ref().map(|preceding| Preceding {
            span: preceding.span,
            sending_timing: preceding.sending_timing.clone(),
            timeout: preceding.timeout.clone(),
            components: preceding.components.iter().map(target_context).collect(),
        }),
    }
}
