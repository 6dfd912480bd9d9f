//! A part of a system is applied, and the rest is as it was.

#![allow(clippy::unwrap_used)] // A failure here is a failed test.

mod systems;

use std::collections::BTreeSet;

use proptest::prelude::*;
use rts_schemas::check;
use rts_schemas::diagnostic::Report;
use rts_schemas::rts_profile::load;
use rts_schemas::system::{ConnectorSpec, Orders, SystemSpec, WaitFor};
use rts_schemas::target::narrow;

fn load_from(text: &str) -> SystemSpec {
    load("system.xml", text.as_bytes(), None, &[]).unwrap().0
}

/// Sine0 → Filter0 → Printer0, activated from the sink to the source.
fn hello() -> SystemSpec {
    load_from(include_str!("../../manifests/hello/system.xml"))
}

fn changed() -> SystemSpec {
    load_from(include_str!("../../manifests/hello/changed.xml"))
}

fn targets(names: &[&str]) -> Vec<String> {
    names.iter().map(|&name| name.to_owned()).collect()
}

fn names(spec: &SystemSpec) -> (Vec<&str>, Vec<&str>) {
    let components = spec.components.iter().map(|c| c.instance.as_str());
    let connectors = spec.connectors.iter().map(|c| c.name.as_str());
    (components.collect(), connectors.collect())
}

/// The system without a component and what ends at it.
fn without(mut spec: SystemSpec, instance: &str) -> SystemSpec {
    spec.components.retain(|c| c.instance != instance);
    spec.connectors
        .retain(|c| c.source.instance != instance && c.target.instance != instance);
    let there: BTreeSet<String> = spec.components.iter().map(|c| c.instance.clone()).collect();
    restrict(&mut spec.orders, &there);
    spec
}

fn restrict(orders: &mut Orders, there: &BTreeSet<String>) {
    for list in [
        &mut orders.start_up,
        &mut orders.shut_down,
        &mut orders.activation,
        &mut orders.deactivation,
        &mut orders.resetting,
        &mut orders.initializing,
        &mut orders.finalizing,
    ] {
        list.retain(|condition| {
            let waits = match &condition.wait {
                Some(WaitFor::Preceding { components, .. }) => components.as_slice(),
                _ => &[],
            };
            there.contains(&condition.target) && waits.iter().all(|name| there.contains(name))
        });
    }
}

#[test]
fn one_component_is_changed_and_the_others_stay() {
    let (stored, new) = (hello(), changed());
    let mut expected = stored.clone();
    expected.components[1] = new.components[1].clone();
    assert_ne!(expected, stored);
    for target in ["component/Filter0", "Filter0", " Filter0 "] {
        let found = narrow(Some(&stored), &new, &targets(&[target])).unwrap();
        assert_eq!(found, expected, "{target}");
    }
}

#[test]
fn one_connector_is_changed_and_the_others_stay() {
    let stored = hello();
    let mut new = changed();
    for connector in &mut new.connectors {
        let policy = ("dataport.subscription_type".to_owned(), "new".to_owned());
        connector.properties.extend([policy]);
    }
    let mut expected = stored.clone();
    expected.connectors[1] = new.connectors[1].clone();
    for target in [
        "connector/Filter0.out-Printer0.in",
        "Filter0.out-Printer0.in",
    ] {
        let found = narrow(Some(&stored), &new, &targets(&[target])).unwrap();
        assert_eq!(found, expected, "{target}");
    }
}

#[test]
fn a_connector_brings_its_ends_and_nothing_else() {
    let connector = targets(&["connector/Sine0.out-Filter0.in"]);
    let found = narrow(None, &hello(), &connector).unwrap();
    let expected = (vec!["Sine0", "Filter0"], vec!["Sine0.out-Filter0.in"]);
    assert_eq!(names(&found), expected);
    // Filter0 keeps its place in the sequence, though who goes before it is not there.
    let activation: Vec<_> = found.orders.activation.iter().collect();
    assert_eq!(activation.len(), 2);
    assert_eq!(
        (activation[0].target.as_str(), activation[0].sequence),
        ("Filter0", 2)
    );
    assert_eq!(activation[0].wait, None);
    assert!(activation[1].wait.is_some());
    assert_eq!(found.full_id, hello().full_id);
}

