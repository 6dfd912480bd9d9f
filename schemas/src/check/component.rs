//! Components: names, ports, configuration, execution context.

use std::collections::{HashMap, HashSet};

use super::Check;
use crate::names;
use crate::placement::parse_bool;
use crate::rts_profile::model::{Component, property_value};
use crate::rts_profile::{self, TYPE_KEY, composite, is_pseudo_set, parse_rate};
use crate::span::Text;
use crate::suggest;
use crate::system::{ExecutionKind, MAX_RATE, MIN_RATE};

pub(super) fn component<'a>(check: &mut Check<'a>, component: &'a Component) {
    let name = check.required(
        &component.instance_name,
        "instanceName",
        "a component",
        component.span,
    );
    let owner = name.map_or_else(
        || "a component".to_owned(),
        |name| format!("component `{}`", name.trimmed()),
    );
    if let Some(name) = name {
        valid_name(check, name, &owner);
    }
    type_name(check, component, &owner);
    ports(check, component, &owner);
    configuration(check, component, &owner);
    execution_context(check, component, &owner);
    if let Some(required) = &component.is_required
        && parse_bool(&required.value).is_none()
    {
        let message = format!("`{}` of {owner} is not a truth value", required.trimmed());
        check.error(
            "bad-boolean",
            message,
            required.span,
            "write `true` or `false`",
        );
    }
    if let Some(kind) = component
        .composite_type
        .as_ref()
        .filter(|kind| !is_plain(kind.trimmed()) && composite::kind(component).is_none())
    {
        let message = format!(
            "{owner} is a composite of the kind `{}`, which is not known; it is treated as a plain component",
            kind.trimmed()
        );
        check.warning(
            "composite-component",
            message,
            kind.span,
            "kinds: PeriodicECShared, PeriodicStateShared, Grouping; its participants are started on their own",
        );
    }
}

fn is_plain(composite_type: &str) -> bool {
    composite_type.is_empty() || composite_type.eq_ignore_ascii_case("none")
}

fn valid_name(check: &mut Check<'_>, name: &Text, owner: &str) {
    if let Some(fault) = names::instance_name_problem(name.trimmed()) {
        let help = "names have 1 to 128 bytes, no `/`, no control character and no dot in front";
        check.error(
            "bad-name",
            format!("the name of {owner} cannot be used: {fault}"),
            name.span,
            help,
        );
    }
}

fn type_name<'a>(check: &mut Check<'a>, component: &'a Component, owner: &str) {
    if let Some(own) = property_value(&component.properties, TYPE_KEY) {
        if let Some(fault) = names::name_fault(own.trimmed()) {
            let message = format!("the type of {owner} cannot be used: {fault}");
            let help = "names have 1 to 128 bytes, no `/` and no control character";
            check.error("bad-name", message, own.span, help);
        }
        return;
    }
    let Some(id) = check.required(&component.id, "id", owner, component.span) else {
        return;
    };
    let fault = match rts_profile::type_name(component) {
        None => Some("it does not say the type"),
        Some(name) => names::name_fault(&name),
    };
    if let Some(fault) = fault {
        let message = format!(
            "the id `{}` of {owner} cannot be used: {fault}",
            id.trimmed()
        );
        check.error(
            "bad-component-id",
            message,
            id.span,
            "write `RTC:vendor:category:type:version`",
        );
    }
}

fn ports<'a>(check: &mut Check<'a>, component: &'a Component, owner: &str) {
    let mut seen = HashSet::new();
    for (_, port) in component.ports() {
        let Some(name) =
            check.required(&port.name, "name", &format!("a port of {owner}"), port.span)
        else {
            continue;
        };
        let bare = component.bare_port(&name.value);
        if let Some(other) = foreign_prefix(check, component, bare) {
            let message =
                format!("the port `{bare}` of {owner} has the name of `{other}` before it");
            let help = format!("write the port's bare name, or move it to `{other}`");
            check.error("instance-prefix", message, name.span, help);
        } else if let Some(fault) = names::name_fault(bare) {
            let message = format!("the port name `{bare}` of {owner} cannot be used: {fault}");
            check.error(
                "bad-name",
                message,
                name.span,
                "names have 1 to 128 bytes, no `/` and no control character",
            );
        } else if seen.contains(bare) {
            let message = format!("{owner} declares the port `{bare}` twice");
            check.warning(
                "duplicate-port",
                message,
                name.span,
                "the first counts; remove the other",
            );
        }
        seen.insert(bare);
    }
}

