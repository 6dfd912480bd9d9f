//! Marks of what a person changed by hand: kept, reported, and ended by what a plan does.

#![allow(
    clippy::unwrap_used,
    reason = "a failure here is a failed test; clippy only knows test functions"
)]

mod support;

use std::collections::BTreeMap;

use rts_manager_api::client::Client;
use rts_manager_api::control::*;
use support::*;

fn marks(client: &mut Client) -> String {
    let component = component(client, "A");
    let marks = component.by_hand.expect("it reports marks");
    let made = component.connectors.iter();
    let made: Vec<_> = made.map(|c| (&c.name, &c.by_hand)).collect();
    format!(
        "{} configured {:?} deactivated {:?} disconnected {:?} made {made:?}",
        component.state, marks.configured, marks.deactivated, marks.disconnected
    )
}

fn configure(sets: &[(&str, &str)], rate: Option<f64>, by_hand: Option<&str>) -> RequestBody {
    let named = !sets.is_empty();
    RequestBody::Configure {
        instance: "A".to_owned(),
        sets: if named {
            default_set(sets)
        } else {
            BTreeMap::new()
        },
        active: None,
        rate,
        on_disconnect: None,
        order: None,
        by_hand: by_hand.map(str::to_owned),
    }
}

#[test]
fn marks_of_a_component_end_when_a_plan_does_the_same() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    manager.create("A", &[]);
    let none = "Inactive configured None deactivated None disconnected {} made []";
    assert_eq!(marks(&mut client), none);

    ok(
        &mut client,
        configure(&[("produce", "1")], None, Some("c1")),
    );
    let configured = none.replace("configured None", r#"configured Some("c1")"#);
    assert_eq!(marks(&mut client), configured);
    // Nothing that a person set is touched by these, or by what is refused.
    ok(&mut client, configure(&[], Some(500.0), None));
    ok(&mut client, on_disconnect("A", "keep"));
    let unknown = configure(&[("nothing", "1")], None, None);
    assert_eq!(
        refused(&mut client, unknown, SOON).code,
        FailureCode::Invalid
    );
    let unknown = configure(&[("nothing", "1")], None, Some("c2"));
    assert_eq!(
        refused(&mut client, unknown, SOON).code,
        FailureCode::Invalid
    );
    assert_eq!(marks(&mut client), configured);
    ok(&mut client, configure(&[("produce", "0")], None, None));
    assert_eq!(marks(&mut client), none);

    ok(&mut client, activate("A"));
    let by_hand = |mark: &str| RequestBody::Deactivate {
        instance: "A".to_owned(),
        by_hand: Some(mark.to_owned()),
    };
    ok(&mut client, by_hand("d1"));
    let deactivated = none.replace("deactivated None", r#"deactivated Some("d1")"#);
    assert_eq!(marks(&mut client), deactivated);
    ok(&mut client, deactivate("A"));
    assert_eq!(marks(&mut client), deactivated);
    ok(&mut client, activate("A"));
    assert_eq!(marks(&mut client), none.replace("Inactive", "Active"));
}

#[test]
fn one_that_goes_to_error_was_not_deactivated() {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    manager.create("A", &[("fail", "on_deactivated")]);
    ok(&mut client, activate("A"));
    let by_hand = RequestBody::Deactivate {
        instance: "A".to_owned(),
        by_hand: Some("d".to_owned()),
    };
    refused(&mut client, by_hand.clone(), SOON);
    ok(&mut client, by_hand);
    let none = "Error configured None deactivated None disconnected {} made []";
    assert_eq!(marks(&mut client), none);
}

/// A manager with A and B, and a request that connects them.
fn pair() -> (Running, Client, ConnectRequest) {
    let manager = start("m");
    let mut client = manager.client();
    ok(&mut client, load_testmod());
    manager.create("A", &[]);
    let target = manager.create("B", &[]);
    let request = connection("A", "B", &target, None);
    (manager, client, request)
}

fn disconnect_by_hand(connector: &str, mark: &str) -> RequestBody {
    RequestBody::Disconnect {
        instance: "A".to_owned(),
        connector: connector.to_owned(),
        by_hand: Some(mark.to_owned()),
    }
}

#[test]
fn marks_of_connectors_end_when_a_plan_does_the_same() {
    let (_manager, mut client, request) = pair();
    let by_hand = |mark: Option<&str>| {
        RequestBody::Connect(ConnectRequest {
            by_hand: mark.map(str::to_owned),
            ..request.clone()
        })
    };
    let none = "Inactive configured None deactivated None disconnected {} made []";
    ok(&mut client, disconnect_by_hand("A.out-B.in", "x"));
    let gone = none.replace("{}", r#"{"A.out-B.in": "x"}"#);
    assert_eq!(marks(&mut client), gone);
    ok(&mut client, disconnect("A", "A.out-B.in"));
    assert_eq!(marks(&mut client), none);

    ok(&mut client, disconnect_by_hand("A.out-B.in", "x"));
    // One that cannot be made ends nothing.
    let mut wrong = request.clone();
    wrong.target_port = "nothing".to_owned();
    refused(&mut client, RequestBody::Connect(wrong), SOON);
    assert_eq!(marks(&mut client), gone);
    ok(&mut client, by_hand(Some("m")));
    let made = |mark| none.replace("[]", &format!(r#"[("A.out-B.in", {mark})]"#));
    assert_eq!(marks(&mut client), made(r#"Some("m")"#));
    // The very same by a plan: nothing is connected anew, but it is the plan's now.
    ok(&mut client, by_hand(None));
    assert_eq!(marks(&mut client), made("None"));
}

#[test]
fn marks_are_forgotten_only_where_they_are_still_these() {
    let (_manager, mut client, request) = pair();
    let made = RequestBody::Connect(ConnectRequest {
        by_hand: Some(String::new()),
        ..request
    });
    ok(&mut client, made);
    ok(&mut client, configure(&[("produce", "1")], None, Some("c")));
    ok(&mut client, disconnect_by_hand("other", "x"));
    let forget = |configured: &str, disconnected: &str, connector: &str| RequestBody::Forget {
        instance: "A".to_owned(),
        by_hand: ByHandInfo {
            configured: Some(configured.to_owned()),
            deactivated: None,
            disconnected: BTreeMap::from([("other".to_owned(), disconnected.to_owned())]),
        },
        connectors: BTreeMap::from([("A.out-B.in".to_owned(), connector.to_owned())]),
    };
    let before = marks(&mut client);
    ok(&mut client, forget("c0", "x0", "m0"));
    assert_eq!(marks(&mut client), before);
    ok(&mut client, forget("c", "x", ""));
    assert_eq!(
        marks(&mut client),
        r#"Inactive configured None deactivated None disconnected {} made [("A.out-B.in", None)]"#
    );
}

#[test]
fn there_is_an_end_to_marks() {
    let (_manager, mut client, _) = pair();
    for number in 0..1024 {
        ok(&mut client, disconnect_by_hand(&format!("c{number}"), "x"));
    }
    ok(&mut client, disconnect_by_hand("c7", "y"));
    let failure = refused(&mut client, disconnect_by_hand("c1024", "x"), SOON);
    assert_eq!(
        (failure.code, failure.message.as_str()),
        (
            FailureCode::Conflict,
            "1024 connectors of A were disconnected by hand already; connect one of them again first"
        )
    );
    ok(&mut client, disconnect("A", "c1024"));
    ok(&mut client, disconnect("A", "c7"));
    ok(&mut client, disconnect_by_hand("c1024", "x"));
}
