//! Direction and data type of each port: what its RTC Profile says, else what it declares, else what the connectors at it
//! say.

use std::collections::{BTreeMap, BTreeSet};

use crate::system::{
    ComponentSpec, ConnectorSpec, Direction, PortKind, PortRef, PortSpec, SystemSpec,
};

/// The data ports of a system and the connectors at them.
#[derive(Debug, Default)]
pub struct Ends<'a> {
    /// In the order in which they count.
    declared: BTreeMap<Name<'a>, Vec<&'a PortSpec>>,
    /// By instance and port: connectors in the order of the system.
    at: BTreeMap<Name<'a>, Vec<At<'a>>>,
}

/// Instance and port.
type Name<'a> = (&'a str, &'a str);

/// A connector at a port.
#[derive(Debug, Clone, Copy)]
struct At<'a> {
    connector: &'a ConnectorSpec,
    /// The direction that the port has as this end.
    direction: Direction,
}

fn name(end: &PortRef) -> Name<'_> {
    (&end.instance, &end.port)
}

/// What its RTC Profile says goes before what its system says.
fn declared(component: &ComponentSpec) -> impl Iterator<Item = &PortSpec> {
    let profile = component.stand_in.profile.iter();
    profile.flat_map(|of| &of.ports).chain(&component.ports)
}

impl<'a> Ends<'a> {
    /// Of a system.
    pub fn of(spec: &'a SystemSpec) -> Self {
        let mut ends = Self::default();
        for component in &spec.components {
            for port in declared(component) {
                let name = (component.instance.as_str(), port.name.as_str());
                ends.declared.entry(name).or_default().push(port);
            }
        }
        for connector in &spec.connectors {
            let both = [
                (&connector.source, Direction::Out),
                (&connector.target, Direction::In),
            ];
            for (end, direction) in both {
                let at = ends.at.entry(name(end)).or_default();
                at.push(At {
                    connector,
                    direction,
                });
            }
        }
        ends
    }

    /// The ports of a component: those that it declares, then those that only connectors name.
    pub fn ports(&self, component: &'a ComponentSpec) -> Vec<PortSpec> {
        let instance = component.instance.as_str();
        let mut ports: Vec<PortSpec> = Vec::new();
        let mut names = BTreeSet::new();
        for port in declared(component).filter(|port| names.insert(port.name.as_str())) {
            ports.push(self.port(instance, &port.name, port.kind));
        }
        let own = self.at.range((instance, "")..);
        for ((_, port), at) in own.take_while(|((of, _), _)| *of == instance) {
            let kind = at.first().map_or(PortKind::Data, |at| at.connector.kind);
            if !names.contains(port) {
                ports.push(self.port(instance, port, kind));
            }
        }
        ports
    }

    fn port(&self, instance: &'a str, port: &'a str, kind: PortKind) -> PortSpec {
        let name = (instance, port);
        let data = kind == PortKind::Data;
        PortSpec {
            name: port.to_owned(),
            kind,
            direction: data.then(|| self.direction(name)).flatten(),
            data_type: data.then(|| self.data_type(name)).flatten(),
        }
    }

    /// What it declares, else what all connectors at it agree on.
    fn direction(&self, name: Name<'a>) -> Option<Direction> {
        let declared = self.declared_at(name).find_map(|port| port.direction);
        declared.or_else(|| {
            let mut at = self.data_at(name).map(|at| at.direction);
            let first = at.next()?;
            at.all(|other| other == first).then_some(first)
        })
    }

    /// What it declares, else what the first connector at it says, else what is known of the port at the other end.
    fn data_type(&self, name: Name<'a>) -> Option<String> {
        let peers = || self.data_at(name).map(At::peer);
        let known = self.own_type(name).or_else(|| self.type_at(name));
        let known = known.or_else(|| peers().find_map(|peer| self.own_type(peer)));
        let known = known.or_else(|| peers().find_map(|peer| self.type_at(peer)));
        known.map(str::to_owned)
    }

    fn own_type(&self, name: Name<'a>) -> Option<&'a str> {
        self.declared_at(name)
            .find_map(|port| port.data_type.as_deref())
    }

    fn declared_at(&self, name: Name<'a>) -> impl Iterator<Item = &'a PortSpec> {
        self.declared.get(&name).into_iter().flatten().copied()
    }

    fn type_at(&self, name: Name<'a>) -> Option<&'a str> {
        let mut at = self.data_at(name);
        at.find_map(|at| at.connector.data_type.as_deref())
    }

    fn data_at(&self, name: Name<'a>) -> impl Iterator<Item = At<'a>> {
        let at = self.at.get(&name).into_iter().flatten().copied();
        at.filter(|at| at.connector.kind == PortKind::Data)
    }

    /// What the connectors at a component's ports say that those are not taken for: one remark each.
    pub fn disagreements(&self, component: &'a ComponentSpec) -> Vec<String> {
        let mut remarks = Vec::new();
        let instance = component.instance.as_str();
        let own = self.at.range((instance, "")..);
        for (name, _) in own.take_while(|((of, _), _)| *of == instance) {
            let port = self.port(instance, name.1, PortKind::Data);
            for at in self.data_at(*name) {
                let said = at.connector.data_type.as_ref();
                if let (Some(said), Some(taken)) = (said, &port.data_type)
                    && said != taken
                {
                    remarks.push(format!(
                        "connector {} says that {}.{} has the type {said}; its stand-in has {taken}",
                        at.connector.name, component.instance, port.name
                    ));
                }
            }
        }
        remarks
    }
}

impl<'a> At<'a> {
    fn peer(self) -> Name<'a> {
        name(match self.direction {
            Direction::Out => &self.connector.target,
            Direction::In => &self.connector.source,
        })
    }
}
