//! A system that came without its file, such as over the API: what must hold for any of them.

use std::collections::HashSet;

use crate::diagnostic::{Finding, Report};
use crate::names;
use crate::suggest;
use crate::system::{ComponentSpec, Condition, Orders, SystemSpec, WaitFor};

/// All problems of a system; they have no place.
pub fn spec(spec: &SystemSpec) -> Report {
    let mut report = Report::default();
    if !names::is_dns_label(&spec.name) {
        let message = format!("`{}` cannot name a system", spec.name);
        report.push(
            Finding::error("bad-system-name", message)
                .help("a name has 1 to 63 of `a-z`, `0-9` and `-`"),
        );
    }
    let mut instances: HashSet<&str> = HashSet::new();
    for component in &spec.components {
        self::component(component, &mut report);
        if !instances.insert(&component.instance) {
            let message = format!(
                "two components have the instance name `{}`",
                component.instance
            );
            report
                .push(Finding::error("duplicate-instance", message).help("give each its own name"));
        }
    }
    let mut known: Vec<&str> = instances.into_iter().collect();
    known.sort_unstable();
    let mut connectors: HashSet<&str> = HashSet::new();
    for connector in &spec.connectors {
        if !connectors.insert(&connector.name) {
            let message = format!("two connectors have the name `{}`", connector.name);
            report.push(
                Finding::error("duplicate-connector", message).help("give each its own name"),
            );
        }
        for end in [&connector.source, &connector.target] {
            exists(
                &end.instance,
                &format!("connector `{}`", connector.name),
                &known,
                &mut report,
            );
            if let Some(fault) = names::name_fault(&end.port) {
                let message = format!(
                    "a port of connector `{}` cannot be used: {fault}",
                    connector.name
                );
                report.push(Finding::error("bad-name", message));
            }
        }
    }
    for condition in all(&spec.orders) {
        exists(&condition.target, "an order", &known, &mut report);
        if let Some(WaitFor::Preceding { components, .. }) = &condition.wait {
            for name in components {
                exists(name, "an order", &known, &mut report);
            }
        }
    }
    report
}

fn component(component: &ComponentSpec, report: &mut Report) {
    for (what, name) in [
        ("instance", &component.instance),
        ("type", &component.type_name),
    ] {
        if let Some(fault) = names::name_fault(name) {
            report.push(Finding::error(
                "bad-name",
                format!("the {what} name `{name}` cannot be used: {fault}"),
            ));
        }
    }
    if let Some(rate) = component.execution_context.rate
        && !(rate.is_finite() && rate > 0.0)
    {
        let message = format!(
            "the rate {rate} of `{}` is not a number of hertz above 0",
            component.instance
        );
        report.push(Finding::error("bad-number", message));
    }
    if let Some(manager) = &component.placement.manager
        && !names::is_manager_name(manager)
    {
        let message = format!(
            "`{manager}` cannot name the manager of `{}`",
            component.instance
        );
        report.push(Finding::error("bad-placement-value", message));
    }
}

fn exists(name: &str, owner: &str, known: &[&str], report: &mut Report) {
    if known.binary_search(&name).is_err() {
        let message =
            format!("{owner} names the component `{name}`, which the system does not have");
        report.push(
            Finding::error("unknown-instance", message).help(suggest::advice(
                name,
                "components",
                known,
            )),
        );
    }
}

fn all(orders: &Orders) -> impl Iterator<Item = &Condition> {
    let Orders {
        start_up,
        shut_down,
        activation,
        deactivation,
        resetting,
        initializing,
        finalizing,
    } = orders;
    [
        start_up,
        shut_down,
        activation,
        deactivation,
        resetting,
        initializing,
        finalizing,
    ]
    .into_iter()
    .flatten()
}
