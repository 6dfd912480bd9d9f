//! 0.2 → 0.1.

mod connectors;

use std::collections::HashMap;

use super::kept::keep;
use super::ports::Typed;
use super::{by_name, composite};
use crate::form::{Stray, each_text, take_fields};
use crate::names::id_with_dots;
use crate::rts_profile::forms::{
    Component, Condition, DataPort, Order, Participants, Preceding, Profile, ServicePort,
    TargetComponent, TargetExecutionContext, v01,
};
use crate::span::{Span, Text};

/// What version 0.1 has no place for. The form of its root has no field for groups and for orders but that of the start.
const LATER: [(&str, &str); 1] = [("ServicePortConnector", "trans_method")];

pub(super) fn down(old: &Profile) -> v01::Profile {
    let mut old = old.clone();
    take_fields(&mut old, &LATER, &mut Vec::new());
    ids(&mut old);
    let mut components: Vec<v01::Component> = old.components.into_iter().map(component).collect();
    let index = by_name(
        components
            .iter()
            .map(|component| component.instance_name.as_ref()),
    );
    connectors::down::<DataPort>(old.data_port_connectors, &mut components, &index);
    connectors::down::<ServicePort>(old.service_port_connectors, &mut components, &index);
    for order in old.start_up {
        start_up(order, &mut components, &index);
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

/// An id that cannot be said with dots stays as it is.
fn ids(profile: &mut Profile) {
    each_text(profile, &mut |of, field, text| {
        let own = field.local == "id" && matches!(of.name, "Profile" | "Component");
        if (own || field.local == "componentId")
            && let Some(id) = id_with_dots(&text.value)
        {
            text.value = id;
        }
    });
}

fn component(old: Component) -> v01::Component {
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
    composite(&mut new.composite_type, false);
    for (at, context) in new.execution_contexts.iter_mut().enumerate() {
        let id = context.id.take();
        let mut typed = Typed {
            xsi_type: &mut context.xsi_type,
            properties: &mut context.properties,
            extended: "rtsExt:execution_context_ext",
        };
        // The ids of most contexts are their numbers.
        if id.as_ref().is_none_or(|id| id.value != at.to_string()) {
            keep(&mut typed, "id", id);
        }
    }
    new
}

/// All members are in one `Participants`.
fn together(all: Vec<Participants>) -> Vec<Participants> {
    let mut all = all.into_iter().map(with_member);
    let Some(mut first) = all.next() else {
        return Vec::new();
    };
    for other in all {
        first.participant.extend(other.participant);
        let comments = other.extra.get().strays.iter();
        let comments = comments.filter(|s| matches!(s, Stray::Comment(_) | Stray::Instruction(_)));
        let mut comments: Vec<Stray> = comments.cloned().collect();
        if !comments.is_empty() {
            first.extra.edit().strays.append(&mut comments);
        }
    }
    vec![first]
}

/// A member that some files name in the attributes of `Participants`.
fn with_member(mut of: Participants) -> Participants {
    if of.participant.is_empty() && of.instance_name.is_some() {
        of.participant.push(TargetComponent {
            span: of.span,
            component_id: of.component_id.take(),
            instance_name: of.instance_name.take(),
            ..TargetComponent::default()
        });
    }
    of
}

/// A condition of the system's order becomes what its component waits for.
fn start_up(order: Order, components: &mut [v01::Component], index: &HashMap<String, usize>) {
    for condition in order.targets {
        let target = condition
            .target_component
            .as_ref()
            .and_then(|target| target.instance_name.as_ref());
        let at = target.and_then(|name| index.get(name.trimmed()));
        let Some(component) = at.and_then(|at| components.get_mut(*at)) else {
            continue;
        };
        let own = component.start_up.get_or_insert_with(|| {
            Box::new(v01::StartUp {
                sequence: condition.sequence.clone(),
                ..v01::StartUp::default()
            })
        });
        let condition = self::condition(condition);
        if condition.wait_time.is_some() || condition.preceding.is_some() {
            own.conditions.push(condition);
        }
    }
}

fn condition(old: Condition) -> v01::Condition {
    let wait_time = old
        .wait_time
        .and_then(|wait| wait.wait_time)
        .and_then(|text| {
            let milliseconds: u64 = text.trimmed().parse().ok()?;
            let (seconds, rest) = (milliseconds / 1000, milliseconds % 1000);
            let fraction = format!(".{rest:03}");
            let fraction = fraction.trim_end_matches('0').trim_end_matches('.');
            Some(Text::new(format!("PT{seconds}{fraction}S"), text.span))
        });
    let mut extra = old
        .extra
        .moved(Condition::form_type(), v01::Condition::form_type());
    if wait_time.is_none() && !extra.is_empty() {
        // A second one would be taken for the first, which could not be said.
        let second = |stray: &Stray| matches!(stray, Stray::Element(e) if e.local() == "WaitTime");
        extra.edit().strays.retain(|stray| !second(stray));
    }
    v01::Condition {
        span: old.span,
        xsi_type: old.xsi_type,
        wait_time,
        preceding: old
            .preceding
            .map(|preceding| Box::new(self::preceding(*preceding))),
        properties: old.properties,
        extra,
    }
}

fn preceding(old: Preceding) -> v01::Preceding {
    let component = |target: TargetExecutionContext| TargetComponent {
        span: target.span,
        xsi_type: target.xsi_type,
        component_id: target.component_id,
        instance_name: target.instance_name,
        properties: target.properties,
        extra: target.extra.moved(
            TargetExecutionContext::form_type(),
            TargetComponent::form_type(),
        ),
    };
    v01::Preceding {
        span: old.span,
        components: old.components.into_iter().map(component).collect(),
        extra: old
            .extra
            .moved(Preceding::form_type(), v01::Preceding::form_type()),
    }
}
