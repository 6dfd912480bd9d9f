//! Connectors: both ends exist, fit each other, and are not said twice.

use std::collections::{HashMap, HashSet};

use super::component::foreign_prefix;
use super::sink::said;
use super::{Check, choices, service};
use crate::names;
use crate::rts_profile::model::{Component, Connector, Port, Target, property_value};
use crate::rts_profile::{
    NAME_KEY, composite, data_type_of, direction_of, is_reversed, normal_data_type, properties,
};
use crate::span::{Span, Text};
use crate::suggest;
use crate::system::{Direction, PortKind};

pub(super) fn connectors(check: &mut Check<'_>) {
    let read = check.read;
    let mut pairs = HashSet::new();
    repeated_ids(check);
    for connector in &read.profile.connectors {
        let name = connector.name.as_ref().map_or("", |name| name.trimmed());
        let owner = if name.is_empty() {
            "a connector".to_owned()
        } else {
            format!("connector `{name}`")
        };
        if let Some(own) = property_value(&connector.properties, NAME_KEY)
            && let Some(fault) = names::connector_name_fault(own.trimmed())
        {
            let message = format!("the name of {owner} cannot be used: {fault}");
            let help = "a connector's name has no `/` and no control character";
            check.error("bad-name", message, own.span, help);
        }
        push_interval(check, connector, &owner);
        settings(check, connector, &owner);
        let source = end(
            check,
            connector,
            connector.source.as_ref(),
            "source",
            &owner,
        );
        let target = end(
            check,
            connector,
            connector.target.as_ref(),
            "target",
            &owner,
        );
        choices::known(check, connector, &owner, [source, target]);
        service::bindings(check, connector, &owner);
        if let (Some(source), Some(target)) = (source, target) {
            if source.path() == target.path() {
                to_itself(check, connector, &owner, target);
                continue;
            }
            choices::choices(check, connector, [source, target]);
            directions(check, connector, source, target);
            data_types(check, connector, source, target);
            let (from, to) = if is_reversed(read, connector) {
                (target, source)
            } else {
                (source, target)
            };
            if !pairs.insert((from.path(), to.path())) {
                let message = format!(
                    "`{}` and `{}` are connected more than once",
                    from.path(),
                    to.path()
                );
                check.warning(
                    "repeated-connector",
                    message,
                    connector.span,
                    "each sample arrives twice; remove one",
                );
            }
        }
    }
}

/// The interval of a periodic connector is a number of seconds.
fn push_interval(check: &mut Check<'_>, connector: &Connector, owner: &str) {
    let Some(interval) = said(&connector.push_interval) else {
        return;
    };
    let number = interval.trimmed().parse::<f64>();
    if !number.is_ok_and(|seconds| seconds >= 0.0 && seconds.is_finite()) {
        let message = format!(
            "the push interval `{}` of {owner} is no number of seconds; it is passed over",
            interval.trimmed()
        );
        let help = "write a number such as `0.1`";
        check.warning("bad-number", message, interval.span, help);
    }
}

/// What the properties say of buffers and policies can be done.
fn settings(check: &mut Check<'_>, connector: &Connector, owner: &str) {
    if connector.kind != PortKind::Data {
        return;
    }
    for property in &connector.properties {
        let Some(name) = &property.name else { continue };
        if let Some(meant) = crate::connector::meant(name.trimmed()) {
            let message = format!("nothing reads the property `{}` of {owner}", name.trimmed());
            let help = format!("did you mean `{meant}`?");
            check.warning("unknown-property", message, name.span, help);
        }
    }
    let Err(faults) = crate::connector::read(&properties(connector)) else {
        return;
    };
    for fault in faults {
        let attribute = match fault.property.as_str() {
            "dataport.dataflow_type" => &connector.dataflow_type,
            "dataport.subscription_type" => &connector.subscription_type,
            _ => &None,
        };
        let text = property_value(&connector.properties, &fault.property);
        let span = text.or(attribute.as_ref());
        let span = span.map_or(connector.span, |text| text.span);
        let message = format!("`{}` of {owner}: {}", fault.property, fault.problem);
        check.error(fault.code, message, span, fault.help);
    }
}

/// A port that is both ends: data can never get anywhere, and a service port would call itself.
fn to_itself(check: &mut Check<'_>, connector: &Connector, owner: &str, end: End<'_>) {
    let message = format!("{owner} joins `{}` with itself", end.path());
    let help = "name the port of another component as one of its ends, or remove the connector";
    match connector.kind {
        PortKind::Data => check.error("self-connector", message, end.span, help),
        PortKind::Service => check.warning("self-connector", message, end.span, help),
    }
}

/// Ids of connectors that stand twice. Several targets in one element make connectors of one id.
fn repeated_ids(check: &mut Check<'_>) {
    let read = check.read;
    let mut first: HashMap<&str, Span> = HashMap::new();
    for connector in &read.profile.connectors {
        let Some(id) = said(&connector.connector_id) else {
            continue;
        };
        let before = *first.entry(id.trimmed()).or_insert(connector.span);
        if before == connector.span {
            continue;
        }
        let line = read.place(before).map_or(0, |place| place.line);
        let message = format!("two connectors have the id `{}`", id.trimmed());
        let help = format!(
            "the other one is in line {line}; give each its own, since editors tell them apart by it"
        );
        check.warning("duplicate-connector-id", message, id.span, help);
    }
}

