//! What the orders of a profile ask for when something comes up, straight from its conditions: each list has its own
//! sequence, and a `Preceding` outweighs it.
//!
//! Left out is what nobody can judge from outside: ASYNC waits for a request alone, and an optional component is waited
//! for only until its try has ended.

use std::collections::BTreeSet;

use rts_schemas::system::{Condition, SendingTiming, SystemSpec, WaitFor};

/// Instances that must be Active before this one may be activated.
pub(super) fn before_activation<'a>(spec: &'a SystemSpec, instance: &str) -> BTreeSet<&'a str> {
    required(spec, before(&spec.orders.activation, instance))
}

/// Instances that must be there before this one may be created.
pub(super) fn before_creation<'a>(spec: &'a SystemSpec, instance: &str) -> BTreeSet<&'a str> {
    let mut all = before(&spec.orders.start_up, instance);
    all.extend(before(&spec.orders.initializing, instance));
    required(spec, all)
}

/// Those that the system has, and that are not optional.
fn required<'a>(spec: &'a SystemSpec, names: BTreeSet<&str>) -> BTreeSet<&'a str> {
    let components = spec.components.iter().filter(|c| c.required);
    let components = components.map(|c| c.instance.as_str());
    components.filter(|name| names.contains(name)).collect()
}

fn before<'a>(list: &'a [Condition], instance: &str) -> BTreeSet<&'a str> {
    let level = |name: &str| {
        let own = list.iter().filter(|c| c.target == name);
        own.map(|c| c.sequence).max()
    };
    let Some(own) = level(instance) else {
        return BTreeSet::new();
    };
    let lower = |c: &&Condition| {
        level(&c.target).is_some_and(|lower| lower < own && !outweighed(list, &c.target, lower))
    };
    let mut all: BTreeSet<&str> = list
        .iter()
        .filter(lower)
        .map(|c| c.target.as_str())
        .collect();
    for condition in list.iter().filter(|c| c.target == instance) {
        if let Some(WaitFor::Preceding {
            timing: SendingTiming::Sync,
            components,
            ..
        }) = &condition.wait
        {
            all.extend(components.iter().map(String::as_str));
        }
    }
    all.remove(instance);
    all
}

/// True when a component waits, by `Preceding`, for one whose number in the list is higher than its own: nobody waits for
/// its number then.
fn outweighed(list: &[Condition], instance: &str, number: u32) -> bool {
    let mut seen = BTreeSet::new();
    let mut open = vec![instance];
    while let Some(one) = open.pop() {
        for condition in list.iter().filter(|c| c.target == one) {
            if one != instance && condition.sequence > number {
                return true;
            }
            if let Some(WaitFor::Preceding { components, .. }) = &condition.wait {
                let new = components.iter().map(String::as_str);
                open.extend(new.filter(|name| seen.insert(*name)));
            }
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::hello;
    use super::*;

    fn condition(target: &str, sequence: u32, wait: Option<WaitFor>) -> Condition {
        Condition {
            target: target.to_owned(),
            sequence,
            wait,
        }
    }

    fn preceding(timing: SendingTiming, components: &[&str]) -> Option<WaitFor> {
        Some(WaitFor::Preceding {
            timing,
            timeout_ms: 100,
            components: components.iter().map(|name| (*name).to_owned()).collect(),
        })
    }

    fn awaited(spec: &SystemSpec, instance: &str) -> String {
        let names: Vec<_> = before_activation(spec, instance).into_iter().collect();
        names.join(" ")
    }

    #[test]
    fn numbers_and_sync_are_waited_for_and_what_is_optional_is_not() {
        let mut spec = hello(&["A", "B", "C", "D", "E"]);
        spec.components[1].required = false;
        spec.orders.activation = vec![
            condition("A", 1, None),
            condition("B", 1, None),
            condition("C", 3, None),
            condition("D", 3, preceding(SendingTiming::Sync, &["C", "Nobody"])),
            condition("E", 3, preceding(SendingTiming::Async, &["D"])),
        ];
        let found = ["A", "B", "C", "D", "E"].map(|name| awaited(&spec, name));
        assert_eq!(found, ["", "", "A", "A C", "A"]);
        assert!(before_creation(&spec, "D").is_empty());
        spec.orders.initializing = std::mem::take(&mut spec.orders.activation);
        assert_eq!(before_creation(&spec, "D"), BTreeSet::from(["A", "C"]));
    }

    #[test]
    fn preceding_outweighs_the_numbers() {
        let mut spec = hello(&["A", "B"]);
        spec.orders.activation = vec![
            condition("A", 1, preceding(SendingTiming::Sync, &["B"])),
            condition("B", 2, None),
        ];
        assert_eq!([awaited(&spec, "A"), awaited(&spec, "B")], ["B", ""]);
    }
}
