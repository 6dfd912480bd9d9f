#![allow(clippy::unwrap_used)] // A failure here is a failed test.

//! The example system reads as its documentation says.

use rts_schemas::overlay;
use rts_schemas::rts_profile::load;
use rts_schemas::system::{RestartPolicy, SystemSpec};

const SYSTEM: &str = include_str!("../../manifests/hello/system.xml");
const TWIN: &str = include_str!("../../manifests/hello/system.yaml");
const CHANGED: &str = include_str!("../../manifests/hello/changed.xml");
const COMPOSITE: &str = include_str!("../../manifests/hello/composite.xml");
const LAB: &str = include_str!("../../manifests/hello/lab.yaml");

fn read(name: &str, text: &str) -> SystemSpec {
    let (spec, report) = load(name, text.as_bytes(), None, &[]).unwrap();
    assert_eq!(report.findings, [], "{name}");
    spec
}

#[test]
fn hello_as_one_model() {
    insta::assert_json_snapshot!(read("system.xml", SYSTEM));
}

#[test]
fn the_yaml_twin_is_the_same_system() {
    assert_eq!(read("system.xml", SYSTEM), read("system.yaml", TWIN));
}

#[test]
fn changed_differs_in_three_places() {
    let mut spec = read("system.xml", SYSTEM);
    let set = |spec: &mut SystemSpec| {
        spec.components[0].execution_context.rate = Some(200.0);
        let filter = spec.components[1]
            .configuration
            .sets
            .get_mut("default")
            .unwrap();
        filter.insert("gain".into(), "2.0".into());
        spec.components[2].placement.isolated = false;
    };
    let before = spec.clone();
    set(&mut spec);
    assert_ne!(before, spec);
    assert_eq!(spec, read("changed.xml", CHANGED));
}

#[test]
fn the_overlay_wins() {
    let lab = overlay::read("lab.yaml", LAB.as_bytes()).unwrap();
    assert_eq!(lab.name.as_deref(), Some("lab"));
    let (spec, report) = load("system.xml", SYSTEM.as_bytes(), Some("demo"), &[lab]).unwrap();
    assert_eq!(report.findings, []);
    assert_eq!(spec.name, "demo");
    let [_, filter, printer] = &spec.components[..] else {
        panic!("three components");
    };
    assert_eq!(filter.placement.node.as_deref(), Some("local"));
    assert_eq!(filter.placement.manager.as_deref(), Some("signal"));
    assert!(filter.policy.reset_on_error);
    assert!(printer.placement.isolated);
    assert_eq!(printer.policy.restart, RestartPolicy::Never);
}

#[test]
fn a_composite_is_a_name_for_its_members_and_survives_being_written() {
    let spec = read("composite.xml", COMPOSITE);
    let names: Vec<&str> = spec
        .components
        .iter()
        .map(|c| c.instance.as_str())
        .collect();
    assert_eq!(names, ["Sine0", "Filter0", "Printer0"]);
    let shared = |index: usize| spec.components[index].execution_context.clone();
    let (sine, filter) = (shared(0), shared(1));
    assert_eq!(sine.name.as_deref(), Some("Loop0"));
    assert_eq!((sine.order, filter.order), (10, 20));
    assert_eq!((sine.rate, filter.rate), (Some(50.0), Some(50.0)));
    assert_eq!(filter.shared_state.as_deref(), Some("Loop0"));
    assert_eq!((shared(2).name, shared(2).rate), (None, Some(100.0)));
    assert_eq!(spec.connectors[1].source.to_string(), "Filter0.out");
    assert_eq!(spec.composites[0].members, ["Sine0", "Filter0"]);

    let options = rts_schemas::rts_profile::WriteOptions {
        created: "2026-01-15T10:00:00",
        updated: "2026-01-15T10:00:00",
        abstract_text: "",
    };
    let written = rts_schemas::rts_profile::write(&spec, &options);
    assert_eq!(read("written.xml", &written), spec);
}

#[test]
fn what_an_overlay_says_of_a_composite_it_says_of_its_members() {
    let text = "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec:\n  components:\n    \
                Loop0: { manager: loop, resetOnError: true, executionContext: { rate: 20 } }\n    \
                Sine0: { resetOnError: false }\n  order:\n    activation:\n      \
                - { component: Printer0, after: Loop0 }\n";
    let overlay = overlay::read("o.yaml", text.as_bytes()).unwrap();
    let (spec, report) = load("composite.xml", COMPOSITE.as_bytes(), None, &[overlay]).unwrap();
    assert_eq!(report.findings, []);
    let of = |index: usize| &spec.components[index];
    for index in [0, 1] {
        assert_eq!(of(index).placement.manager.as_deref(), Some("loop"));
        assert_eq!(of(index).execution_context.rate, Some(20.0));
        assert_eq!(of(index).policy.reset_on_error, index == 1);
    }
    assert_eq!(of(2).placement.manager, None);
    let order = &spec.orders.activation[0];
    assert!(
        format!("{order:?}").contains(r#"["Sine0", "Filter0"]"#),
        "{order:?}"
    );
}
