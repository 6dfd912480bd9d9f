//! A system that came without its file, such as over the API: what must hold for any of them.

use std::collections::HashSet;

use super::{composite, contexts, recorded};
use crate::diagnostic::{Finding, Report};
use crate::names;
use crate::placement;
use crate::suggest;
use crate::system::{ComponentSpec, Condition, PortKind, SystemSpec, WaitFor, rate_problem};

/// Most findings of one system: nobody reads more, and each costs its time.
const LIMIT: usize = 500;

/// What a name may be.
const NAMES: &str = "names have 1 to 128 bytes, no `/` and no control character";

/// A problem and the JSON pointer into the system to what it speaks of.
pub type Pointed = (String, Finding);

/// All problems of a system; they have no place.
pub fn spec(spec: &SystemSpec) -> Report {
    let findings = spec_by_pointer(spec).into_iter();
    Report {
        findings: findings.map(|(_, finding)| finding).collect(),
    }
}

/// All problems of a system, at most 500, each with its JSON pointer (`/components/0/instance`).
pub fn spec_by_pointer(spec: &SystemSpec) -> Vec<Pointed> {
    let mut report = Pointers::default();
    if !names::is_dns_label(&spec.name) {
        let message = format!("`{}` cannot name a system", spec.name);
        let finding = Finding::error("bad-system-name", message);
        report.push(
            "/name",
            finding.help("a name has 1 to 63 of `a-z`, `0-9` and `-`"),
        );
    }
    let mut instances: HashSet<&str> = HashSet::new();
    for (index, component) in spec.components.iter().enumerate() {
        let at = format!("/components/{index}");
        self::component(component, &at, &mut report);
        let instance = component.instance.as_str();
        if !instances.insert(instance) {
            let message = format!("two components have the instance name `{instance}`");
            let finding = Finding::error("duplicate-instance", message);
            report.push(
                format!("{at}/instance"),
                finding.help("give each its own name"),
            );
        }
    }
    let mut known: Vec<&str> = instances.into_iter().collect();
    known.sort_unstable();
    let found = recorded::by_pointer(spec).into_iter();
    let found = found.chain(contexts::by_pointer(spec));
    for (pointer, finding) in found.chain(composite::by_pointer(spec)) {
        report.push(pointer, finding);
    }
    connectors(spec, &known, &mut report);
    for (order, conditions) in spec.orders.by_name() {
        for (index, condition) in conditions.iter().enumerate() {
            let at = format!("/orders/{order}/{index}");
            self::condition(condition, &at, &known, &mut report);
        }
    }
    report.list
}

#[derive(Default)]
struct Pointers {
    list: Vec<Pointed>,
}

impl Pointers {
    fn is_full(&self) -> bool {
        self.list.len() >= LIMIT
    }

    fn push(&mut self, pointer: impl Into<String>, finding: Finding) {
        if !self.is_full() {
            self.list.push((pointer.into(), finding));
        }
    }

    fn exists(&mut self, name: &str, owner: &str, known: &[&str], pointer: impl Into<String>) {
        if known.binary_search(&name).is_ok() || self.is_full() {
            return;
        }
        let message =
            format!("{owner} names the component `{name}`, which the system does not have");
        let help = suggest::advice(name, "components", known);
        self.push(
            pointer,
            Finding::error("unknown-instance", message).help(help),
        );
    }
}

