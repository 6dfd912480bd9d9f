//! A system with its overlays laid over it: hosts that are known, and connectors whose interface type does not reach.

use std::collections::HashMap;

use super::sink::Sink;
use super::system::System;
use crate::connector::{self, Distance};
use crate::diagnostic::{Finding, Place, Report, Severity};
use crate::rts_profile::ReadProfile;
use crate::rts_profile::model::{Connector, property_value};
use crate::span::Text;
use crate::suggest;
use crate::system::{ComponentSpec, SystemSpec};

/// Most unknown hosts that are told: nobody reads more.
const LIMIT: usize = 500;

/// What is wrong with where and how components run. `nodes`: all names of nodes and hosts, when they are known; an overlay may say
/// which host is which node.
pub fn placed(system: &System, nodes: Option<&[&str]>) -> Report {
    let (read, spec) = (&system.read, &system.spec);
    let mut sink = Sink::new(&read.source, Report::default());
    reach(&mut sink, read, spec);
    super::woken::woken(&mut sink, read, spec);
    let mut report = sink.report;
    if let Some(nodes) = nodes {
        report.extend(known_hosts(system, nodes));
    }
    report
}

/// Components that belong on a host that nobody knows, by the line that says so.
#[derive(Default)]
struct Lost<'a> {
    host: &'a str,
    first: &'a str,
    place: Option<Place>,
    required: bool,
    count: usize,
}

fn known_hosts(system: &System, nodes: &[&str]) -> Report {
    let mut known: Vec<&str> = nodes.to_vec();
    for (host, node) in &system.hosts {
        let has = |name: &str| nodes.iter().any(|known| known.eq_ignore_ascii_case(name));
        match (has(host), has(node)) {
            (true, false) => known.push(node),
            (false, true) => known.push(host),
            _ => {}
        }
    }
    let mut lost: Vec<Lost<'_>> = Vec::new();
    let mut seen: HashMap<(&str, Option<Place>), usize> = HashMap::new();
    for (index, component) in system.spec.components.iter().enumerate() {
        let placement = &component.placement;
        let Some(host) = placement.node.as_deref().or(placement.host.as_deref()) else {
            continue;
        };
        if known.iter().any(|known| known.eq_ignore_ascii_case(host)) {
            continue;
        }
        let place = place_of_host(system, index, host);
        let at = *seen.entry((host, place.clone())).or_insert(lost.len());
        if at == lost.len() {
            lost.push(Lost {
                host,
                first: &component.instance,
                place,
                ..Lost::default()
            });
        }
        lost[at].required |= component.required;
        lost[at].count += 1;
    }
    let findings = lost.into_iter().take(LIMIT);
    Report {
        findings: findings.map(|lost| lost.finding(nodes)).collect(),
    }
}

/// Where it is said that a component belongs on a host.
fn place_of_host(system: &System, index: usize, host: &str) -> Option<Place> {
    let placement = &system.spec.components[index].placement;
    let read = &system.read;
    let component = read.component(&system.spec.components[index].instance);
    let uri = component.and_then(|component| component.path_uri.as_ref());
    match uri.filter(|uri| placement.node.is_none() && uri.value.contains(host)) {
        Some(uri) => read.place(uri.span),
        None => {
            let pointer = format!("/components/{index}/placement/node");
            system.places.find(&pointer).cloned()
        }
    }
}

impl Lost<'_> {
    fn finding(self, nodes: &[&str]) -> Finding {
        let severity = match self.required {
            true => Severity::Error,
            false => Severity::Warning,
        };
        let first = self.first;
        let who = match self.count {
            1 if self.required => format!("the required component `{first}` belongs"),
            1 => format!("the component `{first}` belongs"),
            count => format!("the component `{first}` and {} more belong", count - 1),
        };
        let message = format!(
            "{who} on `{}`, which is no host or node that is known",
            self.host
        );
        Finding::new(severity, "unknown-host", message)
            .at(self.place)
            .help(suggest::advice(self.host, "known", nodes))
    }
}

/// Of a component: its node and its process there. Nobody knows yet which node a component without one goes to; those
/// go to one.
pub(super) fn process(spec: &ComponentSpec) -> (Option<&str>, &str, bool) {
    let placement = &spec.placement;
    let node = placement.node.as_deref().or(placement.host.as_deref());
    match (&placement.manager, placement.isolated) {
        (_, true) => (node, &spec.instance, true),
        (Some(manager), false) => (node, manager, false),
        (None, false) => (node, "main", false),
    }
}

/// Each connector's interface type reaches from one of its ends to the other.
fn reach(sink: &mut Sink<'_>, read: &ReadProfile, spec: &SystemSpec) {
    let components: HashMap<&str, &ComponentSpec> = spec
        .components
        .iter()
        .map(|c| (c.instance.as_str(), c))
        .collect();
    let lowered = read.profile.connectors.iter().filter(|c| is_lowered(c));
    for (connector, said) in spec.connectors.iter().zip(lowered) {
        let Ok(settings) = connector::read(&connector.properties) else {
            continue;
        };
        let end = |instance: &str| components.get(instance).copied();
        let (Some(source), Some(target)) = (
            end(&connector.source.instance),
            end(&connector.target.instance),
        ) else {
            continue;
        };
        let distance = match (process(source), process(target)) {
            (source, target) if source == target => Distance::Process,
            // One that is on no node yet may come to any.
            ((Some(source), ..), (Some(target), ..)) if source != target => Distance::Beyond,
            _ => Distance::Node,
        };
        let Some(fault) = settings.interface.out_of_reach(distance) else {
            continue;
        };
        let message = format!(
            "`{}` and `{}` are joined by the interface type `{}`, which needs both {}: {} is {}, {} is {}",
            connector.source,
            connector.target,
            fault.word,
            fault.needs,
            source.instance,
            place(source),
            target.instance,
            place(target)
        );
        let property = property_value(&said.properties, "dataport.interface_type");
        let text = property.or(said.interface_type.as_ref());
        let span = text.map_or(said.span, |text| text.span);
        sink.error(fault.code, message, span, fault.help);
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

pub(super) fn place(spec: &ComponentSpec) -> String {
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
