//! Execution contexts that components share: all on one manager, and of one kind and rate.

use std::collections::BTreeMap;

use super::placed::{place, process};
use super::spec::Pointed;
use crate::diagnostic::{Finding, Report};
use crate::rts_profile::Places;
use crate::system::{ComponentSpec, SystemSpec};
use crate::yaml_type::Words;

/// Most findings.
const LIMIT: usize = 500;

/// What is wrong with them, each with its JSON pointer. One finding for each component that does not fit the first of its
/// execution context that says something.
pub(super) fn by_pointer(spec: &SystemSpec) -> Vec<Pointed> {
    let mut shared: BTreeMap<&str, Vec<(usize, &ComponentSpec)>> = BTreeMap::new();
    for (index, component) in spec.components.iter().enumerate() {
        if let Some(name) = &component.execution_context.name {
            shared.entry(name).or_default().push((index, component));
        }
    }
    let mut found: Vec<(usize, Pointed)> = Vec::new();
    for (name, members) in &shared {
        found.extend(rates(name, members));
        found.extend(kinds(name, members));
        found.extend(processes(name, members));
    }
    found.sort_by_key(|(index, _)| *index);
    found.truncate(LIMIT);
    found.into_iter().map(|(_, pointed)| pointed).collect()
}

type Found = (usize, Pointed);
type Member<'a> = (usize, &'a ComponentSpec);

fn rates(name: &str, members: &[Member<'_>]) -> Vec<Found> {
    let says = |(index, component): &Member<'_>| {
        let rate = component.execution_context.rate?;
        Some((*index, component.instance.clone(), rate))
    };
    let mut said = members.iter().filter_map(says);
    let Some((_, first, rate)) = said.next() else {
        return Vec::new();
    };
    let other = said.filter(|(_, _, other)| *other != rate);
    let told = other.map(|(index, instance, other)| {
        let message = format!(
            "`{first}` and `{instance}` share the execution context `{name}`, but run at {rate} Hz and at {other} Hz"
        );
        let help = "give all of them one rate, in the profile or as `executionContext: { rate: … }` in an overlay";
        let finding = Finding::error("execution-context-mismatch", message).help(help);
        (index, (format!("/components/{index}/executionContext/rate"), finding))
    });
    told.collect()
}

fn kinds(name: &str, members: &[Member<'_>]) -> Vec<Found> {
    let mut all = members.iter();
    let Some((_, first)) = all.next() else {
        return Vec::new();
    };
    let kind = first.execution_context.kind;
    let other = all.filter(|(_, other)| other.execution_context.kind != kind);
    let told = other.map(|(index, other)| {
        let message = format!(
            "`{}` and `{}` share the execution context `{name}`, but one is {} and the other {}",
            first.instance,
            other.instance,
            kind.word(),
            other.execution_context.kind.word()
        );
        let help = "give all of them one kind, in the profile or as `executionContext: { kind: … }` in an overlay";
        let finding = Finding::error("execution-context-mismatch", message).help(help);
        (*index, (format!("/components/{index}/executionContext/kind"), finding))
    });
    told.collect()
}

/// Where nobody knows yet which node one goes to, the plan decides.
fn processes(name: &str, members: &[Member<'_>]) -> Vec<Found> {
    let mut all = members.iter();
    let Some((_, first)) = all.next() else {
        return Vec::new();
    };
    let apart = |(_, other): &&Member<'_>| {
        let (one, two) = (process(first), process(other));
        let nodes =
            matches!((one.0, two.0), (Some(one), Some(two)) if !one.eq_ignore_ascii_case(two));
        nodes || (one.1, one.2) != (two.1, two.2)
    };
    let told = all.filter(apart).map(|(index, other)| {
        let message = format!(
            "`{}` and `{}` share the execution context `{name}`, which needs one process: {} is {}, {} is {}",
            first.instance,
            other.instance,
            first.instance,
            place(first),
            other.instance,
            place(other)
        );
        let help = "give both the same manager and node, or each its own execution context";
        let finding = Finding::error("execution-context-apart", message).help(help);
        (*index, (format!("/components/{index}/executionContext/name"), finding))
    });
    told.collect()
}

/// The same at their places.
pub(super) fn contexts(spec: &SystemSpec, places: &Places) -> Report {
    let findings = by_pointer(spec).into_iter();
    let placed = |(pointer, finding): Pointed| finding.at(places.find(&pointer).cloned());
    Report {
        findings: findings.map(placed).collect(),
    }
}
