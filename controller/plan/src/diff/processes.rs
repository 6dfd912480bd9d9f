//! Processes: what becomes of them, and whom it interrupts.

use std::collections::BTreeMap;

use crate::alone::made_by_hand;
use crate::bring_up::Up;
use crate::decide::{Decisions, Stop};
use crate::index::{Facts, Seat};
use crate::plan::{Action, Change, Restart};
use crate::target;

pub(super) fn managers<'a>(decisions: &Decisions<'a>, up: &Up<'a>, changes: &mut Vec<Change>) {
    let mut push = |seat: &Seat<'a>, action, reason: &str| {
        changes.push(Change {
            action,
            target: target::manager(&seat.1),
            system: seat.1.system.as_ref().map(|s| s.name.clone()),
            reason: reason.to_owned(),
            fields: Vec::new(),
        });
    };
    for seat in up.starts.keys() {
        if !decisions.stops.contains_key(seat) {
            push(seat, Action::Add, "is not running");
        }
    }
    for (seat, stop) in &decisions.stops {
        let (action, reason) = stopped(stop);
        push(seat, action, reason);
    }
    for (seat, (stop, why)) in &decisions.stuck {
        let (action, reason) = stopped(stop);
        push(seat, action, &format!("{reason}; blocked: {why}"));
    }
}

fn stopped(stop: &Stop) -> (Action, &str) {
    match stop {
        Stop::Unwanted => (Action::Remove, "nothing is wanted in it any more"),
        Stop::Restart(reason) => (Action::Restart, reason),
    }
}

/// Processes and components that are interrupted though they go on to exist.
pub(crate) fn restarts<'a>(facts: &Facts<'a>, decisions: &Decisions<'a>) -> Vec<Restart> {
    let mut again: BTreeMap<Seat<'a>, (Vec<String>, String)> = BTreeMap::new();
    for (seat, stop) in &decisions.stops {
        if let Stop::Restart(reason) = stop {
            again.insert(seat.clone(), (Vec::new(), reason.clone()));
        }
    }
    for (id, make) in &decisions.makes {
        let Some(live) = make.old.map(|old| &facts.lives[old]) else {
            continue;
        };
        let entry = again.entry(live.seat());
        let (components, _) = entry.or_insert_with(|| (Vec::new(), make.reason.clone()));
        components.push(id.instance.to_owned());
    }
    let restart = |(seat, (mut components, mut reason)): (Seat<'a>, (Vec<String>, String))| {
        let stops = decisions.stops.contains_key(&seat);
        let by_hand = made_by_hand(facts, &seat);
        if stops && !by_hand.is_empty() {
            let names = by_hand.into_iter().collect::<Vec<_>>().join(", ");
            reason = format!("{reason}; made by hand and lost with it: {names}");
        }
        components.sort();
        Restart {
            node: seat.0.to_owned(),
            manager: seat.1.display_name(),
            pid: stops.then(|| facts.processes[&seat].pid),
            components,
            reason,
        }
    };
    again.into_iter().map(restart).collect()
}
