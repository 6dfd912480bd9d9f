//! One overlay, or several, over the example.

use rts_schemas::diagnostic::{Report, render};
use rts_schemas::overlay;
use rts_schemas::rts_profile::{Loaded, WriteOptions, load_with_places, sayable, write};
use rts_schemas::system::{NO_SEQUENCE, SystemSpec, WaitFor};

const HELLO: &str = include_str!("../../../manifests/hello/system.xml");

/// The example with a host, and these specs laid over it.
fn laid(specs: &[&str]) -> Result<Loaded, Report> {
    let profile = HELLO.replacen("localhost/Sine0.rtc", "Robot1.local/Sine0.rtc", 1);
    let overlays: Result<Vec<_>, _> = (1..)
        .zip(specs)
        .map(|(number, spec)| {
            let text = format!("apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec: {spec}\n");
            overlay::read(&format!("{number}.yaml"), text.as_bytes())
        })
        .collect();
    load_with_places("system.xml", profile.as_bytes(), None, &overlays?)
}

fn quiet(specs: &[&str]) -> SystemSpec {
    let loaded = laid(specs).unwrap();
    assert_eq!(loaded.report, Report::default());
    loaded.spec
}

fn told(specs: &[&str]) -> String {
    let report = match laid(specs) {
        Ok(loaded) => loaded.report,
        Err(report) => report,
    };
    let shown: Vec<String> = report.findings.iter().map(render).collect();
    shown.join("\n\n")
}

fn nodes(spec: &SystemSpec) -> Vec<&str> {
    let nodes = spec.components.iter().map(|c| c.placement.node.as_deref());
    nodes.map(|node| node.unwrap_or("-")).collect()
}

#[test]
fn hosts_are_nodes_and_what_is_nearer_wins() {
    assert_eq!(
        nodes(&quiet(&["{hosts: {robot1.LOCAL: arm}}"])),
        ["arm", "-", "-"]
    );
    let spec = "{defaults: {node: a}, hosts: {robot1.local: b}}";
    assert_eq!(nodes(&quiet(&[spec])), ["b", "a", "a"]);
    let spec = "{defaults: {node: a}, hosts: {robot1.local: b}, types: {'*Source': {node: c}, '*': {node: d}}}";
    assert_eq!(nodes(&quiet(&[spec])), ["d", "d", "d"], "the last glob");
    let spec = "{types: {SineSource: {node: t}, '*': {node: g}}, components: {'*0': {node: i}}}";
    assert_eq!(
        nodes(&quiet(&[spec])),
        ["t", "i", "i"],
        "type, glob of instances, glob of types"
    );
    let spec = "{components: {Sine0: {node: x}, 'S*': {node: y}}, types: {SineSource: {node: t}}}";
    assert_eq!(nodes(&quiet(&[spec])), ["x", "-", "-"]);
    let later = "{defaults: {node: z}}";
    assert_eq!(
        nodes(&quiet(&[spec, later])),
        ["z", "z", "z"],
        "a later file"
    );
    let back = "{components: {Sine0: {node: null}}}";
    assert_eq!(nodes(&quiet(&[spec, later, back])), ["-", "z", "z"]);
}

#[test]
fn a_process_of_its_own_beats_a_manager_of_the_same_entry_only() {
    let of = |specs: &[&str]| {
        let placement = quiet(specs).components[1].placement.clone();
        (placement.manager, placement.isolated)
    };
    let both = "{components: {Filter0: {isolated: true, manager: m}}}";
    assert_eq!(of(&[both]), (None, true));
    let manager = "{components: {Filter0: {manager: m}}}";
    assert_eq!(of(&[both, manager]), (Some("m".to_owned()), false));
    assert_eq!(of(&[manager, "{defaults: {isolated: true}}"]), (None, true));
    let all = "{defaults: {isolated: true}, components: {Filter0: {manager: m}}}";
    assert_eq!(of(&[all]), (Some("m".to_owned()), false));
}

