//! One plan that has everything, in every form.

use std::collections::BTreeMap;

use rts_schemas::system::{
    Configuration, ConnectorSpec, DriftPolicy, ExecutionKind, OnDisconnect, PortKind, PortRef,
};

use super::*;
use crate::desired::{EndPlace, ManagerKey, PlacedConnector, SystemRef};
use crate::plan::*;

pub(crate) fn plan() -> Plan {
    let mut steps = vec![
        step(
            1,
            "manager/hello.main",
            Work::StartManager { manager: key() },
        ),
        step(2, "component/Sine0", create()),
        step(3, "connector/Sine0.out-Filter0.in", connect()),
        step(
            4,
            "component/Filter0",
            Work::Activate {
                manager: key(),
                instance: "Filter0".to_owned(),
            },
        ),
        step(
            5,
            "component/Sine0",
            Work::Activate {
                manager: key(),
                instance: "Sine0".to_owned(),
            },
        ),
    ];
    steps[1].needs = vec![1];
    steps[2].needs = vec![2];
    steps[3].after_start_of = vec![2];
    steps[3].node = "other \"node\"".to_owned();
    steps[4].needs = vec![3];
    steps[4].after_end_of = vec![4];
    steps[4].wait_ms = 1500;
    let ms = 500;
    steps[4].limits = vec![Limit {
        steps: vec![4],
        ms,
        then: OnTimeout::Fail,
    }];
    let order = OrderName::Activation;
    steps[4].because = vec![Because {
        step: 4,
        rule: Rule::Sequence { order },
    }];
    let critical_path = crate::critical_path(&steps);
    Plan {
        changes: changes(),
        restarts: vec![restart()],
        waiting_on: vec![WaitingOn {
            target: "component/Motor0".to_owned(),
            reason: "no module of type Motor".to_owned(),
            transient: false,
        }],
        drift: drift(),
        notes: vec!["host h is node local".to_owned()],
        critical_path,
        steps,
    }
}

fn key() -> ManagerKey {
    let system = SystemRef {
        name: "hello".to_owned(),
        uid: "u".to_owned(),
    };
    ManagerKey {
        system: Some(system),
        name: "main".to_owned(),
    }
}

fn step(id: StepId, target: &str, work: Work) -> Step {
    Step {
        system: key().system,
        reason: "is not there yet".to_owned(),
        ..Step::new(id, "local", target, work)
    }
}

fn create() -> Work {
    let values = [
        ("amplitude", "1.0"),
        ("label", "a \u{1b}[31m, b"),
        ("rate", "3"),
    ];
    let values = values.map(|(k, v)| (k.to_owned(), v.to_owned()));
    Work::Create {
        manager: key(),
        instance: "Sine0".to_owned(),
        type_name: "SineSource".to_owned(),
        recreate_hash: String::new(),
        configuration: Configuration {
            active: Some("fast".to_owned()),
            sets: BTreeMap::from([("default".to_owned(), BTreeMap::from(values))]),
        },
        execution_kind: ExecutionKind::Periodic,
        execution_context: None,
        rate: Some(100.0),
        on_disconnect: OnDisconnect::Deactivate,
        stand_in: None,
        realtime: None,
    }
}

fn connect() -> Work {
    let end = |instance: &str, port: &str| PortRef {
        instance: instance.to_owned(),
        port: port.to_owned(),
    };
    let properties = [
        ("dataport.buffer.length", "16"),
        ("dataport.dataflow_type", "push"),
        ("dataport.interface_type", "data_service"),
        ("dataport.subscription_type", "flush"),
    ];
    let place = EndPlace {
        node: "local".to_owned(),
        manager: "main".to_owned(),
    };
    Work::Connect {
        connector: PlacedConnector {
            spec: ConnectorSpec {
                name: "Sine0.out-Filter0.in".to_owned(),
                kind: PortKind::Data,
                source: end("Sine0", "out"),
                target: end("Filter0", "in"),
                data_type: Some("IDL:RTC/TimedLong:1.0".to_owned()),
                properties: properties.map(|(k, v)| (k.to_owned(), v.to_owned())).into(),
            },
            source: place.clone(),
            target: place,
            undetermined: None,
        },
    }
}

