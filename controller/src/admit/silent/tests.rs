use std::collections::BTreeMap;

use rts_schemas::system::{OnDisconnect, OnHang, Orders, RestartPolicy};
use serde_json::json;

use super::*;

fn spec() -> SystemSpec {
    serde_json::from_value(json!({
        "name": "s",
        "components": [
            {"instance": "A0", "type": "T", "configuration": {"sets": {"default": {"gain": "1"}}}},
            {"instance": "B0", "type": "T"}
        ],
        "connectors": [{
            "name": "A0.out-B0.in", "kind": "data",
            "source": {"instance": "A0", "port": "out"}, "target": {"instance": "B0", "port": "in"}
        }],
        "orders": {"activation": [
            {"target": "A0", "sequence": 1},
            {"target": "B0", "sequence": 2, "wait": {
                "kind": "preceding", "timing": "sync", "timeoutMs": 500, "components": ["A0"]
            }}
        ]}
    }))
    .unwrap()
}

fn record(spec: SystemSpec) -> SystemRecord {
    SystemRecord {
        uid: "u".into(),
        generation: 1,
        index: 1,
        spec: spec.into(),
        digests: BTreeMap::new(),
        stand_ins: BTreeMap::new(),
        nodes: Default::default(),
        created: jiff::Timestamp::UNIX_EPOCH,
        deleted: None,
        forgotten: Default::default(),
        places: BTreeMap::new(),
        left: BTreeMap::new(),
    }
}

fn change(action: Action, target: &str, fields: &[&str]) -> Change {
    let field = |name: &&str| changed(name, Some("1".into()), Some("2".into()));
    Change {
        action,
        target: target.into(),
        system: Some("s".into()),
        node: None,
        reason: "because".into(),
        fields: fields.iter().map(field).collect(),
    }
}

/// One line for each change.
fn told(planned: Vec<Change>, edit: impl FnOnce(&mut SystemSpec)) -> String {
    let (old, mut new) = (spec(), spec());
    edit(&mut new);
    let mut plan = Plan {
        changes: planned,
        ..Plan::default()
    };
    tell(&mut plan, &record(old), &record(new));
    let line = |change: &Change| {
        let none = || "none".to_owned();
        let fields = change.fields.iter().map(|f| {
            let (old, new) = (f.old.clone(), f.new.clone());
            format!(
                "{}: {} -> {}",
                f.field,
                old.unwrap_or_else(none),
                new.unwrap_or_else(none)
            )
        });
        let fields = fields.collect::<Vec<_>>().join("; ");
        format!("{:?} {} ({fields})", change.action, change.target)
    };
    plan.changes.iter().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn the_same_is_silent() {
    assert_eq!(told(Vec::new(), |_| {}), "");
}

#[test]
fn policies_orders_and_the_rest_are_told_by_target() {
    let all = told(Vec::new(), |spec| {
        let policy = &mut spec.components[1].policy;
        policy.restart = RestartPolicy::Never;
        policy.on_hang = OnHang::Restart;
        policy.restart_limit = Some(3);
        policy.liveness_timeout_ms = Some(100);
        spec.components[0].required = false;
        spec.components[0].placement.host = Some("elsewhere".into());
        spec.connectors[0].data_type = Some("IDL:RTC/TimedLong:1.0".into());
        spec.orders = Orders::default();
    });
    insta::assert_snapshot!("policies_and_orders", all);
}

#[test]
fn what_a_change_says_is_not_told_twice() {
    let set = |spec: &mut SystemSpec| {
        let sets = &mut spec.components[0].configuration.sets;
        sets.insert(
            "default".into(),
            [("gain".to_owned(), "2".to_owned())].into(),
        );
        spec.components[0].policy.on_disconnect = OnDisconnect::Stop;
        spec.components[0].policy.restart = RestartPolicy::Never;
    };
    let planned = change(
        Action::Change,
        "component/A0",
        &["configuration.default.gain", "onDisconnect"],
    );
    insta::assert_snapshot!(told(vec![planned], set), @"Change component/A0 (configuration.default.gain: 1 -> 2; onDisconnect: 1 -> 2; policy.restart: always -> never)");
    let again = change(Action::Restart, "component/A0", &["type"]);
    insta::assert_snapshot!(told(vec![again], set), @"Restart component/A0 (type: 1 -> 2; policy.restart: always -> never)");
}

#[test]
fn what_comes_and_goes_is_told_where_no_change_says_it() {
    let without = |spec: &mut SystemSpec| {
        spec.connectors.clear();
        spec.components.truncate(1);
    };
    insta::assert_snapshot!(told(Vec::new(), without), @"Change system/s (components: A0, B0 -> A0; connectors: A0.out-B0.in -> none)");
    let gone = |target: &str| change(Action::Remove, target, &[]);
    let planned = vec![gone("component/B0"), gone("connector/A0.out-B0.in")];
    insta::assert_snapshot!("told_removals", told(planned, without));
    insta::assert_snapshot!(told(Vec::new(), |spec| spec.components.reverse()), @"Change system/s (components: A0, B0 -> B0, A0)");
}

#[test]
fn a_long_text_is_cut_and_still_another() {
    let long = told(Vec::new(), |spec| {
        let set = spec.components[0]
            .configuration
            .sets
            .get_mut("default")
            .unwrap();
        set.insert("text".into(), "x".repeat(5000));
    });
    assert!(long.len() < 400, "{long}");
}

#[test]
fn nothing_is_stored_without_a_word() {
    let (old, mut new) = (record(spec()), record(spec()));
    new.digests.insert("T".into(), "d".into());
    let mut plan = Plan::default();
    tell(&mut plan, &old, &new);
    assert_eq!(plan.changes[0].fields[0].field, "modules.T");
    Arc::make_mut(&mut new.spec).components[0]
        .configuration
        .sets
        .insert("empty".into(), BTreeMap::new());
    new.digests.clear();
    let mut plan = Plan::default();
    tell(&mut plan, &old, &new);
    assert_eq!(plan.changes[0].target, "system/s");
}
