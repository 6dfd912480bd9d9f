//! Recorded data of stand-ins: for out-ports whose type can be played, and of values that fit.

use super::Library;
use super::spec::Pointed;
use crate::diagnostic::{Finding, Report};
use crate::rts_profile::{Places, escaped};
use crate::stand_in::{Ends, Shape, facts, recorded};
use crate::system::{ComponentSpec, StandIn, SystemSpec};

/// Most findings.
const LIMIT: usize = 500;

/// What is never a stand-in plays nothing.
fn plays(component: &ComponentSpec) -> bool {
    let said = &component.stand_in;
    !said.data.is_empty() && said.policy() != StandIn::Never
}

/// What is wrong with the recorded data of a system's components, each with its JSON pointer.
pub(super) fn by_pointer(spec: &SystemSpec) -> Vec<Pointed> {
    if !spec.components.iter().any(plays) {
        return Vec::new();
    }
    let ends = Ends::of(spec);
    let components = spec.components.iter().enumerate();
    let of = |(index, component): (usize, &ComponentSpec)| {
        let shape = Shape::of(component, &ends);
        let at = format!("/components/{index}/standIn/data");
        let pointed = |(port, message, help): (Option<&str>, String, String)| match port {
            Some(port) => {
                let message = format!("{}.{port}: {message}", component.instance);
                (format!("{at}/{}", escaped(port)), finding(message, help))
            }
            None => {
                let message = format!("{}: {message}", component.instance);
                (at.clone(), finding(message, help))
            }
        };
        let problems = recorded::problems(&shape).into_iter();
        problems.map(pointed).collect::<Vec<_>>()
    };
    let with = components.filter(|(_, component)| plays(component));
    with.flat_map(of).take(LIMIT).collect()
}

fn finding(message: String, help: String) -> Finding {
    Finding::error("bad-recorded-data", message).help(help)
}

/// The same at its places, with what a library says of the ports.
pub(super) fn recorded(spec: &SystemSpec, places: &Places, library: &Library) -> Report {
    let mut components = spec.components.iter();
    if components.all(|component| component.stand_in.data.is_empty()) {
        return Report::default();
    }
    let mut known = spec.clone();
    for component in &mut known.components {
        // As with `--stand-ins`.
        component.stand_in.when.get_or_insert(StandIn::Missing);
        component.stand_in.profile = facts(library, component);
    }
    let findings = by_pointer(&known).into_iter();
    let placed = |(pointer, finding): Pointed| finding.at(places.find(&pointer).cloned());
    Report {
        findings: findings.map(placed).collect(),
    }
}