#[test]
fn a_new_component_brings_its_connectors_to_what_is_there() {
    let stored = without(hello(), "Filter0");
    let found = narrow(Some(&stored), &hello(), &targets(&["Filter0"])).unwrap();
    let expected = names(&found);
    assert_eq!(expected, names(&hello()));
    let stored = without(stored, "Printer0");
    let found = narrow(Some(&stored), &hello(), &targets(&["Filter0"])).unwrap();
    let expected = (vec!["Sine0", "Filter0"], vec!["Sine0.out-Filter0.in"]);
    assert_eq!(names(&found), expected);
}

#[test]
fn a_removed_component_takes_its_connectors_along() {
    let new = without(hello(), "Filter0");
    let found = narrow(Some(&hello()), &new, &targets(&["Filter0"])).unwrap();
    assert_eq!(names(&found), (vec!["Sine0", "Printer0"], vec![]));
    assert_eq!(check::spec(&found), Report::default());
    let waits = found.orders.activation.iter().map(|c| c.wait.is_some());
    assert_eq!(waits.collect::<Vec<_>>(), [false, false]);
    // What the file lacks is not removed unless it is a target.
    let found = narrow(Some(&hello()), &new, &targets(&["Sine0"])).unwrap();
    assert_eq!(names(&found), names(&hello()));
}

#[test]
fn what_was_connected_to_a_port_that_is_gone_goes_with_it() {
    let mut new = hello();
    new.components[1].ports[0].name = "input".to_owned();
    new.connectors[0].target.port = "input".to_owned();
    new.connectors[0].name = "Sine0.out-Filter0.input".to_owned();
    let found = narrow(Some(&hello()), &new, &targets(&["Filter0"])).unwrap();
    let (_, connectors) = names(&found);
    let mut connectors = connectors;
    connectors.sort_unstable();
    assert_eq!(
        connectors,
        ["Filter0.out-Printer0.in", "Sine0.out-Filter0.input"]
    );
}

#[test]
fn the_name_of_both_is_the_component() {
    let mut stored = hello();
    stored.connectors[0].name = "Filter0".to_owned();
    let mut new = changed();
    new.connectors.remove(0);
    let found = narrow(Some(&stored), &new, &targets(&["Filter0"])).unwrap();
    assert_eq!(found.components[1], new.components[1]);
    assert_eq!(found.connectors, stored.connectors);
    let found = narrow(Some(&stored), &new, &targets(&["connector/Filter0"])).unwrap();
    assert_eq!(
        (found.components, found.connectors.len()),
        (stored.components, 1)
    );
}

#[test]
fn an_unknown_target_is_told_with_what_there_is() {
    let shown = |target: &str| {
        let error = narrow(Some(&hello()), &changed(), &targets(&["Sine0", target])).unwrap_err();
        assert_eq!(error.target, target);
        format!("{error}\n{}", error.help)
    };
    let all = [
        "component/Fitler0",
        "connector/Sine0",
        "Pritner0",
        "node/n0",
        "",
    ];
    let shown: Vec<String> = all.into_iter().map(shown).collect();
    insta::assert_snapshot!(shown.join("\n\n"));
    let mut empty = hello();
    empty.components.clear();
    empty.connectors.clear();
    let error = narrow(None, &empty, &targets(&["Sine0"])).unwrap_err();
    insta::assert_snapshot!(error.help, @"neither the file nor the stored system has a component or connector");
}

/// Another version of `stored`: some components are gone or as in `other`, some of `other` are new.
fn version(stored: &SystemSpec, other: &SystemSpec, choices: &[u8]) -> SystemSpec {
    let mut new = stored.clone();
    new.components.clear();
    let mut choices = choices.iter().cycle();
    let kept = stored.components.iter().filter_map(|component| {
        let same = other
            .components
            .iter()
            .find(|c| c.instance == component.instance);
        match choices.next() {
            Some(0) => None,
            Some(1) => same.cloned(),
            _ => Some(component.clone()),
        }
    });
    new.components.extend(kept);
    let is_new = |instance: &str| stored.components.iter().all(|c| c.instance != instance);
    let added = other.components.iter().filter(|c| is_new(&c.instance));
    new.components.splice(0..0, added.cloned());
    let there: BTreeSet<String> = new.components.iter().map(|c| c.instance.clone()).collect();
    let mut used = BTreeSet::new();
    let all = other.connectors.iter().chain(&stored.connectors);
    new.connectors = all
        .filter(|c| fits(c, &there) && used.insert(c.name.clone()))
        .cloned()
        .collect();
    if choices.next() == Some(&1) {
        new.orders = other.orders.clone();
    }
    restrict(&mut new.orders, &there);
    new
}

fn fits(connector: &ConnectorSpec, there: &BTreeSet<String>) -> bool {
    there.contains(&connector.source.instance) && there.contains(&connector.target.instance)
}

