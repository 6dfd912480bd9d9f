//! Orders that can never be obeyed, at the lines that make them, in the profile or in an overlay.

use std::collections::HashSet;

use rts_plan::plan::PlanError;
use rts_plan::{check_orders, cycle_pointer};
use rts_schemas::check::System;
use rts_schemas::diagnostic::{Finding, Place, Report};
use rts_schemas::suggest;
use rts_schemas::system::{Condition, WaitFor};

/// Cycles that are told; each is found at its lines.
const LIMIT: usize = 100;

/// Every cycle, with all its members and the places of the conditions between them.
pub(super) fn cycles(system: &System) -> Report {
    let cycles = check_orders(&system.spec).into_iter().take(LIMIT);
    Report {
        findings: cycles.map(|cycle| finding(system, &cycle)).collect(),
    }
}

fn finding(system: &System, cycle: &PlanError) -> Finding {
    let PlanError::Cycle { order, members, .. } = cycle;
    let names: HashSet<&str> = members.iter().map(String::as_str).collect();
    let place = system.places.find(&cycle_pointer(&system.spec, cycle));
    let spoken: Vec<&str> = order.split(" and ").collect();
    let mut told = Vec::new();
    for (key, list) in system.spec.orders.by_name() {
        if !spoken.iter().any(|spoken| spoken.eq_ignore_ascii_case(key)) {
            continue;
        }
        for (index, condition) in list.iter().enumerate() {
            if let Some(before) = before(condition, &names) {
                let at = system.places.find(&format!("/orders/{key}/{index}"));
                let line = at.map_or_else(String::new, |at| line(at, place));
                told.push(format!("`{}` waits for {before}{line}", condition.target));
            }
        }
    }
    let told = suggest::listed(told.iter().map(String::as_str));
    let advice = "remove one of these conditions, or change a sequence number";
    let help = match told.is_empty() {
        true => advice.to_owned(),
        false => format!("{told}: {advice}"),
    };
    Finding::error("order-cycle", cycle.to_string())
        .at(place.cloned())
        .help(help)
}

/// ` (line 3)`, with the file when it is another one than that of the finding.
fn line(at: &Place, of: Option<&Place>) -> String {
    match of.is_some_and(|of| of.file == at.file) {
        true => format!(" (line {})", at.line),
        false => format!(" ({}:{})", at.file, at.line),
    }
}

/// For which members of a cycle a member waits by this condition.
fn before(condition: &Condition, members: &HashSet<&str>) -> Option<String> {
    let Some(WaitFor::Preceding { components, .. }) = &condition.wait else {
        return None;
    };
    let named = components
        .iter()
        .filter(|name| members.contains(name.as_str()));
    let named: Vec<String> = named.map(|name| format!("`{name}`")).collect();
    let is_part = members.contains(condition.target.as_str()) && !named.is_empty();
    is_part.then(|| named.join(" and "))
}
