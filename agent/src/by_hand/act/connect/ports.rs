//! Whether two ports can be connected.

use rts_http::problem::Problem;
use rts_plan::observed::{ComponentObserved, PortObserved};
use rts_schemas::system::{Direction, PortKind, PortRef};

use super::super::subject::advised;
use super::Wish;

/// Refuses ports that are not there, that have the wrong direction, or whose types differ.
pub(super) fn check(
    source: &ComponentObserved,
    target: &ComponentObserved,
    wish: &Wish,
) -> Result<(), Problem> {
    let out = find(source, &wish.source)?;
    let into = find(target, &wish.target)?;
    for (end, port) in [(&wish.source, out), (&wish.target, into)] {
        if port.kind == PortKind::Service {
            return Err(Problem::invalid(
                "unsupported",
                format!("{end} is a service port, which managers of this version cannot connect"),
            ));
        }
    }
    let is_in = |port: &PortObserved| port.direction == Some(Direction::In);
    match (is_in(out), is_in(into)) {
        (false, true) => {}
        (true, false) => {
            return Err(wrong_direction(format!(
                "{0} is an in-port and {1} an out-port: a connector goes the other way round: rtsctl connect {1} {0}",
                wish.source, wish.target
            )));
        }
        (true, true) => return Err(same(source, &wish.source, "in", Direction::Out)),
        (false, false) => return Err(same(target, &wish.target, "out", Direction::In)),
    }
    if out.data_type != into.data_type {
        return Err(Problem::invalid(
            "data-type-differs",
            format!(
                "{} sends {}, but {} takes {}",
                wish.source, out.data_type, wish.target, into.data_type
            ),
        ));
    }
    Ok(())
}

fn find<'a>(component: &'a ComponentObserved, end: &PortRef) -> Result<&'a PortObserved, Problem> {
    let mut ports = component.ports.iter();
    ports.find(|port| port.name == end.port).ok_or_else(|| {
        let names: Vec<&str> = component.ports.iter().map(|p| p.name.as_str()).collect();
        Problem::not_found(format!(
            "{} has no port {}; {}",
            end.instance,
            end.port,
            advised(&end.port, "ports", names)
        ))
    })
}

/// One end is of the same direction as the other: names those of the right one.
fn same(component: &ComponentObserved, end: &PortRef, is: &str, wanted: Direction) -> Problem {
    let right = component.ports.iter();
    let right = right.filter(|port| port.direction == Some(wanted));
    let names: Vec<&str> = right.map(|port| port.name.as_str()).collect();
    let other = if is == "in" { "out" } else { "in" };
    let right = if names.is_empty() {
        format!("{} has no {other}-port", end.instance)
    } else {
        format!("{other}-ports of {}: {}", end.instance, names.join(", "))
    };
    wrong_direction(format!(
        "{end} is an {is}-port: a connector goes from an out-port to an in-port; {right}"
    ))
}

fn wrong_direction(detail: String) -> Problem {
    Problem::invalid("wrong-direction", detail)
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn component(instance: &str, ports: &Value) -> ComponentObserved {
        serde_json::from_value(json!({
            "instance": instance, "type": "T", "incarnation": "i", "recreateHash": "", "state": "Inactive",
            "restarts": 0, "created": "", "configuration": {}, "executionKind": "periodic", "rate": 1.0,
            "executions": 0, "ports": ports, "connectors": []
        }))
        .unwrap()
    }

    #[test]
    fn types_must_be_equal_and_ports_for_data() {
        let port = |name: &str, direction: &str, data_type: &str| json!({"name": name, "kind": "data", "direction": direction, "dataType": data_type});
        let source = component("A", &json!([port("out", "out", "IDL:X:1.0")]));
        let service = json!({"name": "svc", "kind": "service", "dataType": ""});
        let inputs = json!([
            port("same", "in", "IDL:X:1.0"),
            port("other", "in", "IDL:Y:1.0"),
            service
        ]);
        let target = component("B", &inputs);
        let check = |name: &str| {
            let end = |instance: &str, port: &str| PortRef {
                instance: instance.to_owned(),
                port: port.to_owned(),
            };
            let wish = Wish {
                source: end("A", "out"),
                target: end("B", name),
                name: None,
                properties: Default::default(),
            };
            check(&source, &target, &wish).map_err(|problem| problem.to_string())
        };
        assert_eq!(check("same"), Ok(()));
        insta::assert_snapshot!(check("other").unwrap_err(), @"A.out sends IDL:X:1.0, but B.other takes IDL:Y:1.0");
        insta::assert_snapshot!(check("svc").unwrap_err(), @"B.svc is a service port, which managers of this version cannot connect");
    }
}
