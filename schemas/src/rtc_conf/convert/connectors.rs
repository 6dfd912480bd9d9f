//! Connections: which ports, in which direction, with which properties.

use std::collections::{HashMap, HashSet};

use super::types::Declared;
use super::{Made, property, text};
use crate::diagnostic::{Finding, Place};
use crate::rtc_conf::entries::Conf;
use crate::rtc_conf::item::{Port, Preconnect};
use crate::rtc_conf::setup::{Component, Manager};
use crate::rts_profile::forms::{
    DataPortConnector, Profile, Property, ServicePortConnector, TargetPort,
};
use crate::rts_profile::unused_name;
use crate::system::Direction;

/// An end of a connection.
#[derive(Clone, Copy)]
pub(super) struct End<'a> {
    pub(super) component: &'a Component,
    pub(super) port: &'a str,
}

/// A connection between two components that are made.
pub(super) struct Connection<'a> {
    pub(super) source: End<'a>,
    pub(super) target: End<'a>,
    pub(super) is_service: bool,
    data_type: Option<String>,
    conf: &'a Conf,
    item: &'a Preconnect,
}

/// Most connections of a system.
const CONNECTIONS: usize = 2000;

impl Connection<'_> {
    /// Where it is said.
    pub(super) fn place(&self) -> Option<Place> {
        self.conf.place(self.item.span)
    }
}

/// A port that is connected, with one of its connections.
pub(super) type Connected<'c, 'a> = (&'a str, &'c Connection<'a>);

/// The ports that are connected, each once, by the instances that have them.
pub(super) fn ends<'c, 'a>(all: &'c [Connection<'a>]) -> HashMap<&'a str, Vec<Connected<'c, 'a>>> {
    let mut ends: HashMap<&str, Vec<Connected<'_, '_>>> = HashMap::new();
    let mut seen = HashSet::new();
    for connection in all {
        for end in [connection.source, connection.target] {
            let instance = end.component.instance.as_str();
            if seen.insert((instance, end.port)) {
                ends.entry(instance)
                    .or_default()
                    .push((end.port, connection));
            }
        }
    }
    ends
}