fn component(component: &ComponentSpec, at: &str, report: &mut Pointers) {
    for (what, name, fault) in [
        (
            "instance",
            &component.instance,
            names::instance_name_problem(&component.instance),
        ),
        (
            "type",
            &component.type_name,
            names::name_fault(&component.type_name).map(str::to_owned),
        ),
    ] {
        if let Some(fault) = fault {
            let message = format!("the {what} name `{name}` cannot be used: {fault}");
            let finding = Finding::error("bad-name", message).help(NAMES);
            report.push(format!("{at}/{what}"), finding);
        }
    }
    for (index, port) in component.ports.iter().enumerate() {
        if let Some(fault) = names::name_fault(&port.name) {
            let (port, owner) = (&port.name, &component.instance);
            let message = format!("the port name `{port}` of `{owner}` cannot be used: {fault}");
            let pointer = format!("{at}/ports/{index}/name");
            report.push(pointer, Finding::error("bad-name", message).help(NAMES));
        }
    }
    if let Some(rate) = component.execution_context.rate
        && let Some(problem) = rate_problem(rate)
    {
        let message = format!(
            "the rate {rate} of `{}` cannot be used: {problem}",
            component.instance
        );
        let pointer = format!("{at}/executionContext/rate");
        let finding = Finding::error("bad-number", message);
        report.push(
            pointer,
            finding.help("a rate is in hertz, such as `1000.0`"),
        );
    }
    if let Some(manager) = &component.placement.manager
        && let Some(problem) = names::manager_name_problem(manager)
    {
        let message = format!(
            "`{manager}` cannot name the manager of `{}`: {problem}",
            component.instance
        );
        let pointer = format!("{at}/placement/manager");
        let help = "choose another name, such as `main`";
        let finding = Finding::error("bad-placement-value", message);
        report.push(pointer, finding.help(help));
    }
    settings(component, at, report);
}

/// What a profile or overlay could not say holds for nobody else either.
fn settings(component: &ComponentSpec, at: &str, report: &mut Pointers) {
    for (key, value) in placement::settings(component) {
        // A manager's name has its own check.
        if key == "manager" {
            continue;
        }
        if let Err(fault) = placement::set(&mut component.clone(), &key, &value) {
            let path: Vec<&str> = placement::parts_of(&key);
            let message = format!("component `{}`: {}", component.instance, fault.message);
            let finding = Finding { message, ..*fault };
            report.push(format!("{at}/{}", placement::pointer(&path)), finding);
        }
    }
}

fn connectors(spec: &SystemSpec, known: &[&str], report: &mut Pointers) {
    let mut seen: HashSet<&str> = HashSet::new();
    for (index, connector) in spec.connectors.iter().enumerate() {
        let at = format!("/connectors/{index}");
        let name = connector.name.as_str();
        if !seen.insert(name) {
            let message = format!("two connectors have the name `{name}`");
            let finding = Finding::error("duplicate-connector", message);
            report.push(format!("{at}/name"), finding.help("give each its own name"));
        }
        if let Some(fault) = names::connector_name_fault(name) {
            let message = format!("the connector name `{name}` cannot be used: {fault}");
            let finding = Finding::error("bad-name", message);
            let help = "a connector's name has no `/` and no control character";
            report.push(format!("{at}/name"), finding.help(help));
        }
        if connector.kind == PortKind::Data && connector.source == connector.target {
            let message = format!(
                "connector `{name}` joins `{}` with itself",
                connector.source
            );
            let finding = Finding::error("self-connector", message);
            let help = "name the port of another component as one of its ends";
            report.push(format!("{at}/target"), finding.help(help));
        }
        if connector.kind == PortKind::Data
            && let Err(faults) = crate::connector::read(&connector.properties)
        {
            for fault in faults {
                let pointer = format!("{at}/properties/{}", fault.property);
                let message = format!(
                    "`{}` of connector `{name}`: {}",
                    fault.property, fault.problem
                );
                let finding = Finding::error(fault.code, message);
                report.push(pointer, finding.help(fault.help));
            }
        }
        for (key, end) in [("source", &connector.source), ("target", &connector.target)] {
            let owner = format!("connector `{name}`");
            report.exists(&end.instance, &owner, known, format!("{at}/{key}/instance"));
            if let Some(fault) = names::name_fault(&end.port) {
                let message = format!("a port of connector `{name}` cannot be used: {fault}");
                let pointer = format!("{at}/{key}/port");
                report.push(pointer, Finding::error("bad-name", message).help(NAMES));
            }
        }
    }
}

fn condition(condition: &Condition, at: &str, known: &[&str], report: &mut Pointers) {
    let owner = "an order";
    report.exists(&condition.target, owner, known, format!("{at}/target"));
    if let Some(WaitFor::Preceding { components, .. }) = &condition.wait {
        for (index, name) in components.iter().enumerate() {
            let pointer = format!("{at}/wait/components/{index}");
            report.exists(name, owner, known, pointer);
        }
    }
}
