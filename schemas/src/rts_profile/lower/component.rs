//! Components: ports, configuration, execution context and placement.

use std::collections::{BTreeMap, HashSet};
use std::net::IpAddr;

use super::TYPE_KEY;
use super::connector::{data_type_of, direction_of};
use super::managers::{Managers, endpoint};
use crate::diagnostic::Report;
use crate::names;
use crate::placement::{self, PREFIX, parse_bool};
use crate::rts_profile::ior::Endpoint;
use crate::rts_profile::model::{Component, Property, property_value};
use crate::rts_profile::{ReadProfile, composite};
use crate::span::Text;
use crate::system::{
    ComponentSpec, Configuration, ExecutionContextSpec, ExecutionKind, Placement, Policy, PortKind,
    PortSpec, rate_problem,
};
use crate::yaml_type::Faults;

pub(super) fn components(read: &ReadProfile, report: &mut Report) -> Vec<ComponentSpec> {
    let managers = Managers::of(&read.profile.components);
    let mut seen = HashSet::new();
    read.profile
        .components
        .iter()
        .filter_map(|component| {
            let instance = component.instance_name.as_ref()?.trimmed().to_owned();
            let type_name = type_name(component)?;
            // Nothing of a composite itself runs.
            composite::kind(component).is_none().then_some(())?;
            seen.insert(instance.clone()).then_some(())?;
            let endpoint = endpoint(component);
            let mut spec = ComponentSpec {
                instance,
                type_name,
                full_id: component
                    .id
                    .as_ref()
                    .map_or_else(String::new, |id| id.trimmed().to_owned()),
                required: required(component),
                ports: ports(component),
                configuration: configuration(component),
                execution_context: execution_context(component),
                placement: Placement {
                    host: host(component, endpoint.as_ref()),
                    manager: endpoint.and_then(|endpoint| managers.name(&endpoint)),
                    ..Placement::default()
                },
                policy: Policy::default(),
                ..ComponentSpec::default()
            };
            placement_keys(read, component, &mut spec, report);
            Some(spec)
        })
        .collect()
}

/// The type that a component says beside its id, else that in its id.
pub(crate) fn type_name(component: &Component) -> Option<String> {
    if let Some(own) = property_value(&component.properties, TYPE_KEY) {
        return Some(own.trimmed().to_owned());
    }
    let instance = component.instance_name.as_ref().map_or("", Text::trimmed);
    names::type_name(&component.id.as_ref()?.value, instance)
}

pub(super) fn required(component: &Component) -> bool {
    component
        .is_required
        .as_ref()
        .and_then(|text| parse_bool(&text.value))
        .unwrap_or(true)
}

fn ports(component: &Component) -> Vec<PortSpec> {
    let mut seen = HashSet::new();
    component
        .ports()
        .filter_map(|(kind, port)| {
            let name = component.bare_port(&port.name.as_ref()?.value).to_owned();
            seen.insert(name.clone()).then(|| PortSpec {
                name,
                kind,
                direction: direction_of(port).filter(|_| kind == PortKind::Data),
                data_type: data_type_of(port).filter(|_| kind == PortKind::Data),
            })
        })
        .collect()
}

fn configuration(component: &Component) -> Configuration {
    let mut sets: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
    for set in &component.configuration_sets {
        let Some(id) = set.id.as_ref().map(|id| id.trimmed()) else {
            continue;
        };
        if is_pseudo_set(id) {
            continue;
        }
        let values = sets.entry(id.to_owned()).or_default();
        for parameter in &set.data {
            if let Some(name) = &parameter.name {
                let value = parameter.value.as_ref().map_or("", |value| &value.value);
                values.insert(name.trimmed().to_owned(), value.to_owned());
            }
        }
    }
    let active = component
        .active_configuration_set
        .as_ref()
        .map(|text| text.trimmed().to_owned())
        .filter(|name| !name.is_empty());
    Configuration { active, sets }
}

/// `__widget__`, `__constraints__`, …: how an editor shows parameters, not their values.
pub(crate) fn is_pseudo_set(id: &str) -> bool {
    id.len() > 4 && id.starts_with("__") && id.ends_with("__")
}

