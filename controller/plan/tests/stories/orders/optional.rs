//! Who is missing, optional, or cannot be seen.

use rts_plan::observed::LifeCycleState;
use rts_schemas::system::{Orders, SendingTiming};

use super::tell::*;
use crate::world::specs::{after, connector};
use crate::world::story::Story;
use SendingTiming::{Async, Sync};

#[test]
fn an_optional_component_holds_nobody_up_for_longer_than_its_try() {
    let orders = activation(vec![
        number("A", 1),
        number("B", 2),
        number("C", 3),
        after("D", 1, Sync, &["B"]),
        after("E", 1, Async, &["B"]),
    ]);
    let system = named(&["A", "B", "C", "D", "E"], orders);
    insta::assert_snapshot!(activates(optional(system, &["B"])), @r"
    Activate A
    Activate B: after A  [A by number in Activation]
    Activate C: after A; after end of B  [A by number in Activation; B by number in Activation]
    Activate D: after A; after end of B  [A SYNC in Activation; B SYNC in Activation]
    Activate E: after start of B; after end of A  [A ASYNC in Activation; B ASYNC in Activation]
    ");
}

#[test]
fn an_optional_component_that_cannot_be_brought_up_makes_nobody_wait() {
    let orders = activation(vec![
        number("A", 1),
        number("B", 2),
        number("C", 3),
        after("D", 3, Async, &["B"]),
    ]);
    let system = optional(named(&["A", "B", "C", "D"], orders), &["B"]);
    let mut story = Story::of(system.clone());
    block(&mut story, "B");
    let mut text = told(&story.plan(), "Activate");
    // Once all the others run, nothing is to be said.
    story.turn();
    text.push_str(&format!("--\n{}", told(&story.plan(), "Activate")));
    // What it waits for itself makes others wait all the same.
    let mut story = Story::of(system.clone());
    block(&mut story, "A");
    text.push_str(&format!("--\n{}", told(&story.plan(), "Activate")));
    // A required one makes others wait.
    let mut story = Story::of(optional(system, &[]));
    block(&mut story, "B");
    text.push_str(&format!("--\n{}", told(&story.plan(), "Activate")));
    insta::assert_snapshot!(text, @r"
    Activate A
    Activate C: after A  [A by number in Activation]
    Activate D: after A  [A by number in Activation; A ASYNC in Activation]
    note: C, D do not wait for B (Activation order): it is optional and cannot be brought up now
    waiting: component/B: on_activated returned RTC_ERROR
    --
    waiting: component/B: on_activated returned RTC_ERROR
    --
    waiting: component/A: on_activated returned RTC_ERROR
    waiting: component/B: waits for A (Activation order)
    waiting: component/C: waits for A (Activation order)
    waiting: component/D: waits for A (Activation order)
    --
    Activate A
    waiting: component/B: on_activated returned RTC_ERROR
    waiting: component/C: waits for B (Activation order)
    waiting: component/D: waits for B (Activation order)
    ");
}

#[test]
fn start_up_orders_do_not_wait_for_an_optional_component_either() {
    let orders = Orders {
        start_up: vec![after("A", 1, Sync, &["B"]), after("B", 1, Sync, &["C"])],
        ..Orders::default()
    };
    let system = optional(named(&["A", "B", "C"], orders), &["B"]);
    let mut text = told(&Story::of(system.clone()).plan(), "Create");
    for blocked in ["B", "C"] {
        let mut story = Story::of(system.clone());
        block(&mut story, blocked);
        text.push_str(&format!(
            "-- {blocked} is blocked\n{}",
            told(&story.plan(), "Create")
        ));
    }
    insta::assert_snapshot!(text, @r"
    Create C
    Create B: after C  [C SYNC in StartUp]
    Create A: after C; after end of B  [C SYNC in StartUp; B SYNC in StartUp]
    -- B is blocked
    Create C
    Create A: after C  [C SYNC in StartUp]
    note: A does not wait for B (StartUp order): it is optional and cannot be brought up now
    waiting: component/B: on_activated returned RTC_ERROR
    -- C is blocked
    waiting: component/A: waits for C (StartUp order)
    waiting: component/B: waits for C (StartUp order)
    waiting: component/C: on_activated returned RTC_ERROR
    ");
}

#[test]
fn who_is_reset_first_and_cannot_be_makes_the_next_wait() {
    let orders = Orders {
        resetting: vec![after("A", 1, Sync, &["B"])],
        ..Orders::default()
    };
    let mut system = named(&["A", "B"], orders);
    system.spec.components[0].policy.reset_on_error = true;
    let mut text = String::new();
    for names in [&[][..], &["B"][..]] {
        let mut story = running(optional(system.clone(), names));
        let all = story.world.components_mut();
        all.for_each(|c| c.state = LifeCycleState::Error);
        text.push_str(&format!(
            "-- optional: {names:?}\n{}",
            told(&story.plan(), "Reset")
        ));
    }
    insta::assert_snapshot!(text, @r#"
    -- optional: []
    waiting: component/A: waits for B (Resetting order)
    waiting: component/B: in Error: no reason was given (rtsctl.resetOnError is off)
    -- optional: ["B"]
    Reset A
    note: A does not wait for B (Resetting order): it is optional and cannot be brought up now
    waiting: component/B: in Error: no reason was given (rtsctl.resetOnError is off)
    "#);
}

/// Two components of one system on two nodes, connected.
fn apart(orders: Orders) -> Story {
    let mut system = named(&["A", "B"], orders);
    for (component, node) in system.spec.components.iter_mut().zip(["one", "two"]) {
        component.placement.node = Some(node.to_owned());
        component.policy.reset_on_error = true;
    }
    system.spec.connectors = vec![connector(("B", "out"), ("A", "in"))];
    let mut story = Story::of(system.clone());
    story.world = crate::world::World::new(&["one", "two"]);
    story.world.apply(system);
    story.turn();
    assert!(story.plan().is_empty(), "{}", story.plan());
    story
}

/// Who cannot be seen may be in Error.
#[test]
fn who_is_reset_first_and_cannot_be_seen_makes_the_next_wait() {
    let mut story = apart(Orders {
        resetting: vec![after("A", 1, Sync, &["B"])],
        ..Orders::default()
    });
    let all = story.world.components_mut();
    all.for_each(|c| c.state = LifeCycleState::Error);
    story.world.silent.insert("two".to_owned());
    insta::assert_snapshot!(told(&story.plan(), "Reset"), @r"
    waiting: component/A: waits for B (Resetting order)
    waiting: component/B: node two is unknown: no heartbeat for 3 s
    waiting: connector/B.out-A.in: B cannot be seen: node two is unknown: no heartbeat for 3 s
    waiting: node/two: is unknown: no heartbeat for 3 s
    ");
}

/// It would feed somebody who is gone.
#[test]
fn a_source_that_cannot_go_is_disconnected_from_what_goes() {
    let mut story = apart(Orders::default());
    story.world.delete("s");
    let target = "two|component/B".to_owned();
    story
        .blocked
        .insert(target, "on_finalize failed".to_owned());
    // Its process, with something else in it, stays.
    story
        .blocked
        .insert("two|manager/s.main".to_owned(), "it hangs".to_owned());
    insta::assert_snapshot!(crate::world::story::tell(&story.plan()), @r"
    - component/A           one  its system is torn down (was T in s.main)
    - component/B                its system is torn down; waits, see below (was T in s.main)
    - connector/B.out-A.in  two  is not in the system any more
    - manager/s.main        one  nothing is wanted in it any more
    - manager/s.main        two  nothing is wanted in it any more; waits, see below
    waiting: component/B: on_finalize failed
    waiting: manager/s.main: it hangs
    Plan: 0 to add, 0 to change, 5 to remove
      1 Deactivate   component/A  (is not wanted any more)
      2 Disconnect   connector/B.out-A.in  after 1  (is not in the system any more)
      3 Delete       component/A  after 1,2  (is not wanted any more)
      4 StopManager  manager/s.main  after 3  (nothing is wanted in it any more)
    critical path: 1 → 2 → 3 → 4 (4 steps)
    ");
}
