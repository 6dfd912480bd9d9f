//! 0.2 → 0.1.

use std::collections::HashMap;

use super::{Lost, by_name, composite, instance};
use crate::form::{each_text, take_fields};
use crate::names::id_with_dots;
use crate::rts_profile::forms::{
    Component, Condition, DataPort, DataPortConnector, Order, Participants, Preceding, Profile,
    ServicePort, ServicePortConnector, TargetComponent, TargetExecutionContext, TargetPort, v01,
};
use crate::rts_profile::parse_whole;
use crate::span::{Span, Text};

/// What version 0.1 has no place for.
const LATER: [(&str, &str); 9] = [
    ("Profile", "groups"),
    ("Profile", "shut_down"),
    ("Profile", "activation"),
    ("Profile", "deactivation"),
    ("Profile", "resetting"),
    ("Profile", "initializing"),
    ("Profile", "finalizing"),
    ("Profile", "systems"),
    ("ServicePortConnector", "trans_method"),
];

pub(super) fn down(old: &Profile, lost: &mut Lost<'_>) -> v01::Profile {
    let mut old = old.clone();
    let mut taken = Vec::new();
    take_fields(&mut old, &LATER, &mut taken);
    lost.taken(taken);
    ids(&mut old, lost);
    let mut components: Vec<v01::Component> = old
        .components
        .into_iter()
        .map(|component| self::component(component, lost))
        .collect();
    let index = by_name(
        components
            .iter()
            .map(|component| component.instance_name.as_ref()),
    );
    for connector in old.data_port_connectors {
        data_connector(connector, &mut components, &index, lost);
    }
    for connector in old.service_port_connectors {
        service_connector(connector, &mut components, &index, lost);
    }
    for order in old.start_up {
        start_up(order, &mut components, &index, lost);
    }
    v01::Profile {
        span: old.span,
        xsi_type: old.xsi_type,
        id: old.id,
        version: Some(Text::new("0.1", Span::default())),
        abstract_text: old.abstract_text,
        creation_date: old.creation_date,
        update_date: old.update_date,
        comment: old.comment,
        components,
        version_up_log: old.version_up_logs,
        properties: old.properties,
        extra: old
            .extra
            .moved(Profile::form_type(), v01::Profile::form_type()),
        ..v01::Profile::default()
    }
}

fn ids(profile: &mut Profile, lost: &mut Lost<'_>) {
    let mut beyond = Vec::new();
    each_text(profile, &mut |of, field, text| {
        let own = field.local == "id" && matches!(of.name, "Profile" | "Component");
        if !own && field.local != "componentId" {
            return;
        }
        match id_with_dots(&text.value) {
            Some(id) => text.value = id,
            // An id that is referred to is named once, where it is given.
            None if own => beyond.push(text.clone()),
            None => {}
        }
    });
    for text in beyond {
        lost.say(
            &format!(
                "the id `{}`, whose fields have dots of their own,",
                text.value
            ),
            text.span,
        );
    }
}

fn component(old: Component, lost: &mut Lost<'_>) -> v01::Component {
    let mut new = v01::Component {
        span: old.span,
        xsi_type: old.xsi_type,
        id: old.id,
        instance_name: old.instance_name,
        path_uri: old.path_uri,
        active_configuration_set: old.active_configuration_set,
        composite_type: old.composite_type,
        is_required: old.is_required,
        comment: old.comment,
        visible: old.visible,
        start_up: None,
        participants: together(old.participants),
        execution_contexts: old.execution_contexts,
        configuration_sets: old.configuration_sets,
        data_ports: old.data_ports,
        service_ports: old.service_ports,
        location: old.location,
        properties: old.properties,
        extra: old
            .extra
            .moved(Component::form_type(), v01::Component::form_type()),
    };
    composite(&mut new.composite_type, lost);
    for (at, context) in new.execution_contexts.iter_mut().enumerate() {
        let Some(id) = context.id.take() else {
            continue;
        };
        if id.trimmed() != at.to_string() {
            lost.say(
                &format!("the id `{}` of an execution context", id.value),
                id.span,
            );
        }
    }
    new
}

/// All members are in one `Participants`.
fn together(all: Vec<Participants>) -> Vec<Participants> {
    let mut all = all.into_iter();
    let Some(mut first) = all.next() else {
        return Vec::new();
    };
    first
        .participant
        .extend(all.flat_map(|one| one.participant));
    vec![first]
}

/// What the source's own address repeats is no loss.
fn source_properties(source: &TargetPort, lost: &mut Lost<'_>) {
    for property in &source.properties {
        let name = property.name.as_ref().map_or("", Text::trimmed);
        if name != "COMPONENT_PATH_ID" {
            lost.say(
                &format!("the property `{name}` of the port that a connector starts from"),
                property.span,
            );
        }
    }
}

fn bare<'a>(instance: &str, port: &'a str) -> &'a str {
    let rest = port
        .trim()
        .strip_prefix(instance)
        .and_then(|rest| rest.strip_prefix('.'));
    rest.unwrap_or(port.trim())
}

