//! The wrong files of the examples, as they are deployed; what the program says of each is tested with the program.

// A failure here is a failed test; only the tests read files, the crate does not.
#![allow(clippy::unwrap_used, clippy::disallowed_methods)]

use std::path::PathBuf;

use rts_schemas::diagnostic::{Report, render};
use rts_schemas::overlay;
use rts_schemas::rts_profile::{load, load_with_places};

const HELLO: &str = include_str!("../../manifests/hello/system.xml");

fn files() -> Vec<(String, Vec<u8>)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../manifests/invalid");
    let mut files: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        // Those of `rtc.conf`, of conversions and of IDL have tests of their own.
        .filter(|path| {
            path.is_file() && path.extension().is_some_and(|e| e != "conf" && e != "idl")
        })
        .collect();
    files.sort();
    let read = |path: PathBuf| {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        (name, std::fs::read(path).unwrap())
    };
    files.into_iter().map(read).collect()
}

/// The findings of a file, and whether it may be deployed.
fn judge(name: &str, bytes: &[u8]) -> (Report, bool) {
    let result = if name.starts_with("overlay-") {
        overlay::read(name, bytes)
            .and_then(|overlay| load("system.xml", HELLO.as_bytes(), None, &[overlay]))
    } else {
        load(name, bytes, None, &[])
    };
    match result {
        Ok((_, report)) => (report, true),
        Err(report) => (report, false),
    }
}

/// What may be deployed has no error, and the other way round; nothing is refused for a warning.
#[test]
fn only_errors_refuse_a_file() {
    let mut refused = 0;
    for (name, bytes) in files() {
        let (report, deployable) = judge(&name, &bytes);
        assert_eq!(deployable, !report.has_errors(), "{name}: {report:?}");
        refused += usize::from(!deployable);
    }
    assert!(refused > 30, "{refused}");
}

#[test]
fn a_name_by_hand_mends_a_missing_one() {
    let (_, bytes) = files()
        .into_iter()
        .find(|(name, _)| name == "no-system-name.xml")
        .unwrap();
    let (spec, _) = load("no-system-name.xml", &bytes, Some("robot"), &[]).unwrap();
    assert_eq!(spec.name, "robot");
    let report = load("no-system-name.xml", &bytes, Some("My Robot"), &[]).unwrap_err();
    insta::assert_snapshot!(render(&report.findings[0]), @r"
    error[bad-system-name]: `My Robot` cannot name a system
      = help: a name has 1 to 63 of `a-z`, `0-9` and `-`; for example `--name my-robot`
    ");
}

#[test]
fn findings_come_in_the_order_of_the_file() {
    let (_, bytes) = files()
        .into_iter()
        .find(|(name, _)| name == "many.xml")
        .unwrap();
    let (report, _) = judge("many.xml", &bytes);
    let lines: Vec<usize> = report
        .findings
        .iter()
        .map(|f| f.place.as_ref().unwrap().line)
        .collect();
    assert!(lines.is_sorted() && lines.len() >= 7, "{lines:?}");
}

#[test]
fn an_overlay_in_place_of_a_profile_is_told_so() {
    let lab = include_bytes!("../../manifests/hello/lab.yaml");
    let report = load("lab.yaml", lab, None, &[]).unwrap_err();
    insta::assert_snapshot!(render(&report.findings[0]), @"
    error[wrong-root]: `apiVersion:` is not the root of an RTS Profile
     --> lab.yaml:2:1
      |
    2 | apiVersion: rtsctl.dev/v1
      | ^^^^^^^^^^
      = help: this is a deployment overlay: name the profile first, then this file (`-f PROFILE -f OVERLAY`)
    ");
}

/// `line: underlined text` of a pointer.
fn at(places: &rts_schemas::rts_profile::Places, pointer: &str) -> String {
    let place = places.find(pointer).unwrap();
    let text = place.text.chars().skip(place.column - place.text_column);
    format!(
        "{}: {}",
        place.line,
        text.take(place.length).collect::<String>()
    )
}

#[test]
fn a_pointer_into_the_model_leads_back_to_the_file() {
    let load = |name: &str| {
        let (_, bytes) = files().into_iter().find(|(n, _)| n == name).unwrap();
        load_with_places(name, &bytes, None, &[]).unwrap().places
    };
    let key = load("bad-config-key.xml");
    assert_eq!(at(&key, "/components/1"), "13: Filter0");
    assert_eq!(
        at(&key, "/components/1/configuration/sets/default/gian"),
        "24: gian"
    );
    assert_eq!(
        at(&key, "/components/0/type"),
        "5: RTC:rtsctl:example:SineSource:1.0"
    );
    assert_eq!(at(&key, "/connectors/0/target"), "31: Filter0.in");
    // What has no place of its own has that of what it is in.
    assert_eq!(at(&key, "/components/1/placement/node"), "13: Filter0");
    assert_eq!(key.find("/elsewhere"), None);
    let cycle = load("cycle.xml");
    assert_eq!(at(&cycle, "/orders/activation/2"), "60: Printer0");
    assert!(at(&cycle, "/orders").starts_with("43: <rts:Activation"));
    let reversed = load("reversed-connector.xml");
    assert!(at(&reversed, "/connectors/0/source").contains("out"));
}

/// A policy means the same in both places, and nothing is said about what is carried out.
#[test]
fn policies_of_an_overlay_and_of_a_profile_are_the_same() {
    let keys = [
        ("restart", "on-failure"),
        ("restartLimit", "3"),
        ("restartWindow", "2m"),
        ("startTimeout", "500ms"),
        ("livenessTimeout", "30s"),
        ("onHang", "restart"),
        ("onDisconnect", "stop"),
        ("resetOnError", "true"),
        ("drift", "adopt"),
    ];
    let lines: String = keys
        .iter()
        .map(|(key, value)| format!("      {key}: {value}\n"))
        .collect();
    let text = format!(
        "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec:\n  components:\n    Sine0:\n{lines}"
    );
    let overlay = overlay::read("o.yaml", text.as_bytes()).unwrap();
    let (by_overlay, report) = load("system.xml", HELLO.as_bytes(), None, &[overlay]).unwrap();
    assert_eq!(report, Report::default());
    let property = |(key, value): &(&str, &str)| {
        format!(r#"<rtsExt:Properties rtsExt:name="rtsctl.{key}" rtsExt:value="{value}"/>"#)
    };
    let own: String = keys.iter().map(property).collect();
    let profile = HELLO.replacen("</rts:Components>", &format!("{own}</rts:Components>"), 1);
    let (by_profile, report) = load("system.xml", profile.as_bytes(), None, &[]).unwrap();
    assert_eq!(report, Report::default());
    let policy = &by_overlay.components[0].policy;
    assert_eq!(policy, &by_profile.components[0].policy);
    insta::assert_json_snapshot!(policy, @r#"
    {
      "restart": "on-failure",
      "onDisconnect": "stop",
      "resetOnError": true,
      "restartLimit": 3,
      "restartWindowMs": 120000,
      "startTimeoutMs": 500,
      "livenessTimeoutMs": 30000,
      "onHang": "restart",
      "drift": "adopt"
    }
    "#);
}