/// The first context is the component's own; further ones belong to composites.
pub(super) fn execution_context(component: &Component) -> ExecutionContextSpec {
    let Some(context) = component.execution_contexts.first() else {
        return ExecutionContextSpec::default();
    };
    let mut spec = ExecutionContextSpec {
        kind: context
            .kind
            .as_ref()
            .map_or(ExecutionKind::Periodic, |kind| {
                execution_kind(kind.trimmed())
            }),
        rate: context
            .rate
            .as_ref()
            .and_then(|rate| parse_rate(&rate.value)),
        ..ExecutionContextSpec::default()
    };
    if let Some(id) = context.id.as_ref().filter(|id| !id.trimmed().is_empty()) {
        id.trimmed().clone_into(&mut spec.id);
    }
    spec
}

pub(crate) fn execution_kind(kind: &str) -> ExecutionKind {
    match kind.to_ascii_lowercase().replace(['_', '-'], "").as_str() {
        "" | "periodic" | "periodicexecutioncontext" => ExecutionKind::Periodic,
        "eventdriven" | "eventdrivenexecutioncontext" => ExecutionKind::EventDriven,
        _ => ExecutionKind::Other,
    }
}

/// Hz, in the range that this version runs.
pub(crate) fn parse_rate(text: &str) -> Option<f64> {
    let rate = text.trim().parse::<f64>().ok()?;
    rate_problem(rate).is_none().then_some(rate)
}

/// The name server's host, unless that is this machine's own; then the host where the process ran.
fn host(component: &Component, endpoint: Option<&Endpoint>) -> Option<String> {
    let uri = component
        .path_uri
        .as_ref()
        .and_then(|uri| uri_host(uri.trimmed()));
    match uri {
        Some(host) if !is_loopback(host) => Some(host.to_owned()),
        _ => endpoint
            .map(|endpoint| endpoint.host.clone())
            .filter(|host| !is_loopback(host)),
    }
}

/// Host of `host[:port]/path`; `file:` URIs and bare file names have none.
fn uri_host(uri: &str) -> Option<&str> {
    let (address, _) = uri.split_once('/')?;
    if let Some(v6) = address.strip_prefix('[') {
        return v6.split_once(']').map(|(host, _)| host);
    }
    let (host, port) = address.split_once(':').unwrap_or((address, "0"));
    let is_port = !port.is_empty() && port.bytes().all(|b| b.is_ascii_digit());
    let is_host = !host.is_empty()
        && host
            .chars()
            .all(|c| c.is_alphanumeric() || matches!(c, '-' | '_' | '.'));
    (is_port && is_host && host != "." && host != "..").then_some(host)
}

fn is_loopback(host: &str) -> bool {
    host.eq_ignore_ascii_case("localhost")
        || host
            .parse::<IpAddr>()
            .is_ok_and(|address| address.is_loopback() || address.is_unspecified())
}

fn placement_keys(
    read: &ReadProfile,
    component: &Component,
    spec: &mut ComponentSpec,
    report: &mut Report,
) {
    let keys = component.properties.iter().filter_map(|property| {
        let name = property.name.as_ref()?;
        let key = name.trimmed().strip_prefix(PREFIX)?;
        (name.trimmed() != TYPE_KEY).then_some((key, name, property))
    });
    let mut faults = Faults::default();
    let read_key = |(key, name, property): (&str, &Text, &Property)| {
        let key = Text::new(key, name.span);
        let value = property.value.clone();
        let value = value.unwrap_or_else(|| Text::new("", name.span));
        placement::read(&key, &value, &mut faults)
    };
    let said: Vec<_> = keys.filter_map(read_key).collect();
    placement::lay_all(spec, &said);
    for settings in &said {
        for (finding, span) in placement::later(settings) {
            faults.push(finding, span);
        }
    }
    report.extend(faults.into_report(|span| read.place(span)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_of_path_uris() {
        assert_eq!(uri_host("localhost/X0.rtc"), Some("localhost"));
        assert_eq!(
            uri_host("10.4.62.1:2809/a.host_cxt/X0.rtc"),
            Some("10.4.62.1")
        );
        assert_eq!(uri_host("[fe80::1]:2809/X0.rtc"), Some("fe80::1"));
        assert_eq!(uri_host("file://localhost/C:/X.xml"), None);
        assert_eq!(uri_host("samplertc.xml"), None);
        assert!(is_loopback("127.0.0.1") && is_loopback("LocalHost") && is_loopback("::1"));
    }

    #[test]
    fn rates() {
        assert_eq!(parse_rate(" 1000.0 "), Some(1000.0));
        assert_eq!(parse_rate("1000000"), Some(1e6));
        for bad in ["0", "-1", "NaN", "inf", "", "fast", "0.0001", "1e9"] {
            assert_eq!(parse_rate(bad), None);
        }
    }
}