fn change(
    action: Action,
    target: &str,
    reason: &str,
    fields: &[(&str, Option<&str>, Option<&str>)],
) -> Change {
    let text = |value: &Option<&str>| value.map(str::to_owned);
    let fields = fields.iter().map(|(field, old, new)| FieldChange {
        field: (*field).to_owned(),
        old: text(old),
        new: text(new),
    });
    Change {
        action,
        target: target.to_owned(),
        system: Some("hello".to_owned()),
        node: target.starts_with("manager/").then(|| "local".to_owned()),
        reason: reason.to_owned(),
        fields: fields.collect(),
    }
}

fn changes() -> Vec<Change> {
    let new = "is not there yet";
    let property = "properties.dataport.subscription_type";
    vec![
        change(
            Action::Change,
            "component/Filter0",
            "gain changed from 1.0 to 2.0: set in place",
            &[
                ("configuration.default.gain", Some("1.0"), Some("2.0")),
                ("rate", Some("10"), Some("20")),
            ],
        ),
        change(
            Action::Add,
            "component/Motor0",
            "is not there yet; blocked: no module of type Motor",
            &[("type", None, Some("Motor"))],
        ),
        change(
            Action::Restart,
            "component/Printer0",
            "type changed from A to B",
            &[("type", Some("A"), Some("B"))],
        ),
        change(Action::Add, "component/Sine0", new, &[]),
        change(
            Action::Change,
            "connector/Filter0.out-Printer0.in",
            &format!("{property} changed: connected anew"),
            &[
                (
                    "dataType",
                    Some("IDL:RTC/TimedLong:1.0"),
                    Some("IDL:RTC/TimedDouble:1.0"),
                ),
                (property, None, Some("new")),
            ],
        ),
        change(Action::Add, "connector/Sine0.out-Filter0.in", new, &[]),
        change(
            Action::Remove,
            "connector/Sine0.out-Old0.in",
            "is not in the system any more",
            &[("properties.dataport.dataflow_type", Some("push"), None)],
        ),
        change(Action::Add, "manager/hello.main", "is not running", &[]),
    ]
}

fn restart() -> Restart {
    let affected = |instance: &str, starved| Affected {
        instance: instance.to_owned(),
        node: "local".to_owned(),
        manager: "hello.main".to_owned(),
        starved,
    };
    Restart {
        node: "local".to_owned(),
        manager: "hello.Printer0".to_owned(),
        pid: Some(7),
        components: vec!["Printer0".to_owned()],
        also_stopped: vec!["Motor0".to_owned()],
        connectors: vec!["Filter0.out-Printer0.in".to_owned()],
        affected: vec![affected("Filter0", false), affected("Logger0", true)],
        reason: "type changed from A to B".to_owned(),
    }
}

fn drift() -> Vec<Drift> {
    let of = |target: &str, policy, kind, reason: &str, fields| Drift {
        target: target.to_owned(),
        system: "hello".to_owned(),
        policy,
        kind,
        reason: reason.to_owned(),
        fields,
    };
    let gain = FieldChange {
        field: "configuration.default.gain".to_owned(),
        old: Some("1.0".to_owned()),
        new: Some("2.0".to_owned()),
    };
    let (changed, missing) = (DriftKind::Changed, DriftKind::Missing);
    vec![
        of(
            "component/Filter0",
            DriftPolicy::Ignore,
            changed,
            "was configured by hand",
            vec![gain],
        ),
        of(
            "connector/A.o-B.i",
            DriftPolicy::Repair,
            missing,
            "was disconnected by hand",
            Vec::new(),
        ),
    ]
}

#[test]
fn as_blocks_and_as_lines() {
    insta::assert_snapshot!("blocks", render(&plan()));
    let lines = Layout {
        width: 140,
        inline: usize::MAX,
        ..Layout::default()
    };
    insta::assert_snapshot!("lines", render_with(&plan(), &lines));
}

#[test]
fn as_graphs() {
    insta::assert_snapshot!("dot", dot::render(&plan()));
    insta::assert_snapshot!("mermaid", mermaid::render(&plan()));
}

