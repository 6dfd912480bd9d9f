//! What stands in for a module: made of a shape, not of a library.

use std::collections::BTreeSet;

use rts_manager_api::control::{PortInfo, StandInShape};
use rts_runtime::abi::ALL_ACTIONS;
use rts_schemas::stand_in::recorded;

use super::list::MAX_ITEMS;
use super::{Code, Direction, Execution, Module, Port};

/// Rate in Hz of stand-ins for which nothing else is said.
const DEFAULT_RATE: f64 = 20.0;

impl Module {
    /// A module for one stand-in, or what is wrong with its shape.
    pub fn stand_in(type_name: &str, shape: &StandInShape) -> Result<Self, String> {
        let most = shape.ports.len().max(shape.parameters.len());
        if most > MAX_ITEMS {
            return Err(format!(
                "at most {MAX_ITEMS} ports and parameters are allowed"
            ));
        }
        let mut names = BTreeSet::new();
        let twice = shape.ports.iter().find(|port| !names.insert(&port.name));
        if let Some(port) = twice {
            return Err(format!("its port `{}` is there twice", port.name));
        }
        let connectable = |info: &PortInfo| port(info).ok_or_else(|| info.clone());
        for (name, values) in &shape.data {
            let own = shape.ports.iter().find(|port| port.name == *name);
            let Some(own) = own.filter(|port| port.direction == "out") else {
                return Err(format!(
                    "there is recorded data for `{name}`, which is none of its out-ports"
                ));
            };
            if let Some((problem, help)) = recorded::problem(&own.data_type, values) {
                return Err(format!("recorded data of `{name}`: {problem}; {help}"));
            }
        }
        let mut module = Self {
            type_name: type_name.to_owned(),
            path: String::new(),
            ports: Vec::new(),
            listed: Vec::new(),
            parameters: shape.parameters.clone(),
            facts: Default::default(),
            limits: Default::default(),
            execution: Execution::Periodic,
            activity_type: "",
            max_instances: 0,
            actions: ALL_ACTIONS,
            idl: String::new(),
            default_rate: DEFAULT_RATE,
            code: Code::StandIn(shape.clone()),
            texts: Default::default(),
        };
        for port in shape.ports.iter().map(connectable) {
            match port {
                Ok(port) => module.ports.push(port),
                Err(info) => module.listed.push(info),
            }
        }
        Ok(module)
    }
}

/// A data port whose direction and type are known.
fn port(info: &PortInfo) -> Option<Port> {
    let direction = match info.direction.as_str() {
        "in" => Direction::In,
        "out" => Direction::Out,
        _ => return None,
    };
    (!info.data_type.is_empty()).then(|| Port {
        name: info.name.clone(),
        data_type: info.data_type.clone(),
        direction,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(ports: &[(&str, &str, &str)]) -> StandInShape {
        let port = |(name, direction, data_type): &(&str, &str, &str)| PortInfo {
            name: (*name).to_owned(),
            direction: (*direction).to_owned(),
            data_type: (*data_type).to_owned(),
        };
        StandInShape {
            ports: ports.iter().map(port).collect(),
            ..StandInShape::default()
        }
    }

    #[test]
    fn what_is_not_known_is_listed_after_what_can_be_connected() {
        let ports = [
            ("svc", "service", ""),
            ("what", "undetermined", "T"),
            ("untyped", "in", ""),
            ("out", "out", "T"),
        ];
        let module = Module::stand_in("X", &shape(&ports)).unwrap();
        let names = |ports: &[PortInfo]| ports.iter().map(|p| p.name.clone()).collect::<Vec<_>>();
        assert_eq!(module.ports.len(), 1);
        assert_eq!(
            names(&module.port_infos()),
            ["out", "svc", "what", "untyped"]
        );
    }

    #[test]
    fn recorded_data_that_cannot_be_played_is_refused() {
        let mut shape = shape(&[("in", "in", "T"), ("out", "out", "IDL:RTC/TimedOctet:1.0")]);
        let mut problem = |port: &str, value: &str| {
            shape.data = [(port.to_owned(), vec![vec![value.to_owned()]])].into();
            Module::stand_in("X", &shape).err()
        };
        let no_port = "there is recorded data for `in`, which is none of its out-ports";
        assert_eq!(problem("in", "1").as_deref(), Some(no_port));
        let wrong = "recorded data of `out`: value 1 of 1, `256`, is no TimedOctet; expected: a whole number from 0 to 255";
        assert_eq!(problem("out", "256").as_deref(), Some(wrong));
        assert_eq!(problem("out", "255"), None);
    }

    #[test]
    fn a_port_that_is_there_twice_is_refused() {
        let ports = [("a", "in", "T"), ("a", "out", "T")];
        let problem = Module::stand_in("X", &shape(&ports)).unwrap_err();
        assert_eq!(problem, "its port `a` is there twice");
    }
}
