use rts_manager_api::control::BindingInfo;

use super::*;

fn manager(pid: u32, name: &str) -> Manager {
    Manager {
        pid,
        ticks: 1,
        folder: "/h/run/local/00000000".into(),
        system: "s".to_owned(),
        uid: "u".to_owned(),
        name: name.to_owned(),
        incarnation: pid.to_string(),
        stopped: false,
    }
}

/// A component that has read so many samples, with so many gaps.
fn component(incarnation: &str, state: &str, received: u64, gaps: u64) -> ComponentInfo {
    let text = serde_json::json!({
        "instance": "x", "typeName": "T", "system": null, "incarnation": incarnation,
        "recreateHash": "", "restarts": 0, "created": "", "state": state, "message": null,
        "sets": {}, "active": "default", "executionKind": "periodic", "rate": 25.0,
        "executions": 0, "ports": [], "connectors": [], "bindings": [],
    });
    let mut info: ComponentInfo = serde_json::from_value(text).unwrap();
    info.bindings.push(BindingInfo {
        connector: "k".to_owned(),
        port: "in".to_owned(),
        source: None,
        connected: true,
        samples_received: received,
        drops: 0,
        gaps,
        latency: None,
    });
    info
}

fn look(managers: Vec<(Manager, Option<Vec<ComponentInfo>>)>, seconds: u64) -> Look {
    Look {
        at: Instant::now() + Duration::from_secs(seconds),
        managers,
        on_time: true,
    }
}

/// What is found when `now` is seen `seconds` after an Active component in process 1 with 5 samples.
fn found(
    now: Vec<(Manager, Option<Vec<ComponentInfo>>)>,
    seconds: u64,
    excuses: &Excuses,
) -> Vec<String> {
    let mut judge = Judge::default();
    let all = Excuses {
        touched: ["x".to_owned()].into(),
        ..Excuses::default()
    };
    let then = component("i", "Active", 5, 0);
    let first = look(vec![(manager(1, "a"), Some(vec![then]))], 0);
    assert!(judge.judge(&first, &all).is_empty());
    judge.judge(&look(now, seconds), excuses)
}

fn one(pid: u32, info: ComponentInfo) -> Vec<(Manager, Option<Vec<ComponentInfo>>)> {
    vec![(manager(pid, "a"), Some(vec![info]))]
}

#[test]
fn who_goes_on_is_fine() {
    let none = Excuses::default();
    assert!(found(one(1, component("i", "Active", 6, 0)), 1, &none).is_empty());
    assert!(found(vec![(manager(1, "a"), None)], 1, &none).is_empty());
}

#[test]
fn whatever_changes_is_found_unless_it_is_excused() {
    let changes = [
        (one(1, component("j", "Active", 6, 0)), 1, "made again"),
        (one(1, component("i", "Inactive", 6, 0)), 1, "is Inactive"),
        (one(1, component("i", "Active", 6, 1)), 1, "lost samples"),
        (one(1, component("i", "Active", 5, 0)), 60, "no sample"),
        (one(2, component("j", "Active", 6, 0)), 1, "has ended"),
        (Vec::new(), 1, "has ended"),
        (
            vec![(manager(1, "a"), Some(Vec::new()))],
            1,
            "has it no more",
        ),
    ];
    let excused = Excuses {
        touched: ["x".to_owned()].into(),
        ..Excuses::default()
    };
    for (now, seconds, what) in changes {
        let said = found(now.clone(), seconds, &Excuses::default()).join("; ");
        assert!(said.contains(what), "{what}: {said}");
        assert!(found(now, seconds, &excused).is_empty(), "{what}");
    }
}

#[test]
fn samples_that_may_be_lost_or_late_excuse_nothing_else() {
    let excuses = Excuses {
        connectors: ["k".to_owned()].into(),
        starved: ["s".to_owned()].into(),
        ..Excuses::default()
    };
    assert!(found(one(1, component("i", "Active", 5, 3)), 60, &excuses).is_empty());
    assert_eq!(
        found(one(1, component("j", "Active", 5, 3)), 60, &excuses).len(),
        1
    );
}

#[test]
fn twins_are_never_excused() {
    let x = || component("i", "Active", 6, 0);
    let excuses = Excuses {
        touched: ["x".to_owned()].into(),
        ..Excuses::default()
    };
    let two = vec![
        (manager(1, "a"), Some(vec![x()])),
        (manager(2, "b"), Some(vec![x()])),
    ];
    let said = found(two, 1, &excuses).join("; ");
    assert!(said.contains("two live incarnations of x"), "{said}");
    let two = vec![(manager(1, "a"), None), (manager(2, "a"), None)];
    let said = found(two, 1, &excuses).join("; ");
    assert!(said.contains("two live processes of one manager"), "{said}");
}

#[test]
fn a_silent_process_is_found_in_the_end_unless_it_is_stopped() {
    let silent = || vec![(manager(1, "a"), None)];
    let mut judge = Judge::default();
    let excuses = Excuses {
        silent: [1].into(),
        ..Excuses::default()
    };
    for seconds in [0, 60] {
        assert!(judge.judge(&look(silent(), seconds), &excuses).is_empty());
    }
    let none = Excuses::default();
    assert!(judge.judge(&look(silent(), 61), &none).is_empty());
    assert_eq!(judge.judge(&look(silent(), 80), &none).len(), 1);
}
