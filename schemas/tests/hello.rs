#![allow(clippy::unwrap_used)] // A failure here is a failed test.

//! The example system reads as its documentation says.

use rts_schemas::overlay;
use rts_schemas::rts_profile::load;
use rts_schemas::system::{RestartPolicy, SystemSpec};

const SYSTEM: &str = include_str!("../../manifests/hello/system.xml");
const TWIN: &str = include_str!("../../manifests/hello/system.yaml");
const CHANGED: &str = include_str!("../../manifests/hello/changed.xml");
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