#[test]
fn configuration_is_said_value_by_value() {
    let of = |specs: &[&str]| quiet(specs).components[1].configuration.clone();
    let values = |specs: &[&str]| format!("{:?}", of(specs).sets["default"]);
    let gain = "{types: {LowPassFilter: {configuration: {sets: {default: {gain: 2.50}}}}}}";
    assert_eq!(
        values(&[gain]),
        r#"{"alpha": "0.1", "gain": "2.50"}"#,
        "as it is spelled"
    );
    let away =
        "{components: {Filter0: {configuration: {sets: {default: {alpha: null, gain: ' 3'}}}}}}";
    assert_eq!(values(&[gain, away]), r#"{"gain": " 3"}"#);
    let none = "{components: {Filter0: {configuration: {sets: null, active: null}}}}";
    let none = of(&[gain, none]);
    assert_eq!((none.active, none.sets.len()), (None, 0));
}

#[test]
fn configuration_that_the_profile_does_not_know_is_told_once_a_line() {
    let spec = "
  components:
    '*0': {configuration: {sets: {default: {gain: 2}, fast: {gain: 1}}}}
    Filter0: {configuration: {active: slow}}
    Sine0: {configuration: {active: fast}}";
    insta::assert_snapshot!(told(&[spec]));
}

#[test]
fn what_fits_nothing_is_told() {
    let spec = "
  hosts: {robot2.local: a, localhost: b}
  types: {SineSorce: {}, '*Camera': {}}
  components: {'Arm?': {}, Fliter0: {}}
  order:
    activation:
      - {component: Sine1, after: ['Arm*', Filter0]}";
    insta::assert_snapshot!(told(&[spec]));
}

/// Every fault of the file in one run, each at its place.
#[test]
fn all_faults_are_told() {
    let spec = "
  defaults: {isolated: maybe, restartLimit: 0, restartWindow: 10}
  hosts: {robot1.local: 'no node'}
  types: {SineSource: {package: ../x, version: ';', standIn: perhaps}}
  components:
    Sine0: {resources: {cpus: 3-2, realtimePriority: 100, memoryLimit: 256, cpu: 1}}
    Filter0: {configuration: {set: {}, sets: {default: [1]}}}
    Printer0: [isolated]
  order:
    activate: []
    activation:
      - {after: Sine0}
      - {component: Sine0, after: Filter0, timing: soon, timeout: 25h, sequence: -1}
      - Sine0
      - {component: Sine0}
  managers: {}";
    insta::assert_snapshot!(told(&[spec]));
}

/// What an overlay says last is held against the profile: once for a line, and nothing is said of what did not come to be.
#[test]
fn values_are_held_against_the_profile() {
    let sets = r#"<rts:ConfigurationSets rts:id="__constraints__"><rts:ConfigurationData rts:name="gain" rts:data="x &lt; 10"/></rts:ConfigurationSets><rts:ConfigurationSets rts:id="__type__"><rts:ConfigurationData rts:name="a/b" rts:data="int"/></rts:ConfigurationSets>"#;
    let profile = HELLO.replace(
        "<rts:ExecutionContexts",
        &format!("{sets}<rts:ExecutionContexts"),
    );
    let all = "{components: {'*0': {configuration: {sets: {default: {gain: 20, 'a/b': 1.5}}}}}}";
    let some = "{components: {Filter0: {configuration: {sets: {default: {gain: 5}}}}}}";
    let told = |specs: &[&str]| {
        let overlays = (1..).zip(specs).map(|(number, spec)| {
            let text = format!("apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec: {spec}\n");
            overlay::read(&format!("{number}.yaml"), text.as_bytes()).unwrap()
        });
        let overlays: Vec<_> = overlays.collect();
        let loaded = load_with_places("s.xml", profile.as_bytes(), None, &overlays).unwrap();
        let findings = loaded.report.findings.into_iter();
        let line = |f: rts_schemas::diagnostic::Finding| {
            let place = f.place.unwrap();
            format!("{}:{} {}: {}", place.file, place.column, f.code, f.message)
        };
        let lines = findings.map(line);
        lines
            .filter(|line| !line.starts_with("s.xml"))
            .collect::<Vec<_>>()
    };
    let type_told = "1.yaml:78 bad-parameter-value: `1.5` of the parameter `a/b` of `Sine0` is no value of its type `int` (as it is of 2 more)";
    let first = "1.yaml:67 value-outside-constraint: `20` of the parameter `gain` of `Sine0` is outside its constraint (as it is of";
    assert_eq!(
        told(&[all]),
        [format!("{first} 2 more)"), type_told.to_owned()]
    );
    assert_eq!(
        told(&[all, some]),
        [format!("{first} 1 more)"), type_told.to_owned()]
    );
    assert_eq!(told(&[some]), [] as [String; 0]);
}

#[test]
fn what_is_only_kept_is_told_and_kept() {
    let spec = "{types: {SineSource: {package: sine, version: '1.2', standIn: true}}, \
                components: {Sine0: {resources: {cpus: '3,1-2', realtimePriority: 50, lockMemory: true, required: false, \
                memoryLimit: 256MiB}, standIn: never}}}";
    let loaded = laid(&[spec]).unwrap();
    let codes: Vec<_> = loaded
        .report
        .findings
        .iter()
        .map(|f| (f.code.as_str(), f.place.as_ref().unwrap().column))
        .collect();
    assert_eq!(codes.len(), 3, "{codes:?}");
    assert!(codes.iter().all(|(code, _)| *code == "not-carried-out"));
    let sine = &loaded.spec.components[0];
    let kept = serde_json::json!([sine.package, sine.stand_in, sine.resources]);
    let expected = serde_json::json!([
        {"name": "sine", "version": "1.2"},
        {"when": "never"},
        {"cpus": "1-3", "realtimePriority": 50, "lockMemory": true, "required": false, "memoryLimitBytes": 268_435_456},
    ]);
    assert_eq!(kept, expected);
}

#[test]
fn a_stand_in_is_said_in_a_word_or_with_what_it_does() {
    let specs = [
        "{types: {SineSource: {standIn: {when: missing, startupTime: 2s}}}}",
        "{components: {Sine0: {standIn: always}, Filter0: {standIn: {fail: activate}}}}",
        "{components: {Sine0: {standIn: {startupTime: null, crashAfter: 5s}}}}",
    ];
    let loaded = laid(&specs).unwrap();
    assert_eq!(loaded.report, Report::default());
    let said = |index: usize| serde_json::json!(loaded.spec.components[index].stand_in);
    let sine = serde_json::json!({"when": "always", "crashAfterMs": 5000});
    assert_eq!(said(0), sine);
    assert_eq!(said(1), serde_json::json!({"fail": "activate"}));
}

#[test]
fn orders_are_conditions_with_their_place() {
    let spec = "
  order:
    activation:
      - {component: Sine0, after: '*', timeout: 2s}
      - {component: '*', before: [Printer0], timing: async}
    shutDown: {component: Printer0, wait: 1.5s, sequence: 3}";
    let loaded = laid(&[spec]).unwrap();
    assert_eq!(loaded.report, Report::default());
    let orders = &loaded.spec.orders;
    let said = |c: &rts_schemas::system::Condition| {
        let number = match c.sequence {
            NO_SEQUENCE => "-".to_owned(),
            number => number.to_string(),
        };
        let wait = match &c.wait {
            None => String::new(),
            Some(WaitFor::Time { milliseconds }) => format!("sleeps {milliseconds}"),
            Some(WaitFor::Preceding {
                timing,
                timeout_ms,
                components,
            }) => {
                format!("{timing:?} {timeout_ms} {}", components.join(" "))
            }
        };
        format!("{} {number} {wait}", c.target)
    };
    // Three are the profile's own.
    let all: Vec<_> = orders
        .activation
        .iter()
        .skip(3)
        .chain(&orders.shut_down)
        .map(said)
        .collect();
    assert_eq!(
        all,
        [
            "Sine0 - Sync 2000 Filter0 Printer0",
            "Printer0 - Async 0 Sine0 Filter0",
            "Printer0 - sleeps 1500",
            "Printer0 3 ",
        ]
    );
    let line = |pointer: &str| {
        let place = loaded.places.find(pointer).unwrap();
        format!("{}:{}", place.file, place.line)
    };
    assert_eq!(line("/orders/activation/4"), "1.yaml:7");
    assert_eq!(line("/orders/shutDown/0"), "1.yaml:8");
    assert_eq!(line("/components/0"), "system.xml:10");
}

/// What overlays said is in the profile that is written of the system.
#[test]
fn an_export_needs_no_overlay() {
    let spec = "
  types: {SineSource: {package: sine, standIn: missing, resources: {cpus: 1}}}
  components: {'*0': {node: arm, configuration: {sets: {default: {gain: 2}}}}}
  order: {activation: {component: '*', before: Printer0}}";
    let laid = laid(&[spec]).unwrap().spec;
    let options = WriteOptions {
        created: "2026-01-15T10:00:00",
        updated: "2026-01-15T10:00:00",
        abstract_text: "",
    };
    let text = write(&laid, &options);
    let again = load_with_places("again.xml", text.as_bytes(), None, &[]).unwrap();
    let host = |spec: &SystemSpec| spec.components[0].placement.host.clone();
    assert_eq!(host(&laid).as_deref(), Some("Robot1.local"));
    assert_eq!(again.spec, sayable(&laid));
    let codes: Vec<_> = again
        .report
        .findings
        .iter()
        .map(|f| f.code.as_str())
        .collect();
    assert_eq!(codes, ["not-carried-out"]);
}

/// So a fault that the controller finds is shown where it was said last.
#[test]
fn what_is_laid_has_its_place_in_the_overlay() {
    let one = "{defaults: {node: a, configuration: {active: default}}}";
    let other = "\n  components:\n    Filter0: {node: b}";
    let loaded = laid(&[one, other]).unwrap();
    let at = |pointer: &str| {
        let place = loaded.places.find(pointer).unwrap();
        format!("{}:{}:{}", place.file, place.line, place.column)
    };
    assert_eq!(at("/components/0/placement/node"), "1.yaml:3:25");
    assert_eq!(at("/components/1/placement/node"), "2.yaml:5:21");
    assert_eq!(at("/components/1/configuration/active"), "1.yaml:3:52");
    assert_eq!(at("/components/1/type"), "system.xml:25:17");
}

/// Globs on both sides multiply.
#[test]
fn a_rule_that_makes_too_many_pairs_is_refused() {
    let component = |n: usize| {
        format!(
            r#"<rts:Components rts:instanceName="C{n}" rts:id="RTC:v:c:T:1.0" rts:pathUri="x"/>"#
        )
    };
    let all: String = (0..400).map(component).collect();
    let profile = format!(
        r#"<rts:RtsProfile xmlns:rts="http://www.openrtp.org/namespaces/rts" rts:id="RTSystem:v:s:1.0" rts:version="0.2">{all}</rts:RtsProfile>"#
    );
    let text = "apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec: {order: {activation: {component: '*', after: 'C*'}}}\n";
    let overlay = overlay::read("o.yaml", text.as_bytes()).unwrap();
    let report = load_with_places("s.xml", profile.as_bytes(), None, &[overlay]).unwrap_err();
    let codes: Vec<_> = report
        .findings
        .iter()
        .filter(|f| f.code == "too-many-entries")
        .collect();
    assert_eq!(codes.len(), 1, "{report:?}");
    let types: String = (0..1001).map(|n| format!("    '*{n}': {{}}\n")).collect();
    let text =
        format!("apiVersion: rtsctl.dev/v1\nkind: Deployment\nspec:\n  components:\n{types}");
    let overlay = overlay::read("o.yaml", text.as_bytes()).unwrap();
    let all: String = (0..1001).map(component).collect();
    let profile = profile.replace(&component(0), &all);
    let report = load_with_places("s.xml", profile.as_bytes(), None, &[overlay]).unwrap_err();
    assert!(report.findings.iter().any(|f| f.code == "too-many-entries"));
}