#[test]
fn what_stands_before_a_step_is_said_in_few_words() {
    let plan = plan();
    let after: Vec<String> = plan.steps.iter().map(after).collect();
    assert_eq!(
        after,
        [
            "",
            "1",
            "2",
            "start of 2",
            "3; end of 4; waits 1.5 s; at most 500 ms for 4, then fails"
        ]
    );
    let path = critical_path(&plan);
    assert_eq!(
        path.as_deref(),
        Some("critical path: 1 → 2 → 3 → 5 (4 steps, waits 1.5 s)")
    );
}

#[test]
fn two_systems_and_a_stray_are_told_apart() {
    let mut plan = plan();
    plan.changes.truncate(3);
    plan.changes[1].system = Some("other".to_owned());
    plan.changes[2].system = None;
    let text = render(&plan);
    let headings: Vec<&str> = text.lines().filter(|line| line.ends_with(':')).collect();
    assert_eq!(
        headings,
        ["system hello:", "system other:", "of no system:"]
    );
}

#[test]
fn managers_of_one_name_on_two_nodes_are_told_apart() {
    let mut plan = plan();
    let is_start = |step: &&Step| matches!(step.work, Work::StartManager { .. });
    let mut other = plan.steps.iter().find(is_start).unwrap().clone();
    other.node = "arm".to_owned();
    plan.steps.push(other);
    let added = plan
        .changes
        .iter()
        .find(|c| c.target == "manager/hello.main");
    let mut added = vec![added.unwrap().clone(); 2];
    added[0].node = Some("arm".to_owned());
    plan.changes = added;
    let text = render(&plan);
    let lines: Vec<&str> = text.lines().take(2).collect();
    assert!(
        lines[0].contains("arm") && !lines[0].contains("local"),
        "{text}"
    );
    assert!(
        lines[1].contains("local") && !lines[1].contains("arm"),
        "{text}"
    );
}

#[test]
fn paint_touches_only_signs_and_heads() {
    let paint = |tone: Tone, text: &str| format!("<{tone:?}>{text}</>");
    let painted = render_with(
        &plan(),
        &Layout {
            paint: &paint,
            ..Layout::default()
        },
    );
    assert!(painted.contains("<Add>+</> component/Sine0"), "{painted}");
    assert!(
        painted.contains("<Restart>restarts:</> process hello.Printer0"),
        "{painted}"
    );
    let without = ["Add", "Change", "Remove", "Restart", "Attention", "Heading"];
    let bare = without
        .iter()
        .fold(painted, |text, tone| text.replace(&format!("<{tone}>"), ""));
    assert_eq!(bare.replace("</>", ""), render(&plan()));
}

#[test]
fn every_step_is_explained() {
    let plan = plan();
    let told = plan
        .steps
        .iter()
        .filter_map(|s| crate::explain::explain(&plan, s.id));
    let told: Vec<String> = told.map(|it| crate::explain::render_step(&it)).collect();
    assert_eq!(told.len(), plan.steps.len());
    insta::assert_snapshot!("explained", told.join("\n"));
    assert_eq!(crate::explain::explain(&plan, 0), None);
    assert_eq!(crate::explain::explain(&plan, 6), None);
}

#[test]
fn a_target_that_waits_is_explained_too() {
    let plan = plan();
    let told = |target| crate::explain::explain_target(&plan, target);
    let motor = crate::explain::render_target(&told("component/Motor0").unwrap());
    let filter = crate::explain::render_target(&told("component/Filter0").unwrap());
    let printer = crate::explain::render_target(&told("component/Printer0").unwrap());
    insta::assert_snapshot!("targets", format!("{motor}\n{filter}\n{printer}"));
    assert_eq!(told("component/Nobody0"), None);
}

/// A plan may come from a file that somebody wrote.
#[test]
fn a_plan_that_makes_no_sense_is_explained_without_end_or_panic() {
    let mut plan = plan();
    plan.steps[0].needs = vec![1, 2, 4_000_000_000];
    plan.steps[4].id = 4_000_000_000;
    plan.steps[1].after_end_of = vec![5, 0];
    plan.critical_path = vec![0, 9, 4_000_000_000];
    for id in [0, 1, 2, 3, 4, 5, 4_000_000_000] {
        let _ = crate::explain::explain(&plan, id);
    }
    for target in ["component/Sine0", "manager/hello.main"] {
        assert!(crate::explain::explain_target(&plan, target).is_some());
    }
    assert!(critical_path(&plan).is_some());
    assert!(dot::render(&plan).ends_with("}\n"));
}
