//! Connector objects: what is desired and what the owning end reports, joined by system and name.

use std::collections::{BTreeMap, BTreeSet};

use rts_controller_api::objects::{Connector, ConnectorStatus, ConnectorView, Kind, Metadata};
use rts_plan::desired::{PlacedConnector, SystemRef};
use rts_plan::observed::{BindingObserved, ConnectorObserved, ConnectorState};
use rts_plan::target;
use rts_schemas::system::PortKind;

use super::{Scene, object};

#[derive(Default)]
struct Both<'a> {
    desired: Option<(&'a SystemRef, &'a PlacedConnector)>,
    observed: Option<(&'a ConnectorObserved, bool, &'a str)>,
    /// The end at its in-port, when that is on another node: only that one's agent knows what came.
    far: Option<&'a BindingObserved>,
}

/// Ends of connectors at in-ports, by connector, incarnation of the component and in-port, with their nodes.
type Ends<'a> = BTreeMap<(&'a str, &'a str, &'a str), (&'a str, &'a BindingObserved)>;

/// A connector, and the node that it is shown with.
pub struct Found<'a> {
    /// That of its source.
    pub node: &'a str,
    /// It.
    pub connector: Connector,
}

/// The connectors whose sources are on these nodes, and whether they are of these nodes alone: desired where they are
/// observed. One that is not (it was moved, or made by hand) is to be shown with those of all nodes.
pub fn of_nodes<'a>(scene: &Scene<'a>, nodes: &BTreeSet<&'a str>) -> (Vec<Found<'a>>, bool) {
    let mut regular = true;
    let joined = joined(scene, nodes).into_iter();
    let found = joined.map(|((system, name), both)| {
        let source = both.desired.map(|(_, placed)| placed.source.node.as_str());
        let seen = both.observed.map(|(.., node)| node);
        regular &= source.is_some() && (seen.is_none() || seen == source);
        Found {
            node: source.or(seen).unwrap_or_default(),
            connector: connector(scene, system, name, &both),
        }
    });
    (found.collect(), regular)
}

/// What is desired and what is observed on these nodes, by system and name.
fn joined<'a>(
    scene: &Scene<'a>,
    nodes: &BTreeSet<&'a str>,
) -> BTreeMap<(&'a str, &'a str), Both<'a>> {
    let mut all: BTreeMap<(&str, &str), Both<'_>> = BTreeMap::new();
    let mut far = BTreeSet::new();
    for node in nodes {
        let spec = scene.world.placed.desired.nodes.get(*node);
        // The part of a system that goes has no components; what is there of its connectors is observed.
        let parts = spec.into_iter().flat_map(|spec| &spec.systems);
        for part in parts.filter(|p| !p.components.is_empty()) {
            for placed in part.connectors.iter().filter(|c| c.source.node == **node) {
                far.insert(placed.target.node.as_str());
                let both = all
                    .entry((&part.system.name, &placed.spec.name))
                    .or_default();
                both.desired = Some((&part.system, placed));
            }
        }
    }
    let ends = ends(scene, nodes.iter().copied().chain(far));
    for node in nodes {
        let Some((inventory, known)) = scene.inventories.get(node) else {
            continue;
        };
        for manager in &inventory.managers {
            let known = *known && manager.responsive;
            for component in &manager.components {
                let system = component.system.as_ref().map_or("", |s| s.name.as_str());
                for connector in &component.connectors {
                    let both = all.entry((system, &connector.name)).or_default();
                    both.observed = Some((connector, known, node));
                    let (name, port) = (connector.name.as_str(), connector.target.port.as_str());
                    let end = ends.get(&(name, connector.target_incarnation.as_str(), port));
                    both.far = end.filter(|(of, _)| of != node).map(|(_, end)| *end);
                }
            }
        }
    }
    all
}

fn ends<'a>(scene: &Scene<'a>, nodes: impl Iterator<Item = &'a str>) -> Ends<'a> {
    let mut ends = Ends::new();
    for node in nodes.collect::<BTreeSet<_>>() {
        let inventory = scene.inventories.get(node).map(|(inventory, _)| inventory);
        let managers = inventory.into_iter().flat_map(|all| &all.managers);
        for component in managers.flat_map(|m| &m.components) {
            for end in component.bindings.iter().filter(|end| end.connected) {
                let key = (
                    end.connector.as_str(),
                    component.incarnation.as_str(),
                    end.port.as_str(),
                );
                ends.insert(key, (node, end));
            }
        }
    }
    ends
}

