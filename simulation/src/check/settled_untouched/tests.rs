use rts_schemas::system::SystemSpec;

use super::*;
use crate::check::fixtures::{
    activated, blemished, connected, connector, created, deleted, desired_acked, disconnected,
    ended, hello, see, state, subject,
};

fn spec() -> SystemSpec {
    let mut spec = hello(&["A", "B"]);
    spec.connectors = vec![connector("A.out-B.in", "A", "B")];
    spec
}

fn both() -> (Subject, Subject) {
    (subject("A", "node1", "p1"), subject("B", "node1", "p2"))
}

/// What is said when this happens to the running system, after this was asked for.
fn verdict(ask: impl FnOnce(&Desired), then: &[Happened]) -> Option<String> {
    let verdicts = Verdicts::default();
    let mut desired = Desired::default();
    let mut witness = SettledUntouched::new(desired.clone(), verdicts.clone());
    desired.asked(&spec());
    let (a, b) = both();
    let up = [
        desired_acked(Some(1)),
        created(&a),
        created(&b),
        connected(&a, "A.out-B.in"),
        activated(&a),
        activated(&b),
    ];
    see(&mut desired, &up);
    see(&mut witness, &up);
    desired.converged();
    ask(&desired);
    see(&mut witness, then);
    verdicts.first().map(|violation| violation.to_string())
}

fn nothing(_: &Desired) {}

fn deactivated(of: &Subject) -> Happened {
    state(of, "Active", "Inactive", Cause::Asked)
}

#[test]
fn every_way_to_touch_what_is_well_is_named() {
    let (a, b) = both();
    assert_eq!(
        verdict(nothing, &[deactivated(&b)]).unwrap(),
        "at 0.000 s, settled-untouched: component B of hello on node1: it was deactivated, though it was Active, no \
         fault had hit it, and nobody had asked for a change of it"
    );
    let ways = [
        (vec![deleted(&a, Cause::Asked)], "it was deleted"),
        (
            vec![ended("node1", "p1", Cause::Asked)],
            "its process was ended",
        ),
        (
            vec![disconnected(&a, "A.out-B.in", Cause::Asked)],
            "its connector A.out-B.in was cut",
        ),
    ];
    for (all, deed) in ways {
        let text = verdict(nothing, &all).unwrap();
        assert!(text.contains(deed), "{text}");
    }
    let at_once = verdict_at_once(&[deleted(&a, Cause::Died), ended("node1", "p1", Cause::Asked)]);
    assert!(at_once.unwrap().contains("its process was ended"));
}

/// All of it at the same time.
fn verdict_at_once(all: &[Happened]) -> Option<String> {
    let verdicts = Verdicts::default();
    let mut desired = Desired::default();
    desired.asked(&spec());
    let mut witness = SettledUntouched::new(desired.clone(), verdicts.clone());
    let (a, b) = both();
    let up = [created(&a), created(&b), activated(&a), activated(&b)];
    see(&mut desired, &up);
    see(&mut witness, &up);
    for what in all {
        witness.see(Duration::from_secs(9), what);
    }
    verdicts.first().map(|violation| violation.to_string())
}

#[test]
fn faults_and_what_is_done_about_them_are_no_disturbance() {
    let (a, b) = both();
    let good: [&[Happened]; 5] = [
        &[
            state(&b, "Active", "Error", Cause::Fault),
            deleted(&b, Cause::Asked),
        ],
        &[
            ended("node1", "p2", Cause::Died),
            disconnected(&a, "A.out-B.in", Cause::Asked),
        ],
        &[blemished("p2", None), deactivated(&b)],
        &[
            blemished("p1", Some("A")),
            ended("node1", "p1", Cause::Asked),
        ],
        &[disconnected(&a, "A.out-B.in", Cause::Died)],
    ];
    for all in good {
        assert_eq!(verdict(nothing, all), None, "{all:?}");
    }
}

#[test]
fn what_was_asked_for_is_done() {
    let (a, b) = both();
    let mut changed = spec();
    changed.components[1].configuration.active = Some("fast".to_owned());
    let change = |desired: &Desired| desired.asked(&changed);
    assert_eq!(verdict(change, &[deactivated(&b)]), None);
    let other = verdict(change, &[deactivated(&a)]);
    assert!(other.unwrap().contains("component A"), "only B was changed");
    let end = |desired: &Desired| desired.deletion_asked("hello");
    let all = [
        deactivated(&a),
        disconnected(&a, "A.out-B.in", Cause::Asked),
    ];
    assert_eq!(verdict(end, &all), None);
    let module = |desired: &Desired| desired.module_changed("Any");
    assert_eq!(verdict(module, &[ended("node1", "p1", Cause::Asked)]), None);
    let hand = |desired: &Desired| desired.by_hand("B");
    assert_eq!(verdict(hand, &[deactivated(&b)]), None);
    let mut unplugged = spec();
    unplugged.connectors.clear();
    let unplug = |desired: &Desired| desired.asked(&unplugged);
    assert_eq!(
        verdict(unplug, &[disconnected(&a, "A.out-B.in", Cause::Asked)]),
        None
    );
}

#[test]
fn who_goes_for_want_of_a_peer_takes_its_own_peers_along() {
    let (_, b) = both();
    let c = subject("C", "node1", "p1");
    let mut chain = hello(&["A", "B", "C"]);
    chain.connectors = vec![
        connector("C.out-A.in", "C", "A"),
        connector("A.out-B.in", "A", "B"),
    ];
    let verdict = |strict: &[usize]| {
        let mut spec = chain.clone();
        for at in strict {
            spec.components[*at].policy.on_disconnect = OnDisconnect::Stop;
        }
        let ask = |desired: &Desired| {
            desired.asked(&spec);
            let mut desired = desired.clone();
            see(&mut desired, &[desired_acked(Some(2))]);
            desired.converged();
        };
        let all = [
            created(&c),
            activated(&c),
            connected(&c, "C.out-A.in"),
            state(&b, "Active", "Error", Cause::Fault),
            deactivated(&c),
        ];
        verdict(ask, &all)
    };
    assert_eq!(verdict(&[0, 2]), None, "A goes, and so C does");
    assert!(verdict(&[2]).is_some(), "A stays");
    assert!(verdict(&[0]).is_some(), "C stays without A");
}

#[test]
fn who_needs_a_peer_goes_when_that_is_lost() {
    let (a, b) = both();
    let mut strict = spec();
    strict.components[0].policy.on_disconnect = OnDisconnect::Deactivate;
    let ask = |desired: &Desired| {
        desired.asked(&strict);
        let mut desired = desired.clone();
        see(&mut desired, &[desired_acked(Some(2))]);
        desired.converged();
    };
    let lost = [state(&b, "Active", "Error", Cause::Fault), deactivated(&a)];
    assert_eq!(verdict(ask, &lost), None);
    assert!(verdict(ask, &[deactivated(&a)]).is_some());
}
