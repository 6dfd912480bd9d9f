use rts_plan::plan::*;
use rts_schemas::system::{DriftPolicy, SystemSpec};

use super::own::{self, restarts};
use super::samples::result;
use super::*;

#[test]
fn the_text_ends_with_the_summary() {
    insta::assert_snapshot!(
        "steps",
        text(&result().plan, View::Steps { all: false }, false)
    );
    insta::assert_snapshot!("lines", text(&result().plan, View::Lines, false));
}

#[test]
fn many_steps_are_listed_only_when_asked_for() {
    let mut plan = result().plan;
    let last = plan.steps[1].clone();
    plan.steps
        .extend((3..=51).map(|id| Step { id, ..last.clone() }));
    let few = text(&plan, View::Steps { all: false }, false);
    assert!(few.contains("51 steps: `--steps` lists them\n"), "{few}");
    assert!(!few.contains("StartManager"), "{few}");
    let all = text(&plan, View::Steps { all: true }, false);
    assert!(all.contains("51    Activate"), "{all}");
}

#[test]
fn colour_only_adds_to_the_text() {
    let view = View::Steps { all: false };
    let colored = text(&result().plan, view, true);
    assert!(
        colored.contains("\u{1b}[32m+\u{1b}[0m component/Sine0"),
        "{colored:?}"
    );
    let plain = anstream::adapter::strip_str(&colored).to_string();
    assert_eq!(plain, text(&result().plan, view, false));
}

fn hello() -> SystemSpec {
    let text = include_bytes!("../../../../manifests/hello/system.xml");
    rts_schemas::rts_profile::load("hello.xml", text, None, &[])
        .unwrap()
        .0
}

#[test]
fn what_waits_is_a_difference_and_what_others_wait_for_is_not() {
    let mut plan = Plan::default();
    assert!(!concerns(&plan, &hello()));
    let waits = |target: &str| WaitingOn {
        target: target.to_owned(),
        reason: "its module failed".to_owned(),
        transient: false,
    };
    plan.waiting_on = vec![waits("component/Elsewhere0"), waits("manager/other.main")];
    assert!(!concerns(&plan, &hello()));
    for target in [
        "component/Sine0",
        "manager/hello.main",
        "package/Printer@local",
        "node/local",
        "module/Printer@hello.main",
    ] {
        plan.waiting_on = vec![waits(target)];
        assert!(concerns(&plan, &hello()), "{target}");
    }
    assert!(concerns(&result().plan, &hello()));
}

#[test]
fn what_may_stay_as_a_person_made_it_is_no_difference() {
    let drift = |policy, field: &str| Drift {
        target: "component/Sine0".to_owned(),
        system: "hello".to_owned(),
        policy,
        kind: DriftKind::Changed,
        reason: "was changed by hand".to_owned(),
        fields: vec![FieldChange {
            field: field.to_owned(),
            old: Some("1".to_owned()),
            new: Some("2".to_owned()),
        }],
    };
    let differs = |drift| {
        let plan = Plan {
            drift: vec![drift],
            ..Plan::default()
        };
        concerns(&plan, &hello())
    };
    assert!(!differs(drift(
        DriftPolicy::Ignore,
        "configuration.default.a"
    )));
    assert!(differs(drift(
        DriftPolicy::Adopt,
        "configuration.default.a"
    )));
    assert!(differs(drift(
        DriftPolicy::Repair,
        "configuration.default.a"
    )));
    assert!(!differs(drift(DriftPolicy::Adopt, "state")));
    let other = Drift {
        system: "other".to_owned(),
        ..drift(DriftPolicy::Adopt, "rate")
    };
    assert!(!differs(other));
}

#[test]
fn only_own_drift_and_remarks_are_shown() {
    let drift = |system: &str| Drift {
        target: "component/Sine0".to_owned(),
        system: system.to_owned(),
        policy: DriftPolicy::Ignore,
        kind: DriftKind::Changed,
        reason: "was configured by hand".to_owned(),
        fields: Vec::new(),
    };
    let mut result = result();
    let own = [
        "made by hand in manager hello.main on local: A; is left alone",
        "manager probe on local was started by hand: it is left alone",
        "service connector c of system hello: is declared",
        "the stored system with it",
    ];
    let others = [
        "made by hand in manager other.main on local: A; is left alone",
        "service connector c of system other: is declared",
    ];
    result.plan.drift = vec![drift("hello"), drift("other")];
    let notes = own.iter().chain(&others).map(|note| (*note).to_owned());
    result.plan.notes = notes.collect();
    result.notes.clone_from(&result.plan.notes);
    let shown = own::of(&result, &hello());
    assert_eq!(shown.plan.drift, [drift("hello")]);
    assert_eq!(shown.plan.notes, own);
    assert_eq!(shown.notes, own);
    assert_eq!(shown.plan.steps, result.plan.steps);
}

#[test]
fn only_own_restarts_are_told() {
    let restart = |manager: &str| Restart {
        node: "local".to_owned(),
        manager: manager.to_owned(),
        pid: Some(7),
        components: vec!["Sine0".to_owned()],
        also_stopped: Vec::new(),
        connectors: vec!["Sine0.out-Filter0.in".to_owned()],
        affected: Vec::new(),
        reason: "type changed".to_owned(),
    };
    let plan = Plan {
        restarts: vec![restart("hello.main"), restart("hello2.main")],
        ..Plan::default()
    };
    let lines = restarts(&plan, &hello());
    insta::assert_snapshot!("restarts", lines.join("\n"));
}

#[test]
fn json_has_what_scripts_rely_on() {
    insta::assert_snapshot!("json", format!("{:#}", document::of(&result())));
}

#[test]
fn yaml_is_the_same_document() {
    let document = document::of(&result());
    let read: serde_json::Value = serde_yaml::from_str(&yaml(&document).unwrap()).unwrap();
    assert_eq!(read, document);
}
