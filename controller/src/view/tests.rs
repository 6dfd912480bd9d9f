use rts_controller_api::objects::{Metadata, NodeSpecView, NodeStatus};

use super::*;

fn node(name: &str, state: &str, seen: i64) -> Node {
    Node {
        api_version: API_VERSION.into(),
        kind: Kind::Node,
        metadata: Metadata {
            name: name.into(),
            ..Metadata::default()
        },
        spec: NodeSpecView::default(),
        status: NodeStatus {
            state: state.into(),
            last_seen: jiff::Timestamp::from_second(seen).ok(),
            ..NodeStatus::default()
        },
    }
}

#[test]
fn a_counter_raises_no_version_but_is_shown() {
    let view = View::new(10);
    view.replace([node("a", "Ready", 1)]);
    let first = view.list::<Node>();
    view.replace([node("a", "Ready", 2)]);
    let second = view.list::<Node>();
    assert_eq!(first.metadata, second.metadata);
    assert_eq!(
        second.items[0].status.last_seen,
        jiff::Timestamp::from_second(2).ok()
    );
    assert_eq!(view.changes(Kind::Node, 11).unwrap().0.len(), 0);
}

#[test]
fn changes_come_in_order_and_a_deletion_has_a_version_of_its_own() {
    let view = View::new(10);
    view.replace([node("a", "Ready", 1), node("b", "Ready", 1)]);
    view.replace([node("a", "Unknown", 1)]);
    let (changes, upto) = view.changes(Kind::Node, 10).unwrap();
    let text: Vec<_> = changes
        .iter()
        .map(|c| format!("{} {}", c.revision, &c.json(true)[..19]))
        .collect();
    assert_eq!(upto, 14);
    insta::assert_snapshot!(text.join("\n"), @r#"
    11 {"type":"ADDED","re
    12 {"type":"ADDED","re
    13 {"type":"MODIFIED",
    14 {"type":"DELETED","
    "#);
}

#[test]
fn versions_too_old_or_from_the_future_are_410() {
    let view = View::new(10);
    for i in 0..RING + 2 {
        view.replace([node("a", &i.to_string(), 1)]);
    }
    assert_eq!(view.changes(Kind::Node, 10).unwrap_err().status, 410);
    assert_eq!(view.changes(Kind::Node, 11).unwrap_err().status, 410);
    assert_eq!(view.changes(Kind::Node, 12).unwrap().0.len(), RING);
    assert_eq!(
        view.changes(Kind::Node, 1 << 40).unwrap_err().code,
        "expired"
    );
}

#[test]
fn the_event_log_is_bounded() {
    let view = View::new(0);
    for i in 0..EVENTS + 5 {
        let happening = Happening::normal("Created", "component/A0", format!("number {i}"));
        view.record(happening, jiff::Timestamp::UNIX_EPOCH);
    }
    let list = view.events();
    assert_eq!(list.items.len(), EVENTS);
    assert_eq!(list.items[0].spec.message, "number 5");
}
