//! Checks of a spec that need nothing else.

use std::collections::{BTreeMap, BTreeSet};

use rts_controller_api::ProblemError;
use rts_plan::check_orders;
use rts_schemas::system::{ComponentSpec, PortRef, SystemSpec};

/// Most components of a system.
const MAX_COMPONENTS: usize = 10_000;
/// Most connectors of a system.
const MAX_CONNECTORS: usize = 50_000;
/// Longest name of an instance, type, port, connector, manager or set, in bytes.
const MAX_NAME: usize = 255;
/// Longest value of a parameter or property, in bytes.
const MAX_VALUE: usize = 1024 * 1024;
/// Faults that are listed.
const MAX_FAULTS: usize = 100;

/// Every fault of a spec, at most [`MAX_FAULTS`].
pub fn spec(name: &str, spec: &SystemSpec) -> Vec<ProblemError> {
    let mut faults = Faults::default();
    system(&mut faults, name, spec);
    components(&mut faults, spec);
    connectors(&mut faults, spec);
    faults.list
}

/// Every cycle among hard orders, with all its members.
pub fn orders(spec: &SystemSpec) -> Vec<ProblemError> {
    let cycles = check_orders(spec).into_iter();
    cycles
        .take(MAX_FAULTS)
        .map(|cycle| ProblemError {
            pointer: "/spec/orders".to_owned(),
            code: "order-cycle".to_owned(),
            detail: cycle.to_string(),
            help: Some(
                "remove one of these Preceding conditions, or change a sequence number".to_owned(),
            ),
        })
        .collect()
}

/// JSON pointer to a component.
pub fn pointer(spec: &SystemSpec, instance: &str) -> String {
    let index = spec.components.iter().position(|c| c.instance == instance);
    index.map_or_else(String::new, |i| format!("/spec/components/{i}"))
}

/// At most 63 of `a-z0-9-`, no hyphen at either end.
pub fn is_dns_label(name: &str) -> bool {
    let good = |c: u8| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'-';
    (1..=63).contains(&name.len())
        && name.bytes().all(good)
        && !name.starts_with('-')
        && !name.ends_with('-')
}

#[derive(Default)]
struct Faults {
    list: Vec<ProblemError>,
}

impl Faults {
    fn push(&mut self, pointer: String, code: &str, detail: String) {
        if self.list.len() < MAX_FAULTS {
            self.list.push(ProblemError {
                pointer,
                code: code.to_owned(),
                detail,
                help: None,
            });
        }
    }

    /// A name that must be there, be short, and have no control characters or slashes (it becomes a path).
    fn name(&mut self, pointer: String, what: &str, name: &str) {
        if name.is_empty() {
            self.push(pointer, "empty-name", format!("{what} has no name"));
        } else if name.len() > MAX_NAME {
            let detail = format!("{what} is longer than {MAX_NAME} bytes");
            self.push(pointer, "too-long", detail);
        } else if name.chars().any(|c| c.is_control() || c == '/') || name.starts_with('.') {
            let detail =
                format!("{what} {name:?} has a slash or control character, or begins with a dot");
            self.push(pointer, "bad-name", detail);
        }
    }
}

fn system(faults: &mut Faults, name: &str, spec: &SystemSpec) {
    if spec.name != name {
        let detail = format!(
            "the spec is of system {:?}, the path of {name:?}",
            spec.name
        );
        faults.push("/spec/name".to_owned(), "name-mismatch", detail);
    }
    if !is_dns_label(name) {
        let detail = format!("system name {name:?} is not a DNS label: 1 to 63 of a-z, 0-9 and -");
        faults.push("/spec/name".to_owned(), "bad-name", detail);
    }
    let limits = [
        ("components", spec.components.len(), MAX_COMPONENTS),
        ("connectors", spec.connectors.len(), MAX_CONNECTORS),
    ];
    for (what, count, limit) in limits {
        if count > limit {
            let detail = format!("{count} {what} are more than {limit}");
            faults.push(format!("/spec/{what}"), "too-many", detail);
        }
    }
}

fn components(faults: &mut Faults, spec: &SystemSpec) {
    let mut seen = BTreeSet::new();
    for (index, component) in spec.components.iter().enumerate() {
        let at = format!("/spec/components/{index}");
        let instance = &component.instance;
        faults.name(format!("{at}/instance"), "an instance", instance);
        faults.name(format!("{at}/type"), "a type", &component.type_name);
        if !seen.insert(instance) {
            let detail = format!("instance {instance} is there twice");
            faults.push(format!("{at}/instance"), "duplicate-instance", detail);
        }
        if let Some(rate) = component.execution_context.rate
            && !(rate.is_finite() && rate > 0.0)
        {
            let detail =
                format!("the rate of {instance} is {rate} Hz; it must be finite and above 0");
            faults.push(format!("{at}/executionContext/rate"), "bad-rate", detail);
        }
        for (set, values) in &component.configuration.sets {
            for (key, value) in values {
                if value.len() > MAX_VALUE || key.len() > MAX_NAME || set.len() > MAX_NAME {
                    let detail = format!("a parameter of {instance} is too long");
                    faults.push(format!("{at}/configuration"), "too-long", detail);
                }
            }
        }
    }
}

fn connectors(faults: &mut Faults, spec: &SystemSpec) {
    let mut seen = BTreeSet::new();
    let by_name: BTreeMap<&str, &ComponentSpec> = spec
        .components
        .iter()
        .map(|c| (c.instance.as_str(), c))
        .collect();
    for (index, connector) in spec.connectors.iter().enumerate() {
        let at = format!("/spec/connectors/{index}");
        let name = &connector.name;
        faults.name(format!("{at}/name"), "a connector", name);
        if !seen.insert(name) {
            let detail = format!("connector {name} is there twice");
            faults.push(format!("{at}/name"), "duplicate-connector", detail);
        }
        for (end, port) in [("source", &connector.source), ("target", &connector.target)] {
            if let Some(component) = by_name.get(port.instance.as_str()) {
                declared(faults, component, &format!("{at}/{end}"), name, port);
            } else {
                let detail = format!(
                    "connector {name} ends at {port}, and there is no {}",
                    port.instance
                );
                faults.push(format!("{at}/{end}"), "unknown-component", detail);
            }
        }
        if connector.properties.values().any(|v| v.len() > MAX_VALUE) {
            let detail = format!("a property of connector {name} is too long");
            faults.push(format!("{at}/properties"), "too-long", detail);
        }
    }
}

/// A component that declares ports of a kind must declare this one.
fn declared(faults: &mut Faults, component: &ComponentSpec, at: &str, name: &str, port: &PortRef) {
    faults.name(format!("{at}/port"), "a port", &port.port);
    let ports = &component.ports;
    if !ports.is_empty() && !ports.iter().any(|p| p.name == port.port) {
        let names: Vec<_> = ports.iter().map(|p| p.name.as_str()).collect();
        let detail = format!(
            "connector {name} ends at {port}, and {} has no such port (it has: {})",
            port.instance,
            names.join(", ")
        );
        faults.push(format!("{at}/port"), "unknown-port", detail);
    }
}