impl<'a> Made<'a> {
    /// The connections of all managers. Those that a profile cannot say are reported.
    pub(super) fn connections(&mut self) -> Vec<Connection<'a>> {
        let mut all = Vec::new();
        let setup = self.setup;
        for manager in &setup.managers {
            for item in &manager.view.preconnect {
                if item.peers.is_empty() {
                    self.open(manager, item);
                }
                for peer in &item.peers {
                    let ends = (
                        self.end(manager, item, &item.port),
                        self.end(manager, item, peer),
                    );
                    if let (Some(source), Some(target)) = ends {
                        let instance = &source.component.instance;
                        if *instance == target.component.instance && source.port == target.port {
                            self.looped(manager, item, source);
                        } else {
                            all.push(self.connection(manager, item, source, target));
                        }
                    }
                    if all.len() > CONNECTIONS {
                        let message = format!("there are more than {CONNECTIONS} connections");
                        let finding = Finding::error("too-large", message);
                        self.report.push(finding.help("is this the right file?"));
                        return all;
                    }
                }
            }
        }
        all
    }

    fn looped(&mut self, manager: &Manager, item: &Preconnect, end: End<'_>) {
        let (instance, port) = (&end.component.instance, end.port);
        let message = format!("the connection joins `{instance}.{port}` with itself");
        let help = "name the port of another component as one of its ends";
        let finding = Finding::error("self-connector", message);
        self.report
            .push(finding.at(manager.conf.place(item.span)).help(help));
    }

    fn end(&mut self, manager: &Manager, item: &'a Preconnect, port: &'a Port) -> Option<End<'a>> {
        let component = self.resolve(&port.instance);
        if component.is_none() {
            let place = manager.conf.place(item.span);
            self.unknown(place, &port.instance, "the connection");
        }
        Some(End {
            component: component?,
            port: &port.port,
        })
    }

    /// A port that is connected with something that is no component: a topic of ROS.
    fn open(&mut self, manager: &Manager, item: &Preconnect) {
        let (instance, port) = (&item.port.instance, &item.port.port);
        let message = format!("`{instance}.{port}` is connected with no port of a component");
        let interface = item
            .properties
            .iter()
            .find(|(key, _)| key == "interface_type");
        let help = match interface {
            Some((_, kind)) => format!(
                "a profile cannot say a connection by `{kind}` to the outside: it is left out"
            ),
            None => "name the other port: `?port=B0.in`; the connection is left out".to_owned(),
        };
        let finding = Finding::warning("conf-open-connector", message);
        self.report
            .push(finding.at(manager.conf.place(item.span)).help(help));
    }

    /// A data connection runs from the out-port, where that is known.
    fn connection(
        &self,
        manager: &'a Manager,
        item: &'a Preconnect,
        source: End<'a>,
        target: End<'a>,
    ) -> Connection<'a> {
        let declared = |end: End<'_>| self.types.port(&end.component.type_name, end.port);
        let (from, to) = (declared(source), declared(target));
        let is_service =
            matches!(from, Some(Declared::Service)) || matches!(to, Some(Declared::Service));
        let of = |declared: Option<Declared>| match declared {
            Some(Declared::Data(direction, data_type)) => (direction, data_type),
            _ => (None, None),
        };
        let ((from, from_type), (to, to_type)) = (of(from), of(to));
        let reversed =
            from == Some(Direction::In) || (from.is_none() && to == Some(Direction::Out));
        let (source, target) = match reversed && to != Some(Direction::In) {
            true => (target, source),
            false => (source, target),
        };
        Connection {
            source,
            target,
            is_service,
            data_type: from_type.or(to_type),
            conf: &manager.conf,
            item,
        }
    }

    /// Writes the connections into the profile.
    pub(super) fn connectors(
        &self,
        connections: &[Connection<'_>],
        ids: &HashMap<&str, String>,
        profile: &mut Profile,
    ) {
        let mut used = HashMap::new();
        for connection in connections {
            let name = format!("{}-{}", full(connection.source), full(connection.target));
            let name = unused_name(name, &mut used);
            let source = Some(Box::new(target_port(connection.source, ids)));
            let targets = vec![target_port(connection.target, ids)];
            if connection.is_service {
                profile.service_port_connectors.push(ServicePortConnector {
                    xsi_type: text("rtsExt:serviceport_connector_ext"),
                    connector_id: text(name.as_str()),
                    name: text(name),
                    source,
                    targets,
                    properties: properties(connection.item, &[]),
                    ..ServicePortConnector::default()
                });
                continue;
            }
            let given = |key: &str, usual: &str| {
                let mut all = connection.item.properties.iter().rev();
                let found = all.find(|(name, _)| name == key);
                text(found.map_or(usual, |(_, value)| value.as_str()))
            };
            profile.data_port_connectors.push(DataPortConnector {
                xsi_type: text("rtsExt:dataport_connector_ext"),
                connector_id: text(name.as_str()),
                name: text(name),
                data_type: text(connection.data_type.as_deref().unwrap_or("Any")),
                interface_type: given(ATTRIBUTES[0], "corba_cdr"),
                dataflow_type: given(ATTRIBUTES[1], "push"),
                subscription_type: given(ATTRIBUTES[2], "flush"),
                source,
                targets,
                properties: properties(connection.item, &ATTRIBUTES),
                ..DataPortConnector::default()
            });
        }
    }
}

/// Properties of a connection that a profile has attributes for.
const ATTRIBUTES: [&str; 3] = ["interface_type", "dataflow_type", "subscription_type"];

fn properties(item: &Preconnect, attributes: &[&str]) -> Vec<Property> {
    let others = item
        .properties
        .iter()
        .filter(|(key, _)| !attributes.contains(&key.as_str()));
    others
        .map(|(key, value)| property(&format!("dataport.{key}"), value))
        .collect()
}

fn full(end: End<'_>) -> String {
    format!("{}.{}", end.component.instance, end.port)
}

fn target_port(end: End<'_>, ids: &HashMap<&str, String>) -> TargetPort {
    TargetPort {
        xsi_type: text("rtsExt:target_port_ext"),
        component_id: ids
            .get(end.component.instance.as_str())
            .and_then(|id| text(id.as_str())),
        instance_name: text(end.component.instance.as_str()),
        port_name: text(full(end)),
        ..TargetPort::default()
    }
}