fn connector(scene: &Scene<'_>, system: &str, name: &str, both: &Both<'_>) -> Connector {
    let mut status = match &both.observed {
        Some((found, known, _)) => as_observed(found, both.far, *known),
        None => ConnectorStatus {
            state: absent(scene, both).to_owned(),
            ..ConnectorStatus::default()
        },
    };
    let target = target::connector(name);
    let by_hand = scene.drifts.get(&(system, target.as_str()));
    status.drift = both.desired.is_none() && system.is_empty() || by_hand.is_some();
    status.drift_fields = by_hand.map_or_else(Vec::new, |drift| super::drift::fields(drift));
    if both.desired.is_some() && status.state != "Connected" {
        let reason = scene.reasons.get(&target);
        let reason = reason.map(|reason| reason.text.clone());
        let service = both
            .desired
            .is_some_and(|(_, placed)| placed.spec.kind == PortKind::Service);
        let undetermined = both
            .desired
            .and_then(|(_, placed)| placed.undetermined.as_ref());
        status.undetermined = undetermined.is_some();
        status.waiting_on = match (&both.observed, reason) {
            _ if undetermined.is_some() => undetermined.map(|why| format!("is not made: {why}")),
            _ if service => Some("service ports are connected by a later version".to_owned()),
            (None, None) => {
                Some("not connected yet: its steps have not been carried out".to_owned())
            }
            (None, Some(reason)) => Some(format!("not connected yet: {reason}")),
            (Some(_), reason) => reason,
        };
    }
    let record = scene.systems.get(system);
    let metadata = Metadata {
        name: name.to_owned(),
        uid: record.map_or_else(|| name.to_owned(), |r| format!("{}/{name}", r.uid)),
        generation: record.map_or(0, |r| r.generation),
        creation_timestamp: record.map(|r| r.created),
        ..Metadata::default()
    };
    object(Kind::Connector, metadata, view(system, both), status)
}

/// State of a connector that nobody reports.
fn absent(scene: &Scene<'_>, both: &Both<'_>) -> &'static str {
    let node = both.desired.map(|(_, placed)| placed.source.node.as_str());
    let known = node.and_then(|node| scene.inventories.get(node));
    if known.is_some_and(|(_, known)| *known) {
        "Disconnected"
    } else {
        "Unknown"
    }
}

fn as_observed(
    found: &ConnectorObserved,
    far: Option<&BindingObserved>,
    known: bool,
) -> ConnectorStatus {
    // Both nodes are asked at different times: no more has arrived than was sent.
    let arrived = far.map_or(0, |end| end.samples_received);
    let received = found.samples_received.max(arrived.min(found.samples_sent));
    let lost = far.map_or(0, |end| end.drops);
    let left = found.samples_sent.saturating_sub(received + found.drops);
    let state = match found.state {
        _ if !known => "Unknown",
        ConnectorState::Connected => "Connected",
        ConnectorState::Connecting => "Connecting",
        ConnectorState::Disconnected => "Disconnected",
    };
    ConnectorStatus {
        state: state.to_owned(),
        transport: found.transport.clone(),
        samples_sent: found.samples_sent,
        samples_received: received,
        bytes: found.bytes,
        drops: found.drops + lost.min(left),
        gaps: far.map_or(found.gaps, |end| end.gaps),
        rate: found.rate,
        latency: found.latency,
        waiting_on: None,
        undetermined: false,
        drift: false,
        drift_fields: Vec::new(),
    }
}

fn view(system: &str, both: &Both<'_>) -> ConnectorView {
    let (kind, data_type) = match &both.desired {
        Some((_, placed)) => (placed.spec.kind, placed.spec.data_type.clone()),
        None => (PortKind::Data, None),
    };
    let (source, target, properties) = match (&both.desired, &both.observed) {
        (Some((_, placed)), _) => {
            let spec = &placed.spec;
            (&spec.source, &spec.target, spec.properties.clone())
        }
        (None, Some((found, ..))) => (&found.source, &found.target, found.properties.clone()),
        // An entry is only made for one of the two.
        (None, None) => {
            return ConnectorView {
                system: system.to_owned(),
                kind,
                source: String::new(),
                target: String::new(),
                data_type,
                properties: BTreeMap::new(),
            };
        }
    };
    ConnectorView {
        system: system.to_owned(),
        kind,
        source: source.to_string(),
        target: target.to_string(),
        data_type,
        properties,
    }
}
