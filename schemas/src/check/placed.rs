//! A system with its overlays laid over it: hosts that are known, and connectors that need one process.

use std::collections::HashMap;

use super::sink::Sink;
use crate::diagnostic::{Report, Severity};
use crate::rts_profile::ReadProfile;
use crate::rts_profile::model::{Connector, property_value};
use crate::span::{Span, Text};
use crate::suggest;
use crate::system::{ComponentSpec, SystemSpec};

/// What is wrong with where components run. `hosts`: all names of hosts and nodes, when they are known.
pub fn placed(read: &ReadProfile, spec: &SystemSpec, hosts: Option<&[&str]>) -> Report {
    let mut sink = Sink::new(&read.source, Report::default());
    if let Some(hosts) = hosts {
        for component in &spec.components {
            known_host(&mut sink, read, component, hosts);
        }
    }
    one_process(&mut sink, read, spec);
    sink.report
}

fn known_host(sink: &mut Sink<'_>, read: &ReadProfile, spec: &ComponentSpec, hosts: &[&str]) {
    let placement = &spec.placement;
    let Some(host) = placement.node.as_deref().or(placement.host.as_deref()) else {
        return;
    };
    if hosts.iter().any(|known| known.eq_ignore_ascii_case(host)) || sink.is_full() {
        return;
    }
    let (severity, word) = match spec.required {
        true => (Severity::Error, "required component"),
        false => (Severity::Warning, "component"),
    };
    let message = format!(
        "the {word} `{}` belongs on `{host}`, which is no host or node that is known",
        spec.instance
    );
    let component = read.component(&spec.instance);
    let span = component.map_or_else(Span::default, |component| {
        let uri = component.path_uri.as_ref();
        let says = uri.filter(|uri| uri.value.contains(host));
        says.or(component.instance_name.as_ref())
            .map_or(component.span, |text| text.span)
    });
    let help = suggest::advice(host, "known", hosts);
    sink.say(severity, "unknown-host", message, span, help);
}

/// Of a component: its node and its process there. Nobody knows yet which node a component without one goes to; those
/// go to one.
fn process(spec: &ComponentSpec) -> (Option<&str>, &str, bool) {
    let placement = &spec.placement;
    let node = placement.node.as_deref().or(placement.host.as_deref());
    match (&placement.manager, placement.isolated) {
        (_, true) => (node, &spec.instance, true),
        (Some(manager), false) => (node, manager, false),
        (None, false) => (node, "main", false),
    }
}

fn one_process(sink: &mut Sink<'_>, read: &ReadProfile, spec: &SystemSpec) {
    let components: HashMap<&str, &ComponentSpec> = spec
        .components
        .iter()
        .map(|c| (c.instance.as_str(), c))
        .collect();
    let lowered = read.profile.connectors.iter().filter(|c| is_lowered(c));
    for (connector, said) in spec.connectors.iter().zip(lowered) {
        let interface = connector.properties.get("dataport.interface_type");
        if interface.is_none_or(|interface| interface != "direct") {
            continue;
        }
        let end = |instance: &str| components.get(instance).copied();
        let (Some(source), Some(target)) = (
            end(&connector.source.instance),
            end(&connector.target.instance),
        ) else {
            continue;
        };
        if process(source) == process(target) {
            continue;
        }
        let message = format!(
            "`{}` and `{}` are joined by the interface type `direct`, which needs one process: {} is {}, {} is {}",
            connector.source,
            connector.target,
            source.instance,
            place(source),
            target.instance,
            place(target)
        );
        let help = "give both the same manager and node, or choose the interface type `corba_cdr`";
        let property = property_value(&said.properties, "dataport.interface_type");
        let text = property.or(said.interface_type.as_ref());
        let span = text.map_or(said.span, |text| text.span);
        sink.error("direct-across-processes", message, span, help);
    }
}

/// True for a connector that has its counterpart in the one model.
fn is_lowered(connector: &Connector) -> bool {
    let ends = [&connector.source, &connector.target];
    let named = |text: &Option<Text>| text.is_some();
    ends.iter().all(|end| {
        end.as_ref()
            .is_some_and(|end| named(&end.instance_name) && named(&end.port_name))
    })
}

fn place(spec: &ComponentSpec) -> String {
    let (node, manager, isolated) = process(spec);
    let process = match isolated {
        true => "in a process of its own".to_owned(),
        false => format!("in manager `{manager}`"),
    };
    match node {
        Some(node) => format!("{process} on `{node}`"),
        None => process,
    }
}
