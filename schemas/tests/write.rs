//! What is written is read as the same system.

#![allow(clippy::unwrap_used)] // A failure here is a failed test.

mod overlays;
mod systems;

use proptest::prelude::*;
use rts_schemas::diagnostic::Report;
use rts_schemas::rts_profile::{LowerOptions, WriteOptions, load, lower, read, sayable, write};
use rts_schemas::system::{PortKind, PortRef, SystemSpec};
use rts_schemas::{check, xml};

const SYSTEM: &str = include_str!("../../manifests/hello/system.xml");

const OPTIONS: WriteOptions<'_> = WriteOptions {
    created: "2026-01-15T10:00:00",
    updated: "2026-01-16T11:30:00",
    abstract_text: "A <test> of \"quotes\" & 日本語",
};

/// What is kept without being carried out is told; nothing else is.
fn again(spec: &SystemSpec) -> (SystemSpec, Report) {
    let text = write(spec, &OPTIONS);
    let profile = read("system.xml", text.as_bytes()).unwrap();
    assert_eq!(profile.findings, Report::default(), "{text}");
    let (again, mut report) = lower(&profile, &LowerOptions::default());
    report.findings.retain(|f| f.code != "not-carried-out");
    (again.unwrap(), report)
}

fn hello() -> SystemSpec {
    load("system.xml", SYSTEM.as_bytes(), None, &[]).unwrap().0
}

#[test]
fn hello_is_written_as_a_profile() {
    let options = WriteOptions {
        abstract_text: "A sine, filtered and printed",
        ..OPTIONS
    };
    let text = write(&hello(), &options);
    insta::assert_snapshot!(text);
    let (spec, report) = load("system.xml", text.as_bytes(), None, &[]).unwrap();
    assert_eq!((spec, report), (hello(), Report::default()));
}

#[test]
fn the_head_says_what_the_caller_knows() {
    let text = write(&hello(), &OPTIONS);
    let profile = read("system.xml", text.as_bytes()).unwrap().profile;
    let said = [
        profile.creation_date,
        profile.update_date,
        profile.abstract_text,
        profile.version,
    ];
    let said = said.map(|text| text.unwrap().value);
    let expected = [
        OPTIONS.created,
        OPTIONS.updated,
        OPTIONS.abstract_text,
        "0.2",
    ];
    assert_eq!(said, expected);
}

/// RT System Editor looks for literal names, and its schema for qualified attributes.
#[test]
fn every_attribute_is_qualified_and_every_element_has_its_usual_prefix() {
    let text = write(&hello(), &OPTIONS);
    let mut open = vec![xml::parse(&text).unwrap()];
    while let Some(element) = open.pop() {
        assert!(element.qname.starts_with("rts:") || element.qname.starts_with("rtsExt:"));
        let qualified = |a: &xml::Attribute| a.qname.contains(':');
        assert!(element.attributes.iter().all(qualified), "{element:?}");
        open.extend(element.elements().cloned());
    }
}

#[test]
fn what_no_profile_has_a_place_for_is_kept_in_properties() {
    let mut spec = hello();
    spec.name = "demo".to_owned();
    spec.components[0].full_id = String::new();
    spec.components[1].type_name = "LowPassFilter2".to_owned();
    spec.connectors[1].name = "by hand".to_owned();
    let text = write(&spec, &OPTIONS);
    for (name, value) in [
        ("rtsctl.name", "demo"),
        ("rtsctl.type", "SineSource"),
        ("rtsctl.type", "LowPassFilter2"),
        ("rtsctl.name", "by hand"),
    ] {
        let property = format!("rtsExt:name=\"{name}\" rtsExt:value=\"{value}\"");
        assert!(text.contains(&property), "{property} in {text}");
    }
    let (again, report) = load("system.xml", text.as_bytes(), None, &[]).unwrap();
    // The checks know these properties too.
    assert_eq!((again, report), (spec, Report::default()));
}