/// The position of the port that a source names; a port that is not declared is.
fn port<T>(
    ports: &mut Vec<T>,
    source: &TargetPort,
    name: impl Fn(&T) -> Option<&Text>,
    make: impl Fn(&TargetPort) -> T,
) -> usize {
    let instance = instance(Some(source));
    let wanted = bare(
        instance,
        source.port_name.as_ref().map_or("", Text::trimmed),
    )
    .to_owned();
    let found = ports
        .iter()
        .position(|port| name(port).is_some_and(|name| bare(instance, &name.value) == wanted));
    found.unwrap_or_else(|| {
        ports.push(make(source));
        ports.len() - 1
    })
}

fn data_connector(
    mut connector: DataPortConnector,
    components: &mut [v01::Component],
    index: &HashMap<String, usize>,
    lost: &mut Lost<'_>,
) {
    let at = index.get(instance(connector.source.as_deref()));
    let (Some(source), Some(component)) = (
        connector.source.take(),
        at.and_then(|at| components.get_mut(*at)),
    ) else {
        lost.say("a connector that starts from no component", connector.span);
        return;
    };
    source_properties(&source, lost);
    let ports = &mut component.data_ports;
    let make = |source: &TargetPort| DataPort {
        name: source.port_name.clone(),
        ..DataPort::default()
    };
    let at = port(ports, &source, |port| port.name.as_ref(), make);
    if let Some(port) = ports.get_mut(at) {
        port.connectors.push(connector);
    }
}

fn service_connector(
    mut connector: ServicePortConnector,
    components: &mut [v01::Component],
    index: &HashMap<String, usize>,
    lost: &mut Lost<'_>,
) {
    let at = index.get(instance(connector.source.as_deref()));
    let (Some(source), Some(component)) = (
        connector.source.take(),
        at.and_then(|at| components.get_mut(*at)),
    ) else {
        lost.say("a connector that starts from no component", connector.span);
        return;
    };
    source_properties(&source, lost);
    let ports = &mut component.service_ports;
    let make = |source: &TargetPort| ServicePort {
        name: source.port_name.clone(),
        ..ServicePort::default()
    };
    let at = port(ports, &source, |port| port.name.as_ref(), make);
    if let Some(port) = ports.get_mut(at) {
        port.connectors.push(connector);
    }
}

/// A condition of the system's order becomes what its component waits for.
fn start_up(
    order: Order,
    components: &mut [v01::Component],
    index: &HashMap<String, usize>,
    lost: &mut Lost<'_>,
) {
    for condition in order.targets {
        let target = condition
            .target_component
            .as_ref()
            .and_then(|target| target.instance_name.as_ref());
        let at = target.and_then(|name| index.get(name.trimmed()));
        let Some(component) = at.and_then(|at| components.get_mut(*at)) else {
            lost.say("a condition of no component", condition.span);
            continue;
        };
        let own = component.start_up.get_or_insert_with(|| {
            Box::new(v01::StartUp {
                sequence: condition.sequence.clone(),
                ..v01::StartUp::default()
            })
        });
        let number = |text: &Option<Text>| text.as_ref().and_then(|text| parse_whole(&text.value));
        if number(&own.sequence) != number(&condition.sequence) {
            let span = condition
                .sequence
                .as_ref()
                .map_or(condition.span, |text| text.span);
            lost.say("a second sequence number of a component", span);
        }
        if condition.wait_time.is_some() || condition.preceding.is_some() {
            own.conditions.push(self::condition(condition, lost));
        }
    }
}

fn condition(old: Condition, lost: &mut Lost<'_>) -> v01::Condition {
    let wait_time = old
        .wait_time
        .and_then(|wait| wait.wait_time)
        .and_then(|text| {
            let milliseconds: Option<u64> = text.trimmed().parse().ok();
            if milliseconds.is_none() {
                lost.say(&format!("the time `{}`", text.value), text.span);
            }
            let (seconds, rest) = (milliseconds? / 1000, milliseconds? % 1000);
            let fraction = format!(".{rest:03}");
            let fraction = fraction.trim_end_matches('0').trim_end_matches('.');
            Some(Text::new(format!("PT{seconds}{fraction}S"), text.span))
        });
    v01::Condition {
        span: old.span,
        xsi_type: old.xsi_type,
        wait_time,
        preceding: old
            .preceding
            .map(|preceding| Box::new(self::preceding(*preceding, lost))),
        properties: old.properties,
        ..v01::Condition::default()
    }
}

fn preceding(old: Preceding, lost: &mut Lost<'_>) -> v01::Preceding {
    if let Some(timing) = old
        .sending_timing
        .filter(|timing| !timing.trimmed().eq_ignore_ascii_case("SYNC"))
    {
        lost.say(
            &format!("`rts:sendingTiming` `{}`", timing.value),
            timing.span,
        );
    }
    if let Some(timeout) = old
        .timeout
        .filter(|timeout| !matches!(timeout.trimmed(), "0" | ""))
    {
        lost.say("`rts:timeout`", timeout.span);
    }
    let component = |target: TargetExecutionContext| TargetComponent {
        span: target.span,
        component_id: target.component_id,
        instance_name: target.instance_name,
        ..TargetComponent::default()
    };
    v01::Preceding {
        span: old.span,
        components: old.components.into_iter().map(component).collect(),
        ..v01::Preceding::default()
    }
}
