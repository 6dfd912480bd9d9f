//! A component against its RTC Profile: ports, parameters, execution context.

use std::collections::HashMap;

use super::{Type, said_by, severity};
use crate::check::library::Found;
use crate::check::parameters::fault;
use crate::check::rtc::rule_of;
use crate::check::sink::{Sink, said};
use crate::diagnostic::{Finding, Severity};
use crate::rtc_profile::forms::Configuration;
use crate::rts_profile::model::{Component, Port};
use crate::rts_profile::{data_type_of, direction_of, execution_kind, is_pseudo_set, parse_rate};
use crate::span::Text;
use crate::suggest;
use crate::system::{ExecutionKind, PortKind};

pub(super) fn component(
    sink: &mut Sink<'_>,
    component: &Component,
    found: Found<'_>,
    kind: &Type<'_>,
) {
    for (port_kind, port) in component.ports() {
        self::port(sink, component, port_kind, port, found, kind);
    }
    parameters(sink, component, found);
    context(sink, component, found);
}

fn port(
    sink: &mut Sink<'_>,
    component: &Component,
    port_kind: PortKind,
    port: &Port,
    found: Found<'_>,
    kind: &Type<'_>,
) {
    let Some(name) = &port.name else { return };
    let bare = component.bare_port(&name.value);
    let owner = component.instance_name.as_ref().map_or("", Text::trimmed);
    let data = kind.data.get(bare);
    let known = match port_kind {
        PortKind::Data => data.is_some(),
        PortKind::Service => kind.service.contains_key(bare),
    };
    if !known {
        if sink.is_full() {
            return;
        }
        let (noun, mut names): (_, Vec<&str>) = match port_kind {
            PortKind::Data => ("data port", kind.data.keys().copied().collect()),
            PortKind::Service => ("service port", kind.service.keys().copied().collect()),
        };
        names.sort_unstable();
        let message = format!("the type of component `{owner}` has no {noun} `{bare}`");
        let help = format!(
            "{}; {}",
            suggest::advice(bare, "it has", &names),
            said_by(found)
        );
        return sink.say(
            severity(found),
            "rtc-unknown-port",
            message,
            name.span,
            help,
        );
    }
    let Some(data) = data.filter(|_| port_kind == PortKind::Data) else {
        return;
    };
    let own = data
        .port_type
        .as_ref()
        .and_then(|t| super::connector::direction(t.trimmed()));
    if let (Some(said), Some(own)) = (direction_of(port), own)
        && said != own
    {
        let message = format!("`{owner}.{bare}` has another direction in its RTC Profile");
        let help = format!(
            "{} there; {}",
            data.port_type.as_ref().map_or("", Text::trimmed),
            said_by(found)
        );
        sink.say(
            severity(found),
            "rtc-port-mismatch",
            message,
            name.span,
            help,
        );
    }
    if let (Some(said), Some(own)) = (data_type_of(port), said(&data.data_type))
        && !super::connector::same_type(&said, own.trimmed())
    {
        let message = format!(
            "`{owner}.{bare}` has the type `{said}`, its RTC Profile says `{}`",
            own.trimmed()
        );
        sink.say(
            severity(found),
            "rtc-port-mismatch",
            message,
            name.span,
            said_by(found),
        );
    }
}

/// The parameters that an RTC Profile declares, by their names.
pub(in crate::check) fn declared(found: Found<'_>) -> HashMap<&str, &Configuration> {
    let sets = found.profile.profile.configuration_set.iter();
    let all = sets.flat_map(|set| &set.configurations);
    all.filter_map(|parameter| Some((parameter.name.as_ref()?.trimmed(), parameter)))
        .collect()
}

fn parameters(sink: &mut Sink<'_>, component: &Component, found: Found<'_>) {
    let known = declared(found);
    if known.is_empty() {
        return;
    }
    let owner = component.instance_name.as_ref().map_or("", Text::trimmed);
    let real = component.configuration_sets.iter().filter(|set| {
        let id = set.id.as_ref().map_or("", Text::trimmed);
        // `__innerparam` belongs to a simulator.
        !is_pseudo_set(id) && !id.starts_with("__")
    });
    for parameter in real.flat_map(|set| &set.data) {
        let Some(name) = &parameter.name else {
            continue;
        };
        let Some(declared) = known.get(name.trimmed()) else {
            if sink.is_full() {
                return;
            }
            let mut names: Vec<&str> = known.keys().copied().collect();
            names.sort_unstable();
            let message = format!(
                "the type of component `{owner}` has no parameter `{}`",
                name.trimmed()
            );
            let advice = suggest::advice(name.trimmed(), "it has", &names);
            let help = format!("{advice}; {}", said_by(found));
            sink.say(
                Severity::Warning,
                "rtc-unknown-parameter",
                message,
                name.span,
                help,
            );
            continue;
        };
        let Some(value) = &parameter.value else {
            continue;
        };
        let what = format!("the parameter `{}`", name.trimmed());
        if let Some(finding) = value_fault(&what, &value.value, declared) {
            sink.push(finding, value.span);
        }
    }
}

/// What is wrong with a value of a parameter, as its RTC Profile has it.
pub(in crate::check) fn value_fault(
    what: &str,
    value: &str,
    declared: &Configuration,
) -> Option<Finding> {
    let data_type = said(&declared.data_type).map(|text| text.value.as_str());
    let rule = declared.constraint.as_deref().and_then(|c| rule_of(c).ok());
    fault(what, value, data_type, rule.as_ref())
}

fn context(sink: &mut Sink<'_>, component: &Component, found: Found<'_>) {
    let (Some(context), Some(info)) = (
        component.execution_contexts.first(),
        found.profile.profile.basic_info.as_deref(),
    ) else {
        return;
    };
    let owner = component.instance_name.as_ref().map_or("", Text::trimmed);
    if let (Some(kind), Some(own)) = (said(&context.kind), said(&info.execution_type)) {
        let periodic = |text: &Text| execution_kind(text.trimmed()) == ExecutionKind::Periodic;
        if periodic(kind) != periodic(own) {
            let message = format!(
                "component `{owner}` runs in a context of the kind `{}`, its type is made for `{}`",
                kind.trimmed(),
                own.trimmed()
            );
            sink.warning("rtc-execution-kind", message, kind.span, said_by(found));
        }
    }
    if let (Some(rate), Some(own)) = (said(&context.rate), said(&info.execution_rate))
        && let (Some(hertz), Some(default)) = (parse_rate(&rate.value), parse_rate(&own.value))
        && (hertz - default).abs() > f64::EPSILON
    {
        let message =
            format!("component `{owner}` runs at {hertz} Hz, its type is made for {default} Hz");
        sink.say(
            Severity::Note,
            "rtc-rate",
            message,
            rate.span,
            said_by(found),
        );
    }
}
