//! The port that a person means, and what it carries.

use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Component, Connector, Kind};
use rts_schemas::suggest::advice;
use rts_schemas::system::{Direction, PortKind};

use crate::commands::by_hand::find;
use crate::error::CliError;

/// A data port of a component that runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// Node.
    pub node: String,
    /// Instance name.
    pub instance: String,
    /// Bare name.
    pub name: String,
    /// IDL repository id of its samples.
    pub data_type: String,
    /// State of its component (`Active`).
    pub state: String,
}

impl Port {
    /// `Sine0.out`.
    pub fn shown(&self) -> String {
        format!("{}.{}", self.instance, self.name)
    }
}

/// What there is.
pub struct World {
    components: Vec<Component>,
    connectors: Vec<Connector>,
}

impl World {
    /// Asks the controller.
    pub async fn of(controller: &Controller) -> Result<Self, CliError> {
        let components = controller.list(Kind::Component).await;
        let connectors = controller.list(Kind::Connector).await;
        Ok(Self {
            components: components
                .map_err(CliError::request("list components"))?
                .items,
            connectors: connectors
                .map_err(CliError::request("list connectors"))?
                .items,
        })
    }

    /// The port that is meant, which must have this direction.
    pub fn port(&self, text: &str, direction: Direction) -> Result<Port, CliError> {
        let end = find::end(text, &self.components)?;
        let (status, shown) = (&end.component.status, end.port.to_string());
        let name = &end.port.instance;
        if status.ports.is_empty() {
            let state = &status.state;
            return Err(CliError::usage_help(
                format!("the ports of component/{name} are not known: it is {state}"),
                format!("`rtsctl describe component/{name}` tells why"),
            ));
        }
        let Some(port) = status.ports.iter().find(|p| p.name == end.port.port) else {
            let fitting = status
                .ports
                .iter()
                .filter(|p| p.direction == Some(direction));
            let known: Vec<_> = fitting.map(|p| p.name.as_str()).collect();
            let what = format!("its {}s", word(direction));
            return Err(CliError::usage_help(
                format!("component/{name} has no port {}", end.port.port),
                match known.as_slice() {
                    [] => format!("{what}: none"),
                    known => advice(&end.port.port, &what, known),
                },
            ));
        };
        if port.kind != PortKind::Data {
            return Err(CliError::usage(format!(
                "{shown} is a service port: no samples go over it"
            )));
        }
        if port.direction.is_some_and(|its| its != direction) {
            return Err(self.wrong_direction(&shown, direction));
        }
        Ok(Port {
            node: status.node.clone(),
            instance: name.clone(),
            name: end.port.port,
            data_type: port.data_type.clone(),
            state: status.state.clone(),
        })
    }

    fn wrong_direction(&self, shown: &str, wanted: Direction) -> CliError {
        let ends = self.connectors.iter().filter_map(|c| {
            let (source, target) = (&c.spec.source, &c.spec.target);
            match wanted {
                Direction::Out => (target == shown).then_some(source.as_str()),
                Direction::In => (source == shown).then_some(target.as_str()),
            }
        });
        let ends: Vec<_> = ends.collect();
        let (is, verb) = match wanted {
            Direction::Out => (
                Direction::In,
                "samples are looked at where they are written",
            ),
            Direction::In => (Direction::Out, "samples are written to where they are read"),
        };
        let ends = match ends.as_slice() {
            [] => "it is not connected".to_owned(),
            ends => format!("it is connected with {}", ends.join(", ")),
        };
        CliError::usage_help(
            format!("{shown} is an {}", word(is)),
            format!("{verb}, at an {}; {ends}", word(wanted)),
        )
    }
}

fn word(direction: Direction) -> &'static str {
    match direction {
        Direction::In => "in-port",
        Direction::Out => "out-port",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::{lists::typed, samples};
    use rts_plan::observed::PortObserved;

    fn world() -> World {
        let components: Vec<Component> =
            typed(Kind::Component, &samples::values(Kind::Component)).unwrap();
        let connectors = typed(Kind::Connector, &samples::values(Kind::Connector)).unwrap();
        let port = |name: &str, kind, direction| PortObserved {
            name: name.to_owned(),
            kind,
            direction,
            data_type: "IDL:RTC/TimedDouble:1.0".to_owned(),
        };
        let mut sine = components[0].clone();
        sine.status.ports = vec![
            port("out", PortKind::Data, Some(Direction::Out)),
            port("tuning", PortKind::Service, None),
        ];
        let mut filter = sine.clone();
        filter.metadata.name = "Filter0".to_owned();
        filter.status.ports = vec![
            port("in", PortKind::Data, Some(Direction::In)),
            port("out", PortKind::Data, Some(Direction::Out)),
        ];
        let mut printer = components[1].clone();
        printer.status.ports.clear();
        World {
            components: vec![sine, filter, printer],
            connectors,
        }
    }

    fn error(text: &str, direction: Direction) -> String {
        let error = world().port(text, direction).unwrap_err();
        assert_eq!(error.exit().code(), 2);
        format!("{}\n{}", error.line(), error.help().unwrap_or_default())
    }

    #[test]
    fn a_port_is_found_by_name_and_direction() {
        let port = world().port("Sine0.out", Direction::Out).unwrap();
        assert_eq!(port.shown(), "Sine0.out");
        assert_eq!(
            (port.node.as_str(), port.state.as_str()),
            ("local", "Active")
        );
    }

    #[test]
    fn what_is_no_such_port_says_what_would_be() {
        let all = [
            ("Sine0.ot", Direction::Out),
            ("Filter0.x", Direction::Out),
            ("Sine0.x", Direction::In),
            ("Filter0.in", Direction::Out),
            ("Sine0.out", Direction::In),
            ("Filter0.out", Direction::In),
            ("Sine0.tuning", Direction::Out),
            ("Printer0.in", Direction::In),
            ("Sin0.out", Direction::Out),
        ];
        let all: Vec<String> = all.map(|(text, way)| error(text, way)).into();
        insta::assert_snapshot!(all.join("\n\n"));
    }
}