/// An end whose component and port are in the profile.
#[derive(Clone, Copy)]
pub(super) struct End<'a> {
    instance: &'a str,
    bare: &'a str,
    pub(super) port: &'a Port,
    span: Span,
}

impl End<'_> {
    pub(super) fn path(&self) -> String {
        format!("{}.{}", self.instance, self.bare)
    }
}

fn end<'a>(
    check: &mut Check<'a>,
    connector: &Connector,
    target: Option<&'a Target>,
    role: &str,
    owner: &str,
) -> Option<End<'a>> {
    let kind = match connector.kind {
        PortKind::Data => "DataPort",
        PortKind::Service => "ServicePort",
    };
    let Some(target) = target else {
        let element = check.read.spelled(&format!("{role}{kind}"));
        check.error(
            "missing-end",
            format!("{owner} has no {role} end"),
            connector.span,
            format!("add `{element}` with the instance and port name"),
        );
        return None;
    };
    let what = format!("the {role} of {owner}");
    let instance = check.instance(target, &what);
    let name = check.required(&target.port_name, "portName", &what, target.span)?;
    let instance = instance?;
    let component = check.read.component(instance)?;
    let (mut instance, mut component) = (instance, component);
    let mut bare = component.bare_port(&name.value);
    let mut found = check.read.port(instance, &name.value);
    if composite::kind(component).is_some() {
        let (member, port, kind, declared) = super::composite::end(check, component, name)?;
        instance = member
            .instance_name
            .as_ref()
            .map_or(instance, Text::trimmed);
        (component, bare, found) = (member, port, Some((kind, declared)));
    }
    match found {
        Some((found, port)) if found == connector.kind => Some(End {
            instance,
            bare,
            port,
            span: name.span,
        }),
        Some((found, _)) => {
            let message = format!(
                "`{instance}.{bare}` is a {}, but {owner} joins {}s",
                noun(found),
                noun(connector.kind)
            );
            check.error(
                "port-kind-mismatch",
                message,
                name.span,
                format!("connect it with a {} connector", word(found)),
            );
            None
        }
        None => {
            unknown_port(check, component, instance, bare, name.span, connector.kind);
            None
        }
    }
}

fn word(kind: PortKind) -> &'static str {
    match kind {
        PortKind::Data => "data",
        PortKind::Service => "service",
    }
}

fn noun(kind: PortKind) -> &'static str {
    match kind {
        PortKind::Data => "data port",
        PortKind::Service => "service port",
    }
}

fn unknown_port(
    check: &mut Check<'_>,
    component: &Component,
    instance: &str,
    bare: &str,
    span: Span,
    kind: PortKind,
) {
    if check.sink.is_full() {
        return;
    }
    if let Some(other) = foreign_prefix(check, component, bare) {
        let message = format!(
            "the port `{bare}` belongs to `{other}`, but the end names the component `{instance}`"
        );
        let help = format!(
            "write `{}` = `{other}`, or a port of `{instance}`",
            check.read.spelled("instanceName")
        );
        check.error("instance-prefix", message, span, help);
        return;
    }
    if check.sink.is_full() {
        return;
    }
    let declared: Vec<&str> = component
        .ports()
        .filter(|(found, _)| *found == kind)
        .filter_map(|(_, port)| port.name.as_ref())
        .map(|name| component.bare_port(&name.value))
        .collect();
    let help = if declared.is_empty() {
        format!(
            "`{instance}` declares no {}; declare it, or connect another component",
            noun(kind)
        )
    } else {
        suggest::advice(bare, "declared", &declared)
    };
    let message = format!("component `{instance}` has no {} `{bare}`", noun(kind));
    check.error("unknown-port", message, span, help);
}

fn directions(check: &mut Check<'_>, connector: &Connector, source: End<'_>, target: End<'_>) {
    if connector.kind != PortKind::Data {
        return;
    }
    let both = match (direction_of(source.port), direction_of(target.port)) {
        (Some(a), Some(b)) if a == b => a,
        _ => return,
    };
    let (what, other, span) = match both {
        Direction::In => ("in-ports", "an out-port", source.span),
        Direction::Out => ("out-ports", "an in-port", target.span),
    };
    let message = format!(
        "`{}` and `{}` are both {what}",
        source.path(),
        target.path()
    );
    check.error(
        "direction-mismatch",
        message,
        span,
        format!("one end of a data connector must be {other}"),
    );
}

/// The types of the two ports and of the connector itself; those that are not said fit anything.
fn data_types(check: &mut Check<'_>, connector: &Connector, source: End<'_>, target: End<'_>) {
    if connector.kind != PortKind::Data {
        return;
    }
    let from = data_type_of(source.port);
    let to = data_type_of(target.port);
    if let (Some(from), Some(to)) = (&from, &to)
        && from != to
    {
        let message = format!(
            "`{}` has the type `{from}`, `{}` has `{to}`",
            source.path(),
            target.path()
        );
        check.error(
            "data-type-mismatch",
            message,
            target.span,
            "connect ports of one type, or put a converter between them",
        );
        return;
    }
    let property = property_value(&connector.properties, "dataport.data_type");
    let Some(own) = property.or(connector.data_type.as_ref()) else {
        return;
    };
    let (Some(said), Some(ports)) = (normal_data_type(&own.value), from.or(to)) else {
        return;
    };
    if said != ports {
        let message = format!("the connector says the type `{said}`, its ports `{ports}`");
        check.error(
            "data-type-mismatch",
            message,
            own.span,
            format!("write `{ports}`"),
        );
    }
}
