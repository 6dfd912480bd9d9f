//! What becomes of processes.

use crate::bring_up::Up;
use crate::decide::{Decisions, Stop};
use crate::index::Seat;
use crate::plan::{Action, Change};
use crate::target;

pub(super) fn managers<'a>(decisions: &Decisions<'a>, up: &Up<'a>, changes: &mut Vec<Change>) {
    let mut push = |seat: &Seat<'a>, action, reason: &str| {
        changes.push(Change {
            action,
            target: target::manager(seat.1),
            system: seat.1.system.as_ref().map(|s| s.name.clone()),
            node: Some(seat.0.to_owned()),
            reason: reason.to_owned(),
            fields: Vec::new(),
        });
    };
    for seat in up.starts.keys() {
        if !decisions.stops.contains_key(seat) {
            push(seat, Action::Add, "is not running");
        }
    }
    for (seat, stop) in decisions.stops.iter() {
        let (action, reason) = stopped(stop);
        push(seat, action, reason);
    }
    for (seat, (stop, why)) in decisions.stuck.iter() {
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
