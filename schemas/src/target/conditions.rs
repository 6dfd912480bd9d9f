//! Orders of a part of a system: each condition goes with the component that waits.

use std::collections::HashSet;

use crate::system::{Condition, Orders, WaitFor};

/// The stored orders, in which the conditions of `taken` components are as in `new`. Components that are not `there`
/// are not waited for.
pub(super) fn orders(
    stored: &Orders,
    new: &Orders,
    taken: &HashSet<&str>,
    there: &HashSet<&str>,
) -> Orders {
    let merge = |list: fn(&Orders) -> &Vec<Condition>| {
        let merged = merged(list(stored), list(new), taken).into_iter();
        let left = merged.filter(|condition| there.contains(condition.target.as_str()));
        left.map(|condition| without_others(condition, there))
            .collect()
    };
    Orders {
        start_up: merge(|orders| &orders.start_up),
        shut_down: merge(|orders| &orders.shut_down),
        activation: merge(|orders| &orders.activation),
        deactivation: merge(|orders| &orders.deactivation),
        resetting: merge(|orders| &orders.resetting),
        initializing: merge(|orders| &orders.initializing),
        finalizing: merge(|orders| &orders.finalizing),
    }
}

/// Conditions have no names: the new ones stand where the old ones stood, and those that are left over at the end.
fn merged(stored: &[Condition], new: &[Condition], taken: &HashSet<&str>) -> Vec<Condition> {
    let is_taken = |condition: &&Condition| taken.contains(condition.target.as_str());
    let mut own = new.iter().filter(is_taken);
    let mut all: Vec<Condition> = Vec::new();
    for condition in stored {
        let placed = if is_taken(&condition) {
            own.next()
        } else {
            Some(condition)
        };
        all.extend(placed.cloned());
    }
    all.extend(own.cloned());
    all
}

/// What waits for nobody any more keeps its place in the sequence.
fn without_others(mut condition: Condition, there: &HashSet<&str>) -> Condition {
    if let Some(WaitFor::Preceding { components, .. }) = &mut condition.wait {
        let before = components.len();
        components.retain(|name| there.contains(name.as_str()));
        if components.is_empty() && before > 0 {
            condition.wait = None;
        }
    }
    condition
}