/// The other component whose instance name stands before a port name.
pub(super) fn foreign_prefix<'a>(
    check: &Check<'a>,
    component: &Component,
    port: &str,
) -> Option<&'a str> {
    let own = component.instance_name.as_ref().map_or("", Text::trimmed);
    // No instance name is longer.
    port.match_indices('.')
        .take_while(|(dot, _)| *dot <= names::NAME_LIMIT)
        // The ports of a composite are those of others.
        .filter(|_| composite::kind(component).is_none())
        .filter_map(|(dot, _)| check.read.component(&port[..dot])?.instance_name.as_ref())
        .map(Text::trimmed)
        .find(|other| *other != own)
}

fn configuration<'a>(check: &mut Check<'a>, component: &'a Component, owner: &str) {
    let mut sets: Vec<&str> = Vec::new();
    for set in &component.configuration_sets {
        let what = format!("a configuration set of {owner}");
        let Some(id) = check.required(&set.id, "id", &what, set.span) else {
            continue;
        };
        if is_pseudo_set(id.trimmed()) {
            continue;
        }
        sets.push(id.trimmed());
        let what = format!("a parameter in set `{}` of {owner}", id.trimmed());
        let mut seen = HashSet::new();
        for parameter in &set.data {
            let Some(name) = check.required(&parameter.name, "name", &what, parameter.span) else {
                continue;
            };
            if seen.contains(name.trimmed()) {
                let message = format!(
                    "set `{}` of {owner} has the parameter `{}` twice",
                    id.trimmed(),
                    name.trimmed()
                );
                check.warning(
                    "duplicate-parameter",
                    message,
                    name.span,
                    "the last one counts; remove the others",
                );
            }
            seen.insert(name.trimmed());
        }
    }
    if let Some(active) = &component.active_configuration_set
        && !active.trimmed().is_empty()
        && !sets.contains(&active.trimmed())
        && !(sets.is_empty() && active.trimmed() == "default")
    {
        let message = format!(
            "the active configuration set `{}` of {owner} is not in the profile",
            active.trimmed()
        );
        let help = if sets.is_empty() {
            "the profile has no set of it; the component must know the set itself".to_owned()
        } else {
            suggest::advice(active.trimmed(), "sets", &sets)
        };
        check.warning("unknown-configuration-set", message, active.span, help);
    }
}

fn execution_context(check: &mut Check<'_>, component: &Component, owner: &str) {
    for context in &component.execution_contexts {
        if let Some(rate) = &context.rate
            && parse_rate(&rate.value).is_none()
        {
            let message = format!(
                "the rate `{}` of {owner} is not a number of hertz from {MIN_RATE} to {MAX_RATE}",
                rate.trimmed()
            );
            check.error(
                "bad-number",
                message,
                rate.span,
                "write a number such as `1000.0`",
            );
        }
    }
    if let Some(kind) = component
        .execution_contexts
        .first()
        .and_then(|c| c.kind.as_ref())
        && rts_profile::execution_kind(kind.trimmed()) == ExecutionKind::Other
    {
        let message = format!(
            "the execution context of {owner} is of the kind `{}`: it runs only when it is ticked",
            kind.trimmed()
        );
        let help = "write `PERIODIC` and a rate, or `EVENT_DRIVEN`, or drive it with `rtsctl tick`";
        check.warning("unsupported-execution-kind", message, kind.span, help);
    }
    if let [_, second, ..] = component.execution_contexts.as_slice() {
        let message = format!("{owner} has more than one execution context");
        check.warning(
            "extra-execution-context",
            message,
            second.span,
            "the first one is used",
        );
    }
}

pub(super) fn duplicates(check: &mut Check<'_>) {
    let mut first: HashMap<&str, usize> = HashMap::new();
    let read = check.read;
    for name in read
        .profile
        .components
        .iter()
        .filter_map(|c| c.instance_name.as_ref())
    {
        let line = read.place(name.span).map_or(0, |place| place.line);
        if let Some(before) = first.get(name.trimmed()) {
            let message = format!("two components have the instance name `{}`", name.trimmed());
            let help = if *before > 0 {
                format!("the other one is in line {before}; give each its own name")
            } else {
                "give each its own name".to_owned()
            };
            check.error("duplicate-instance", message, name.span, help);
        } else {
            first.insert(name.trimmed(), line);
        }
    }
}
