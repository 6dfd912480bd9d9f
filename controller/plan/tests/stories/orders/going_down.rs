//! What orders mean on the way down.

use rts_schemas::system::{Orders, SendingTiming};

use super::tell::*;
use crate::world::specs::after;
use SendingTiming::Sync;

#[test]
fn taking_down_goes_on_when_time_is_out() {
    let orders = Orders {
        deactivation: vec![within(after("B", 1, Sync, &["A"]), 500)],
        shut_down: vec![within(after("A", 1, Sync, &["B"]), 300)],
        ..Orders::default()
    };
    let mut story = running(named(&["A", "B"], orders));
    story.world.delete("s");
    let plan = story.plan();
    let text = [told(&plan, "Deactivate"), told(&plan, "Delete")].concat();
    insta::assert_snapshot!(text, @r"
    Deactivate A
    Deactivate B: after end of A; goes on after 500 ms without A  [A SYNC in Deactivation]
    Delete B
    Delete A: after end of B; goes on after 300 ms without B  [B SYNC in ShutDown]
    ");
}

/// A Deactivate that fails keeps nobody else alive, numbered or named, in whatever list.
#[test]
fn what_fails_to_go_keeps_nobody_alive() {
    let numbers = || vec![number("A", 1), number("B", 2), number("C", 3)];
    let orders = Orders {
        deactivation: numbers(),
        shut_down: numbers(),
        finalizing: vec![after("C", 1, Sync, &["A"])],
        ..Orders::default()
    };
    let mut story = running(named(&["A", "B", "C"], orders));
    story.world.delete("s");
    let plan = story.plan();
    let text = [told(&plan, "Deactivate"), told(&plan, "Delete")].concat();
    let chance = crate::world::execute::Chance {
        pick: &mut |_| 0,
        fails: &mut |step| step.work.kind() == "Deactivate" && step.target == "component/B",
    };
    story.world.execute(&plan, chance).unwrap();
    let left: Vec<&String> = story
        .world
        .components()
        .map(|(_, _, c)| &c.instance)
        .collect();
    assert_eq!(left, ["B"]);
    insta::assert_snapshot!(text, @r"
    Deactivate A
    Deactivate B: after end of A  [A by number in Deactivation]
    Deactivate C: after end of B  [B by number in Deactivation]
    Delete A
    Delete B: after end of A  [A by number in ShutDown]
    Delete C: after end of A, B  [A by number in ShutDown; A SYNC in Finalizing; B by number in ShutDown]
    ");
}

/// C is numbered after B, which goes on without A. Nobody says that C comes after A.
#[test]
fn who_is_gone_on_without_is_awaited_by_nobody_else() {
    let orders = Orders {
        deactivation: vec![within(after("B", 2, Sync, &["A"]), 500), number("C", 3)],
        ..Orders::default()
    };
    let mut story = running(named(&["A", "B", "C"], orders));
    story.world.delete("s");
    insta::assert_snapshot!(told(&story.plan(), "Deactivate"), @r"
    Deactivate A
    Deactivate B: after end of A; goes on after 500 ms without A  [A SYNC in Deactivation]
    Deactivate C: after end of B  [B by number in Deactivation]
    ");
}

/// A higher number is not let go with it: C still waits for A.
#[test]
fn who_goes_on_does_not_speak_for_a_lower_number() {
    let orders = Orders {
        deactivation: vec![
            number("A", 1),
            within(after("B", 2, Sync, &["A"]), 500),
            number("C", 3),
        ],
        ..Orders::default()
    };
    let mut story = running(named(&["A", "B", "C"], orders));
    story.world.delete("s");
    insta::assert_snapshot!(told(&story.plan(), "Deactivate"), @r"
    Deactivate A
    Deactivate B: after end of A; goes on after 500 ms without A  [A by number in Deactivation; A SYNC in Deactivation]
    Deactivate C: after end of A, B  [A by number in Deactivation; B by number in Deactivation]
    ");
}

/// Without a limit somewhere there is none.
#[test]
fn of_several_time_outs_the_longest_counts_when_taking_down() {
    let orders = Orders {
        deactivation: vec![
            within(after("D", 1, Sync, &["A", "B", "C"]), 500),
            within(after("D", 1, Sync, &["B"]), 900),
            after("D", 1, Sync, &["C"]),
        ],
        ..Orders::default()
    };
    let mut story = running(named(&["A", "B", "C", "D"], orders));
    story.world.delete("s");
    insta::assert_snapshot!(told(&story.plan(), "Deactivate"), @r"
    Deactivate A
    Deactivate B
    Deactivate C
    Deactivate D: after end of A, B, C; goes on after 500 ms without A; goes on after 900 ms without B  [A SYNC in Deactivation; B SYNC in Deactivation; C SYNC in Deactivation]
    ");
}
