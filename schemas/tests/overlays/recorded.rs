//! Recorded data of stand-ins.

use rts_schemas::check::{self, Library};
use rts_schemas::diagnostic::{Finding, Report, render};
use rts_schemas::overlay;
use rts_schemas::rts_profile::{WriteOptions, load, write};
use rts_schemas::system::SystemSpec;
use serde_json::json;

const HELLO: &str = include_str!("../../../manifests/hello/system.xml");

/// `hello` with overlays of these specs, as `rtsctl check` sees it.
fn checked(specs: &[&str]) -> (SystemSpec, Vec<Finding>) {
    let overlays = (1..).zip(specs).map(|(number, spec)| {
        let text = format!("apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec:{spec}\n");
        overlay::read_any(&format!("{number}.yaml"), text.as_bytes()).unwrap()
    });
    let overlays: Vec<_> = overlays.collect();
    let library = Library::default();
    let system = check::system(
        "system.xml",
        HELLO.as_bytes(),
        None,
        &overlays,
        Some(&library),
    );
    let mut system = system.unwrap();
    (system.spec.clone(), system.take_report().findings)
}

fn told(specs: &[&str]) -> String {
    let found = checked(specs).1;
    let texts: Vec<String> = found.iter().map(render).collect();
    texts.join("\n\n")
}

#[test]
fn it_is_laid_port_by_port_and_kept_as_it_is_spelled() {
    let specs = [
        " {types: {SineSource: {standIn: {when: missing, data: {out: [1, 2.50, '-3', .inf]}}}}}",
        " {components: {Filter0: {standIn: {when: always, data: {out: [7]}}}, Printer0: {standIn: {data: {x: [1]}}}}}",
        " {components: {Filter0: {standIn: {data: {out: null}}}, Printer0: {standIn: {data: null}}}}",
    ];
    let (spec, findings) = checked(&specs);
    assert_eq!(findings, []);
    let said = spec.components.iter().map(|component| &component.stand_in);
    let said = json!(said.collect::<Vec<_>>());
    let sine = json!({"when": "missing", "data": {"out": [["1"], ["2.50"], ["-3"], [".inf"]]}});
    assert_eq!(said, json!([sine, {"when": "always"}, {}]));
}

/// With its place: a name that has dots is one name.
#[test]
fn an_export_says_it_again() {
    let spec = " {components: {Sine0: {standIn: {when: always, data: {out: [1, 'x \"y\"'], a.b: [[1, 2], []]}}}}}";
    let (spec, _) = checked(&[spec]);
    let options = WriteOptions {
        created: "2026-01-15T10:00:00",
        updated: "2026-01-15T10:00:00",
        abstract_text: "",
    };
    let text = write(&spec, &options);
    let (again, report) = load("again.xml", text.as_bytes(), None, &[]).unwrap();
    assert_eq!(report, Report::default());
    assert_eq!(again.components[0].stand_in, spec.components[0].stand_in);
    assert_eq!(spec.components[0].stand_in.data.len(), 2);
}

/// Every fault in one run, each at its port or its value.
#[test]
fn what_cannot_be_played_is_told() {
    let spec = "
  components:
    Sine0: {standIn: {data: {out: [1, 2, fast], uot: [1]}}}
    Filter0:
      standIn: {when: missing, data: {in: [1], out: []}}
    Printer0: {standIn: {when: always, data: {in: [[1]]}}}";
    let shape = "
  defaults: {standIn: {data: {out: recorded.csv, in: {a: 1}}}}
  components:
    Sine0: {standIn: {data: {out: [1, null, {a: 1}, [2, [3]]]}}}
    Filter0: {standIn: {data: [1]}}";
    insta::assert_snapshot!(told(&[spec]) + "\n\n----\n\n" + &told(&[shape]));
}

#[test]
fn it_has_its_bounds() {
    let many = "\n          - 1".repeat(10_001);
    let many =
        format!("\n  components:\n    Sine0:\n      standIn:\n        data:\n         out:{many}");
    assert!(told(&[&many]).starts_with("error[too-many-entries]"));
    let long = "x".repeat(1024 * 1024 - 2);
    let long = format!(" {{components: {{Sine0: {{standIn: {{data: {{out: [{long}]}}}}}}}}}}");
    let told = told(&[&long]);
    assert!(
        told.contains("Sine0: its recorded data has 1048577 bytes"),
        "{told:.300}"
    );
}

/// What stands for no stand-in is not looked at; over the API the same is told by its pointer.
#[test]
fn a_system_without_its_file_is_checked_too() {
    let (mut spec, _) = checked(&[" {components: {Sine0: {standIn: {data: {in/out: [1]}}}}}"]);
    assert_eq!(check::spec(&spec), Report::default());
    spec.components[0].stand_in.when = Some(rts_schemas::system::StandIn::Always);
    let found = check::spec_by_pointer(&spec);
    let found: Vec<_> = found
        .iter()
        .map(|(at, f)| (at.as_str(), f.code.as_str()))
        .collect();
    assert_eq!(
        found,
        [("/components/0/standIn/data/in~1out", "bad-recorded-data")]
    );
}
