//! 0.1 → 0.2.

mod connectors;

use super::ports::Typed;
use super::{composite, kept};
use crate::form::each_text;
use crate::names::id_with_colons;
use crate::rts_profile::forms::{
    Component, Condition, DataPort, ExecutionContext, Order, Participants, Preceding, Profile,
    Property, ServicePort, TargetComponent, TargetExecutionContext, WaitTime, v01,
};
use crate::rts_profile::mirror::duration;
use crate::span::{Span, Text};
use connectors::Found;

pub(super) fn up(old: &v01::Profile) -> Profile {
    let mut old = old.clone();
    each_text(&mut old, &mut |of, field, text| {
        let is_id = field.local == "componentId"
            || (field.local == "id" && matches!(of.name, "Profile" | "Component"));
        if is_id {
            text.value = id_with_colons(&text.value);
        }
    });
    let mut new = Profile {
        span: old.span,
        xsi_type: old.xsi_type,
        id: old.id,
        version: Some(Text::new("0.2", Span::default())),
        abstract_text: old.abstract_text,
        creation_date: old.creation_date,
        update_date: old.update_date,
        comment: old.comment,
        version_up_logs: old
            .version_up_logs
            .into_iter()
            .chain(old.version_up_log)
            .collect(),
        properties: old.properties,
        extra: old
            .extra
            .moved(v01::Profile::form_type(), Profile::form_type()),
        ..Profile::default()
    };
    let mut order = Order::default();
    let (mut data, mut service) = (Found::none(), Found::none());
    for mut component in old.components {
        contexts(&mut component.execution_contexts);
        start_up(&component, &mut order);
        data.take::<DataPort>(&mut component);
        service.take::<ServicePort>(&mut component);
        new.components.push(self::component(component));
    }
    data.put::<DataPort>(&mut new);
    service.put::<ServicePort>(&mut new);
    if !order.targets.is_empty() {
        new.start_up.push(order);
    }
    new
}

fn component(old: v01::Component) -> Component {
    let mut new = Component {
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
        data_ports: old.data_ports,
        service_ports: old.service_ports,
        configuration_sets: old.configuration_sets,
        execution_contexts: old.execution_contexts,
        participants: old.participants.into_iter().flat_map(one_by_one).collect(),
        location: old.location,
        properties: old.properties,
        extra: old
            .extra
            .moved(v01::Component::form_type(), Component::form_type()),
    };
    composite(&mut new.composite_type, true);
    for port in &mut new.data_ports {
        port_type(port);
    }
    new
}

/// Contexts have ids since 0.2: their numbers, unless another one was kept.
fn contexts(all: &mut [ExecutionContext]) {
    for (at, context) in all.iter_mut().enumerate() {
        let kept = kept::take(&mut Typed {
            xsi_type: &mut context.xsi_type,
            properties: &mut context.properties,
            extended: "",
        });
        match kept.into_iter().find(|(name, _)| name == "id") {
            Some((_, property)) => context.id = property.value,
            None => {
                let number = || Text::new(at.to_string(), Span::default());
                context.id.get_or_insert_with(number);
            }
        }
    }
}

/// The direction is a property since 0.2.
fn port_type(port: &mut DataPort) {
    let Some(direction) = port.port_type.take() else {
        return;
    };
    let known = |p: &Property| {
        p.name
            .as_ref()
            .is_some_and(|name| name.trimmed() == "port.port_type")
    };
    if !port.properties.iter().any(known) {
        let name = Some(Text::new("port.port_type", Span::default()));
        port.properties.push(Property {
            name,
            value: Some(direction),
            ..Property::default()
        });
        port.xsi_type
            .get_or_insert_with(|| Text::new("rtsExt:dataport_ext", Span::default()));
    }
}

/// Each member has a `Participants` of its own since 0.2.
fn one_by_one(mut all: Participants) -> Vec<Participants> {
    let rest = match all.participant.len() {
        0 | 1 => Vec::new(),
        _ => all.participant.split_off(1),
    };
    let alone = |participant: TargetComponent| Participants {
        span: participant.span,
        participant: vec![participant],
        ..Participants::default()
    };
    std::iter::once(all)
        .chain(rest.into_iter().map(alone))
        .collect()
}

/// What a component waits for becomes a condition of the system's order.
fn start_up(component: &v01::Component, order: &mut Order) {
    let Some(from) = &component.start_up else {
        return;
    };
    let first_context = component
        .execution_contexts
        .first()
        .and_then(|context| context.id.clone());
    let target = TargetExecutionContext {
        id: first_context.or_else(|| Some(Text::new("0", Span::default()))),
        component_id: component.id.clone(),
        instance_name: component.instance_name.clone(),
        ..TargetExecutionContext::default()
    };
    let nothing = [v01::Condition::default()];
    let conditions = match from.conditions.as_slice() {
        [] => &nothing,
        conditions => conditions,
    };
    for condition in conditions {
        let wait_time = condition.wait_time.as_ref().and_then(|text| {
            let time = Text::new(duration(&text.value)?.to_string(), text.span);
            Some(Box::new(WaitTime {
                wait_time: Some(time),
                ..WaitTime::default()
            }))
        });
        order.targets.push(Condition {
            span: match condition.span.is_unknown() {
                true => from.span,
                false => condition.span,
            },
            xsi_type: condition.xsi_type.clone(),
            sequence: from.sequence.clone(),
            wait_time,
            preceding: condition
                .preceding
                .as_deref()
                .map(|preceding| Box::new(self::preceding(preceding))),
            target_component: Some(Box::new(target.clone())),
            properties: condition.properties.clone(),
            extra: condition
                .extra
                .moved(v01::Condition::form_type(), Condition::form_type()),
        });
    }
}

/// Version 0.1 says neither when nor how long: a component that goes before is waited for.
fn preceding(old: &v01::Preceding) -> Preceding {
    let text = |value: &str| Some(Text::new(value, Span::default()));
    let component = |target: &TargetComponent| TargetExecutionContext {
        span: target.span,
        xsi_type: target.xsi_type.clone(),
        id: text("0"),
        component_id: target.component_id.clone(),
        instance_name: target.instance_name.clone(),
        properties: target.properties.clone(),
        extra: target.extra.moved(
            TargetComponent::form_type(),
            TargetExecutionContext::form_type(),
        ),
    };
    Preceding {
        span: old.span,
        sending_timing: text("SYNC"),
        timeout: text("0"),
        components: old.components.iter().map(component).collect(),
        extra: old
            .extra
            .moved(v01::Preceding::form_type(), Preceding::form_type()),
    }
}
