//! Orders that can never be obeyed, at the lines that make them.

use std::collections::HashSet;

use rts_plan::check_orders;
use rts_plan::plan::PlanError;
use rts_schemas::diagnostic::{Finding, Report};
use rts_schemas::rts_profile::ReadProfile;
use rts_schemas::rts_profile::model::{Condition, Target};
use rts_schemas::span::Span;
use rts_schemas::suggest;
use rts_schemas::system::SystemSpec;

/// Cycles that are told; each is found at its lines.
const LIMIT: usize = 100;

/// Every cycle, with all its members and the places of the conditions between them.
pub(super) fn cycles(read: &ReadProfile, spec: &SystemSpec) -> Report {
    let cycles = check_orders(spec).into_iter().take(LIMIT);
    Report {
        findings: cycles.map(|cycle| finding(read, &cycle)).collect(),
    }
}

fn finding(read: &ReadProfile, cycle: &PlanError) -> Finding {
    let PlanError::Cycle { order, members, .. } = cycle;
    let names: HashSet<&str> = members.iter().map(String::as_str).collect();
    let lists: Vec<&str> = order.split(" and ").collect();
    let orders = read.profile.orders.iter();
    let conditions = orders
        .filter(|o| lists.contains(&o.kind.element()))
        .flat_map(|o| &o.conditions);
    let made: Vec<(&str, Span, String)> = conditions.filter_map(|c| part(c, &names)).collect();
    let place = made.first().and_then(|(_, span, _)| read.place(*span));
    let lines = made.iter().map(|(target, span, before)| {
        let line = read.place(*span).map_or(0, |place| place.line);
        format!("`{target}` waits for {before} (line {line})")
    });
    let lines: Vec<String> = lines.collect();
    let told = suggest::listed(lines.iter().map(String::as_str));
    let advice = "remove one of these Preceding conditions, or change a sequence number";
    let help = match told.is_empty() {
        true => advice.to_owned(),
        false => format!("{told}: {advice}"),
    };
    Finding::error("order-cycle", cycle.to_string())
        .at(place)
        .help(help)
}

/// A condition by which a member of the cycle waits for members: who, where, and for whom.
fn part<'a>(condition: &'a Condition, members: &HashSet<&str>) -> Option<(&'a str, Span, String)> {
    let name = |target: &'a Target| Some(target.instance_name.as_ref()?.trimmed());
    let target = name(condition.target.as_ref()?).filter(|name| members.contains(name))?;
    let preceding = condition.preceding.as_ref()?;
    let before = preceding.components.iter().filter_map(name);
    let before: Vec<String> = before
        .filter(|name| members.contains(name))
        .map(|name| format!("`{name}`"))
        .collect();
    let first = preceding.components.first()?;
    let span = first.instance_name.as_ref().map_or(first.span, |t| t.span);
    (!before.is_empty()).then(|| (target, span, before.join(" and ")))
}
