//! Checks of a spec that need nothing else: those of `rts_schemas`, and the limits of what is stored.

use std::collections::BTreeMap;

use rts_controller_api::ProblemError;
use rts_plan::{check_orders, cycle_pointer};
use rts_schemas::diagnostic::Finding;
use rts_schemas::suggest;
use rts_schemas::system::{ComponentSpec, PortRef, SystemSpec};

/// Most components of a system.
const MAX_COMPONENTS: usize = 10_000;
/// Most connectors of a system.
const MAX_CONNECTORS: usize = 50_000;
/// Longest name of a connector, parameter or configuration set, in bytes: two instances, two ports, and what joins them.
pub const MAX_NAME: usize = 4 * rts_schemas::names::NAME_LIMIT + 16;
/// Longest value of a parameter or property, in bytes.
pub const MAX_VALUE: usize = 1024 * 1024;
/// Faults that are listed.
pub const MAX_FAULTS: usize = 100;

/// Every fault of a spec, at most [`MAX_FAULTS`].
pub fn spec(name: &str, spec: &SystemSpec) -> Vec<ProblemError> {
    let mut faults = Faults::default();
    system(&mut faults, name, spec);
    if !faults.list.is_empty() {
        // What is too large is not looked through.
        return faults.list;
    }
    for (pointer, finding) in rts_schemas::check::spec_by_pointer(spec) {
        faults.add(of_finding(&pointer, finding));
    }
    components(&mut faults, spec);
    connectors(&mut faults, spec);
    faults.list
}

fn of_finding(pointer: &str, finding: Finding) -> ProblemError {
    ProblemError {
        pointer: format!("/spec{pointer}"),
        code: finding.code,
        detail: finding.message,
        help: finding.help,
    }
}

/// Every cycle among hard orders, with all its members.
pub fn orders(spec: &SystemSpec) -> Vec<ProblemError> {
    let cycles = check_orders(spec).into_iter();
    cycles
        .take(MAX_FAULTS)
        .map(|cycle| ProblemError {
            pointer: format!("/spec{}", cycle_pointer(spec, &cycle)),
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

/// A key as a part of a JSON pointer (RFC 6901).
pub fn escaped(key: &str) -> String {
    key.replace('~', "~0").replace('/', "~1")
}

/// Faults, at most [`MAX_FAULTS`].
#[derive(Default)]
pub struct Faults {
    /// The list.
    pub list: Vec<ProblemError>,
}

impl Faults {
    /// Adds one.
    pub fn add(&mut self, fault: ProblemError) {
        if self.list.len() < MAX_FAULTS {
            self.list.push(fault);
        }
    }

    /// Adds one with advice.
    pub fn advise(&mut self, pointer: String, code: &str, detail: String, help: String) {
        self.add(ProblemError {
            pointer,
            code: code.to_owned(),
            detail,
            help: Some(help),
        });
    }

    fn push(&mut self, pointer: String, code: &str, detail: String) {
        self.add(ProblemError {
            pointer,
            code: code.to_owned(),
            detail,
            help: None,
        });
    }
}

fn system(faults: &mut Faults, name: &str, spec: &SystemSpec) {
    if spec.name != name {
        let detail = format!(
            "the spec is of system {:?}, the path of {name:?}",
            spec.name
        );
        let help = "write the same name in both".to_owned();
        faults.advise("/spec/name".to_owned(), "name-mismatch", detail, help);
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
    for (index, component) in spec.components.iter().enumerate() {
        let at = format!("/spec/components/{index}/configuration");
        for (set, values) in &component.configuration.sets {
            let fits = |(key, value): (&String, &String)| {
                value.len() <= MAX_VALUE && key.len() <= MAX_NAME && set.len() <= MAX_NAME
            };
            if !values.iter().all(fits) {
                let detail = format!("a parameter of {} is too long", component.instance);
                faults.push(at.clone(), "too-long", detail);
            }
        }
    }
}

fn connectors(faults: &mut Faults, spec: &SystemSpec) {
    let by_name: BTreeMap<&str, &ComponentSpec> = spec
        .components
        .iter()
        .map(|c| (c.instance.as_str(), c))
        .collect();
    for (index, connector) in spec.connectors.iter().enumerate() {
        let at = format!("/spec/connectors/{index}");
        let name = &connector.name;
        connector_name(faults, format!("{at}/name"), name);
        for (end, port) in [("source", &connector.source), ("target", &connector.target)] {
            if let Some(component) = by_name.get(port.instance.as_str()) {
                declared(faults, component, &format!("{at}/{end}"), name, port);
            }
        }
        if connector.properties.values().any(|v| v.len() > MAX_VALUE) {
            let detail = format!("a property of connector {name} is too long");
            faults.push(format!("{at}/properties"), "too-long", detail);
        }
    }
}

/// It becomes a part of a path and of log lines.
fn connector_name(faults: &mut Faults, pointer: String, name: &str) {
    if name.is_empty() || name.len() > MAX_NAME {
        let detail = format!(
            "a connector's name has 1 to {MAX_NAME} bytes, not {}",
            name.len()
        );
        faults.push(pointer, "bad-name", detail);
    } else if name.chars().any(|c| c.is_control() || c == '/') {
        let detail = format!("the connector name {name:?} has a slash or control character");
        faults.push(pointer, "bad-name", detail);
    }
}

/// A component that declares ports must declare this one.
fn declared(faults: &mut Faults, component: &ComponentSpec, at: &str, name: &str, port: &PortRef) {
    let ports: Vec<&str> = component.ports.iter().map(|p| p.name.as_str()).collect();
    if !ports.is_empty() && !ports.contains(&port.port.as_str()) {
        let detail = format!(
            "connector `{name}` ends at `{port}`, and `{}` declares no port `{}`",
            port.instance, port.port
        );
        let help = suggest::advice(&port.port, "declared", &ports);
        faults.advise(format!("{at}/port"), "unknown-port", detail, help);
    }
}
