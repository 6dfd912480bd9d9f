//! Does a system fit what its modules say of themselves? What would fail once processes run is refused before.

use std::collections::BTreeMap;

use rts_agent_api::messages::{ModuleDescription, ParameterLimits};
use rts_controller_api::ProblemError;
use rts_plan::observed::PortObserved;
use rts_schemas::check::{Limits, Refusal};
use rts_schemas::suggest;
use rts_schemas::system::{ComponentSpec, ConnectorSpec, Direction, PortKind, PortRef, SystemSpec};

use super::check::{Faults, escaped};

/// Instance → what its module says. A component that is not here says nothing and may have anything.
pub type Descriptions<'a> = BTreeMap<&'a str, &'a ModuleDescription>;

/// Every port, direction, data type and parameter that the modules do not know.
pub fn check(spec: &SystemSpec, modules: &Descriptions<'_>) -> Vec<ProblemError> {
    let mut faults = Faults::default();
    for (index, component) in spec.components.iter().enumerate() {
        if let Some(module) = modules.get(component.instance.as_str()) {
            let at = format!("/spec/components/{index}/configuration/sets");
            parameters(&mut faults, component, module, &at);
        }
    }
    for (index, connector) in spec.connectors.iter().enumerate() {
        connect(&mut faults, connector, modules, index);
    }
    faults.list
}

fn parameters(
    faults: &mut Faults,
    component: &ComponentSpec,
    module: &ModuleDescription,
    at: &str,
) {
    let known: Vec<&str> = module.parameters.keys().map(String::as_str).collect();
    for (set, values) in &component.configuration.sets {
        for (name, value) in values {
            let limits = module.limits.get(name);
            if let Some(problem) = limits.and_then(|limits| refusal(limits, value)) {
                let pointer = format!("{at}/{}/{}", escaped(set), escaped(name));
                let detail = format!(
                    "`{value}` of the parameter `{name}` of component `{}` is refused by its module: {problem}",
                    component.instance
                );
                let help = format!(
                    "correct the value, or rebuild the module of {}",
                    component.type_name
                );
                faults.advise(pointer, problem.code, detail, help);
            }
        }
        for name in values
            .keys()
            .filter(|name| !module.parameters.contains_key(*name))
        {
            let pointer = format!("{at}/{}/{}", escaped(set), escaped(name));
            let detail = format!(
                "component `{}` (type {}) has no parameter `{name}`",
                component.instance, component.type_name
            );
            let help = advice(name, "parameters", &known);
            faults.advise(pointer, "unknown-parameter", detail, help);
        }
    }
}

/// Why a module will refuse a value. Limits that cannot be read refuse nothing here: the module will not load either.
fn refusal(limits: &ParameterLimits, value: &str) -> Option<Refusal> {
    let limits = Limits::read(&limits.value_type, &limits.constraint).ok()?;
    limits.problem(value)
}

fn connect(
    faults: &mut Faults,
    connector: &ConnectorSpec,
    modules: &Descriptions<'_>,
    index: usize,
) {
    let mut end = |end: &PortRef, key: &str, direction: Direction| {
        let module = modules.get(end.instance.as_str())?;
        let at = format!("/spec/connectors/{index}/{key}/port");
        port(faults, connector, module, end, direction, at)
    };
    let source = end(&connector.source, "source", Direction::Out);
    let target = end(&connector.target, "target", Direction::In);
    if let (Some(source), Some(target)) = (source, target)
        && source.data_type != target.data_type
    {
        let detail = format!(
            "`{}` has the type {}, `{}` has {}",
            connector.source, source.data_type, connector.target, target.data_type
        );
        let help = "connect ports of one type, or put a converter between them".to_owned();
        let pointer = format!("/spec/connectors/{index}");
        faults.advise(pointer, "data-type-mismatch", detail, help);
    }
}

/// The port at an end, when it can be that end.
fn port<'a>(
    faults: &mut Faults,
    connector: &ConnectorSpec,
    module: &'a ModuleDescription,
    end: &PortRef,
    direction: Direction,
    at: String,
) -> Option<&'a PortObserved> {
    let fits = |port: &&PortObserved| {
        port.kind == connector.kind
            && (port.kind == PortKind::Service || port.direction.is_none_or(|d| d == direction))
    };
    let usable: Vec<&str> = module
        .ports
        .iter()
        .filter(fits)
        .map(|p| p.name.as_str())
        .collect();
    let noun = match (connector.kind, direction) {
        (PortKind::Service, _) => "service ports",
        (PortKind::Data, Direction::In) => "in-ports",
        (PortKind::Data, Direction::Out) => "out-ports",
    };
    let help = || advice(&end.port, noun, &usable);
    let Some(port) = module.ports.iter().find(|port| port.name == end.port) else {
        let detail = format!("component `{}` has no port `{}`", end.instance, end.port);
        faults.advise(at, "unknown-port", detail, help());
        return None;
    };
    if port.kind != connector.kind {
        let detail = format!("`{end}` is none of the {noun} of its component");
        faults.advise(at, "port-kind-mismatch", detail, help());
        return None;
    }
    if !fits(&port) {
        let detail = match direction {
            Direction::Out => format!("`{end}` is an in-port; a connector begins at an out-port"),
            Direction::In => format!("`{end}` is an out-port; a connector ends at an in-port"),
        };
        faults.advise(at, "port-direction", detail, help());
        return None;
    }
    Some(port)
}

fn advice(word: &str, what: &str, known: &[&str]) -> String {
    if known.is_empty() {
        format!("it has no {what}")
    } else {
        suggest::advice(word, what, known)
    }
}