/// The order of connectors says nothing.
fn by_name(mut spec: SystemSpec) -> SystemSpec {
    spec.connectors.sort_by(|a, b| a.name.cmp(&b.name));
    spec
}

/// Two versions of a system, and some names of both.
fn versions() -> impl Strategy<Value = (SystemSpec, SystemSpec, Vec<String>)> {
    let choices = prop::collection::vec(0..4u8, 1..7);
    let some = prop::collection::vec(any::<bool>(), 1..9);
    (systems::system(), systems::system(), choices, some).prop_map(
        |(stored, other, choices, some)| {
            let new = version(&stored, &other, &choices);
            let mut some = some.into_iter().cycle();
            let names = all_targets(&stored, &new).into_iter();
            let names = names.filter(|_| some.next() == Some(true)).collect();
            (stored, new, names)
        },
    )
}

fn all_targets(stored: &SystemSpec, new: &SystemSpec) -> Vec<String> {
    let both = [stored, new];
    let components = both.iter().flat_map(|spec| &spec.components);
    let connectors = both.iter().flat_map(|spec| &spec.connectors);
    let components = components.map(|c| format!("component/{}", c.instance));
    let connectors = connectors.map(|c| format!("connector/{}", c.name));
    let all: BTreeSet<String> = components.chain(connectors).collect();
    all.into_iter().collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn all_targets_are_the_new_system((stored, new, _) in versions()) {
        prop_assert_eq!(check::spec(&new), Report::default());
        let all = all_targets(&stored, &new);
        prop_assert_eq!(&narrow(Some(&stored), &new, &all).unwrap(), &new);
        let own = all_targets(&new, &new);
        prop_assert_eq!(narrow(None, &new, &own).unwrap(), new);
    }

    #[test]
    fn targets_that_are_not_changed_change_nothing((stored, new, some) in versions()) {
        prop_assert_eq!(&narrow(Some(&stored), &new, &[]).unwrap(), &stored);
        // The same things in the place of those that are targeted.
        let mut same = new.clone();
        same.components.retain(|c| !some.contains(&format!("component/{}", c.instance)));
        same.connectors.retain(|c| !some.contains(&format!("connector/{}", c.name)));
        let own: Vec<String> = all_targets(&stored, &stored).into_iter().filter(|t| some.contains(t)).collect();
        for component in stored.components.iter().filter(|c| own.contains(&format!("component/{}", c.instance))) {
            same.components.push(component.clone());
        }
        for connector in stored.connectors.iter().filter(|c| own.contains(&format!("connector/{}", c.name))) {
            same.connectors.push(connector.clone());
        }
        same.orders = stored.orders.clone();
        prop_assert_eq!(&narrow(Some(&stored), &same, &own).unwrap(), &stored);
    }

    #[test]
    fn a_part_is_a_sound_system((stored, new, some) in versions()) {
        let found = narrow(Some(&stored), &new, &some).unwrap();
        prop_assert_eq!(check::spec(&found), Report::default());
        let alone = narrow(None, &new, &some);
        if let Ok(alone) = alone {
            prop_assert_eq!(check::spec(&alone), Report::default());
        }
        // Asked again there is nothing to do; what was removed cannot be named again.
        let known = all_targets(&found, &new);
        let again: Vec<String> = some.into_iter().filter(|target| known.contains(target)).collect();
        let again = narrow(Some(&found), &new, &again).unwrap();
        prop_assert_eq!(by_name(again), by_name(found));
    }

    #[test]
    fn targets_are_as_in_the_file_and_others_as_stored((stored, new, some) in versions()) {
        let found = narrow(Some(&stored), &new, &some).unwrap();
        let of = |spec: &SystemSpec, name: &str| spec.components.iter().find(|c| c.instance == name).cloned();
        for target in all_targets(&stored, &new) {
            let Some(name) = target.strip_prefix("component/") else { continue };
            let (new, stored) = (of(&new, name), of(&stored, name));
            if some.contains(&target) {
                prop_assert_eq!(of(&found, name), new);
            } else if stored.is_some() {
                prop_assert_eq!(of(&found, name), stored);
            }
        }
        let of = |spec: &SystemSpec, name: &str| spec.connectors.iter().find(|c| c.name == name).cloned();
        for target in &some {
            if let Some(name) = target.strip_prefix("connector/") {
                let wanted = of(&new, name);
                let found = of(&found, name);
                // Without its ends it cannot be: they are targets that the file does not have.
                prop_assert!(found == wanted, "{}", name);
            }
        }
    }
}