#[test]
fn own_names_and_types_are_checked() {
    let mut spec = hello();
    spec.name = "demo".to_owned();
    spec.components[0].type_name = "Other".to_owned();
    spec.connectors[0].name = "mine".to_owned();
    let mut text = write(&spec, &OPTIONS);
    for (own, wrong) in [("demo", "My Demo"), ("Other", "a/b"), ("mine", "x/y")] {
        let value = |value: &str| format!("rtsExt:value=\"{value}\"");
        text = text.replace(&value(own), &value(wrong));
    }
    let report = load("system.xml", text.as_bytes(), None, &[]).unwrap_err();
    let shown = report.findings.iter();
    let shown: Vec<String> = shown
        .map(|f| format!("{}: {}", f.code, f.message))
        .collect();
    insta::assert_snapshot!(shown.join("\n"), @r"
    bad-name: the type of component `Sine0` cannot be used: it has a `/`
    bad-name: the name of connector `mine` cannot be used: it has a `/`
    bad-system-name: `My Demo` cannot name a system
    ");
    assert!(
        report
            .findings
            .iter()
            .all(|f| f.place.is_some() && f.help.is_some())
    );
}

/// Such a system cannot come from a profile, and its export could not be read.
#[test]
fn what_no_profile_can_say_is_refused_when_it_comes_without_one() {
    let mut spec = hello();
    let component = &mut spec.components[1];
    component.placement.node = Some("no node".to_owned());
    component.policy.restart_limit = Some(0);
    component.policy.restart_window_ms = Some(u64::MAX);
    component.policy.start_timeout_ms = Some(99);
    component.policy.liveness_timeout_ms = Some(86_400_001);
    component.ports[0].name = String::new();
    spec.connectors[0].name = "a/b".to_owned();
    let found = check::spec_by_pointer(&spec).into_iter();
    let shown = found.map(|(pointer, finding)| {
        let help = finding
            .help
            .map_or_else(String::new, |help| format!("\n  {help}"));
        format!("{pointer}: {}: {}{help}", finding.code, finding.message)
    });
    insta::assert_snapshot!(shown.collect::<Vec<_>>().join("\n"));
}

/// As after `rtsctl connect`: a module has more ports than its profile declares.
#[test]
fn a_port_that_is_only_connected_is_declared() {
    let mut spec = hello();
    let mut extra = spec.connectors[0].clone();
    extra.source.port = "out2".to_owned();
    extra.name = format!("{}-{}", extra.source, extra.target);
    spec.connectors.push(extra);
    let text = write(&spec, &OPTIONS);
    let (again, report) = load("system.xml", text.as_bytes(), None, &[]).unwrap();
    assert_eq!(report, Report::default());
    assert_eq!(again, sayable(&spec));
    let declared = again.components[0].ports.iter();
    let declared: Vec<&str> = declared.map(|port| port.name.as_str()).collect();
    assert_eq!(declared, ["out", "out2"]);
}

fn is_declared(spec: &SystemSpec, end: &PortRef, kind: PortKind) -> bool {
    let component = spec.components.iter().find(|c| c.instance == end.instance);
    let mut ports = component.unwrap().ports.iter();
    ports.any(|port| port.name == end.port && port.kind == kind)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_is_read_as_the_same_system(spec in systems::system()) {
        prop_assert_eq!(check::spec(&spec), Report::default());
        let (again, report) = again(&spec);
        prop_assert_eq!(report, Report::default());
        prop_assert_eq!(again, sayable(&spec));
    }

    #[test]
    fn a_system_from_a_profile_is_sayable(spec in systems::system()) {
        let once = again(&spec).0;
        prop_assert_eq!(&sayable(&once), &once);
        prop_assert_eq!(write(&once, &OPTIONS), write(&spec, &OPTIONS));
    }

    /// Only the order of kinds, what is missing and what counts for nothing differ.
    #[test]
    fn the_sayable_system_is_the_same_one(spec in systems::system()) {
        let said = sayable(&spec);
        prop_assert_eq!(check::spec(&said), Report::default());
        prop_assert_eq!(said.components.len(), spec.components.len());
        for (said, own) in said.components.iter().zip(&spec.components) {
            prop_assert_eq!(&said.instance, &own.instance);
            prop_assert_eq!(&said.configuration, &own.configuration);
            prop_assert_eq!(&said.policy, &own.policy);
            prop_assert!(own.ports.iter().all(|port| said.ports.contains(port)));
        }
        for connector in &spec.connectors {
            let other = said.connectors.iter().find(|c| c.name == connector.name).unwrap();
            prop_assert_eq!(&other.properties, &connector.properties);
            prop_assert!(is_declared(&said, &connector.source, connector.kind));
            prop_assert!(is_declared(&said, &connector.target, connector.kind));
        }
        prop_assert_eq!(said.orders, spec.orders);
    }
}
