use rts_schemas::system::Condition;

use super::*;
use crate::check::fixtures::{
    activated, blemished, created, deleted, desired_acked, ended, hello, see, state, subject,
};

/// A before B, in every way.
fn ordered() -> SystemSpec {
    let mut spec = hello(&["A", "B"]);
    let list = [("A", 1), ("B", 2)].map(|(target, sequence)| Condition {
        target: target.to_owned(),
        sequence,
        wait: None,
    });
    spec.orders.start_up = list.to_vec();
    spec.orders.activation = list.to_vec();
    spec
}

fn verdict(desired: &Desired, all: &[Happened]) -> Option<String> {
    let verdicts = Verdicts::default();
    see(
        &mut Prerequisites::new(desired.clone(), verdicts.clone()),
        all,
    );
    verdicts.first().map(|violation| violation.to_string())
}

fn asked() -> Desired {
    let mut desired = Desired::default();
    desired.asked(&ordered());
    see(&mut desired, &[desired_acked(Some(1))]);
    desired
}

fn both() -> (Subject, Subject) {
    (subject("A", "node1", "p1"), subject("B", "node1", "p2"))
}

#[test]
fn in_order_is_well() {
    let (a, b) = both();
    let all = [created(&a), created(&b), activated(&a), activated(&b)];
    assert_eq!(verdict(&asked(), &all), None);
}

#[test]
fn what_comes_too_early_is_named_with_what_is_missing() {
    let (a, b) = both();
    let early = verdict(&asked(), &[created(&a), created(&b), activated(&b)]);
    assert_eq!(
        early.unwrap(),
        "at 2.000 s, prerequisites: component B of hello on node1: was activated before what Activation puts before \
         it: A is Inactive on node1"
    );
    let early = verdict(&asked(), &[created(&b)]);
    assert_eq!(
        early.unwrap(),
        "at 0.000 s, prerequisites: component B of hello on node1: was created before what StartUp and Initializing \
         put before it: A is not there"
    );
}

#[test]
fn what_died_a_moment_ago_may_not_be_known_yet() {
    let (a, b) = both();
    let up = [created(&a), created(&b), activated(&a)];
    let after = |lost: Happened, pause: usize| {
        let mut all = up.to_vec();
        all.push(lost);
        all.extend((0..pause).map(|_| Happened::Note(String::new())));
        all.push(activated(&b));
        verdict(&asked(), &all)
    };
    let died = || ended("node1", "p1", Cause::Died);
    let error = || state(&a, "Active", "Error", Cause::Fault);
    let stopped = || state(&a, "Active", "Inactive", Cause::Asked);
    assert_eq!(after(died(), 2), None);
    assert_eq!(after(error(), 2), None);
    assert!(after(died(), 40).unwrap().ends_with("A is not there"));
    assert!(after(error(), 40).unwrap().ends_with("A is Error on node1"));
    assert!(
        after(stopped(), 2)
            .unwrap()
            .ends_with("A is Inactive on node1")
    );
    assert!(after(deleted(&a, Cause::Asked), 0).is_some());
    let mut hangs = up.to_vec();
    hangs.extend([
        blemished("p1", Some("A")),
        ended("node1", "p1", Cause::Asked),
    ]);
    hangs.push(activated(&b));
    assert_eq!(verdict(&asked(), &hangs), None);
}

#[test]
fn any_version_that_may_be_in_force_may_permit_it() {
    let (a, b) = both();
    let all = [created(&a), created(&b), activated(&b)];
    let mut desired = asked();
    desired.asked(&hello(&["A", "B"]));
    assert_eq!(verdict(&desired, &all), None);
    desired.asked(&ordered());
    see(&mut desired, &[desired_acked(Some(3))]);
    assert_eq!(verdict(&desired, &all), None);
    desired.converged();
    assert!(verdict(&desired, &all).is_some());
}

#[test]
fn other_nodes_bind_what_a_controller_asked_for() {
    let (a, b) = (subject("A", "node1", "p1"), subject("B", "node2", "p2"));
    let alone = [created(&a), created(&b), activated(&b)];
    assert_eq!(verdict(&asked(), &alone).is_some(), ALONE_TOO);
    let began = Happened::StepBegan {
        node: "node2".to_owned(),
        cluster: "c".to_owned(),
        epoch: 1,
        generation: 1,
        step: "Activate component/B".to_owned(),
    };
    let asked_for = [created(&a), created(&b), began, activated(&b)];
    assert!(verdict(&asked(), &asked_for).is_some());
}

#[test]
fn what_a_person_did_is_his_business() {
    let (a, b) = both();
    let desired = asked();
    desired.by_hand("B");
    let all = [created(&a), created(&b), activated(&b)];
    assert_eq!(verdict(&desired, &all), None);
}
