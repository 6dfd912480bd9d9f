//! Ports of an RTC Profile: names, kinds, types, interfaces.

use std::collections::HashMap;

use super::super::sink::{Sink, said};
use super::missing;
use crate::names;
use crate::rtc_profile::forms::{DataPort, RtcProfile, ServicePort};
use crate::span::{Span, Text};
use crate::suggest;

pub(super) fn ports(sink: &mut Sink<'_>, profile: &RtcProfile) {
    let mut seen: HashMap<&str, Span> = HashMap::new();
    let data = profile
        .data_ports
        .iter()
        .map(|port| (&port.name, port.span));
    let service = profile.service_ports.iter();
    let service = service.map(|port| (&port.name, port.span));
    for (name, span) in data.chain(service) {
        let Some(name) = said(name) else {
            sink.error(
                "missing-attribute",
                "a port has no name".to_owned(),
                span,
                "add `name`",
            );
            continue;
        };
        if let Some(fault) = names::name_fault(name.trimmed()) {
            let message = format!("the port name `{}` cannot be used: {fault}", name.trimmed());
            let help = "names have 1 to 128 bytes, no `/` and no control character";
            sink.error("bad-name", message, name.span, help);
        }
        if seen.insert(name.trimmed(), name.span).is_some() {
            let message = format!("two ports have the name `{}`", name.trimmed());
            let help = "give each its own name: the component cannot register the second one";
            sink.error("duplicate-port", message, name.span, help);
        }
    }
    for port in &profile.data_ports {
        data_port(sink, port);
    }
    for port in &profile.service_ports {
        interfaces(sink, port);
    }
}

fn data_port(sink: &mut Sink<'_>, port: &DataPort) {
    const KINDS: [&str; 3] = ["DataInPort", "DataOutPort", "EventPort"];
    let name = port.name.as_ref().map_or("", Text::trimmed);
    match said(&port.port_type) {
        None => missing(
            sink,
            &format!("the kind of the port `{name}`"),
            port.span,
            "add `portType`",
        ),
        Some(kind)
            if !KINDS
                .iter()
                .any(|known| known.eq_ignore_ascii_case(kind.trimmed())) =>
        {
            let message = format!("`{}` is no kind of data port", kind.trimmed());
            let help = match kind.trimmed().to_ascii_lowercase().as_str() {
                "in" => "write `DataInPort`".to_owned(),
                "out" => "write `DataOutPort`".to_owned(),
                other => suggest::advice(other, "kinds", &KINDS),
            };
            sink.warning("bad-port-type", message, kind.span, help);
        }
        Some(_) => {}
    }
    match said(&port.data_type) {
        None => missing(
            sink,
            &format!("the data type of the port `{name}`"),
            port.span,
            "add `type`",
        ),
        Some(kind) => scoped(sink, kind, &format!("the data type of the port `{name}`")),
    }
}

fn interfaces(sink: &mut Sink<'_>, port: &ServicePort) {
    for interface in &port.interfaces {
        let name = interface.name.as_ref().map_or("", Text::trimmed);
        let what = format!("the interface `{name}`");
        match said(&interface.direction) {
            None => missing(
                sink,
                &format!("the direction of {what}"),
                interface.span,
                "write `Provided` or `Required`",
            ),
            Some(direction) => {
                let word = direction.trimmed();
                let known = ["Provided", "Required"];
                if !known.iter().any(|known| known.eq_ignore_ascii_case(word)) {
                    let message = format!("`{word}` is no direction of {what}");
                    let help = suggest::advice(word, "directions", &known);
                    sink.warning("bad-interface-direction", message, direction.span, help);
                }
            }
        }
        match said(&interface.interface_type) {
            None => missing(
                sink,
                &format!("the type of {what}"),
                interface.span,
                "add `type`",
            ),
            Some(kind) => scoped(sink, kind, &format!("the type of {what}")),
        }
    }
}

/// `Module::Name`, `Name`, or a repository id, with the types of a sequence in angle brackets.
fn scoped(sink: &mut Sink<'_>, kind: &Text, what: &str) {
    let text = kind.trimmed();
    let inner = text.strip_prefix("IDL:").map_or(text, |rest| {
        rest.rsplit_once(':').map_or(rest, |(name, _)| name)
    });
    let normal = inner.replace('/', "::");
    let name = normal.strip_prefix("::").unwrap_or(&normal);
    let is_name = |part: &str| {
        let part = part.trim();
        part.starts_with(|c: char| c.is_alphabetic() || c == '_')
            && part
                .chars()
                .all(|c| c.is_alphanumeric() || "_<>, ".contains(c))
    };
    if !name.split("::").all(is_name) {
        let message = format!("{what} is `{text}`, which is no name in an IDL file");
        let help = "write `Module::Name`, such as `RTC::TimedLong`";
        sink.warning("bad-type-name", message, kind.span, help);
    }
}
