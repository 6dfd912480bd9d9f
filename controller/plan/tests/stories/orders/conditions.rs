//! Conditions: numbers, waiting times, predecessors, time-outs.

use rts_plan::observed::LifeCycleState;
use rts_plan::plan::{OrderName, Rule, Work};
use rts_schemas::system::{NO_SEQUENCE, Orders, SendingTiming};

use super::tell::*;
use crate::world::specs::after;
use crate::world::story::Story;
use SendingTiming::{Async, Sync};

#[test]
fn numbers_alone_are_a_sequence() {
    let orders = activation(vec![
        number("A", 1),
        number("B", 2),
        number("C", 2),
        number("D", 5),
    ]);
    insta::assert_snapshot!(activates(named(&["D", "C", "B", "A", "Free"], orders)), @r"
    Activate A
    Activate B: after A  [A by number in Activation]
    Activate C: after A  [A by number in Activation]
    Activate D: after B, C  [B by number in Activation; C by number in Activation]
    Activate Free
    ");
}

/// As overlays add them: they wait for whom they name, and no number waits for them.
#[test]
fn without_a_number_there_is_no_place_in_the_sequence() {
    let orders = activation(vec![
        number("A", 1),
        number("B", 2),
        after("Free", NO_SEQUENCE, Sync, &["B"]),
        sleep("Late", NO_SEQUENCE, 500),
        after("A", NO_SEQUENCE, Sync, &["First"]),
    ]);
    let names = ["A", "B", "First", "Free", "Late"];
    insta::assert_snapshot!(activates(named(&names, orders)), @r"
    Activate First
    Activate A: after First  [First SYNC in Activation]
    Activate B: after A  [A by number in Activation]
    Activate Free: after B  [B SYNC in Activation]
    Activate Late: sleeps 500 ms
    ");
}

/// Who is Active already is no gap in the sequence.
#[test]
fn a_number_waits_past_who_is_there() {
    let numbers = ["A", "B", "C"].into_iter().zip(1..);
    let orders = activation(numbers.map(|(name, n)| number(name, n)).collect());
    let mut story = running(named(&["A", "B", "C"], orders));
    let all = story.world.components_mut();
    let all = all.filter(|c| c.instance != "B");
    all.for_each(|c| c.state = LifeCycleState::Inactive);
    insta::assert_snapshot!(told(&story.plan(), "Activate"), @r"
    Activate A
    Activate C: after A  [A by number in Activation]
    ");
}

#[test]
fn wait_time_sleeps() {
    let orders = activation(vec![number("A", 1), sleep("B", 2, 500)]);
    insta::assert_snapshot!(activates(named(&["A", "B"], orders)), @r"
    Activate A
    Activate B: after A; sleeps 500 ms  [A by number in Activation]
    ");
}

#[test]
fn sync_waits_for_the_state_and_async_for_the_request() {
    let orders = activation(vec![
        after("B", 1, Sync, &["A"]),
        after("C", 1, Async, &["A"]),
    ]);
    insta::assert_snapshot!(activates(named(&["A", "B", "C"], orders)), @r"
    Activate A
    Activate B: after A  [A SYNC in Activation]
    Activate C: after start of A  [A ASYNC in Activation]
    ");
}

#[test]
fn conditions_of_one_component_are_anded() {
    let orders = activation(vec![
        number("A", 1),
        after("E", 2, Sync, &["B"]),
        after("E", 2, Async, &["C"]),
        within(after("E", 2, Sync, &["D"]), 200),
        sleep("E", 2, 10),
        sleep("E", 2, 20),
    ]);
    insta::assert_snapshot!(activates(named(&["A", "B", "C", "D", "E"], orders)), @r"
    Activate A
    Activate B
    Activate C
    Activate D
    Activate E: after A, B, D; after start of C; sleeps 20 ms; fails after 200 ms without D  [A by number in Activation; B SYNC in Activation; C ASYNC in Activation; D SYNC in Activation]
    ");
}

#[test]
fn each_time_out_is_a_limit_of_its_own() {
    let orders = activation(vec![
        within(after("D", 1, Sync, &["A", "B"]), 500),
        within(after("D", 1, Async, &["C"]), 100),
    ]);
    insta::assert_snapshot!(activates(named(&["A", "B", "C", "D"], orders)), @r"
    Activate A
    Activate B
    Activate C
    Activate D: after A, B; after start of C; fails after 500 ms without A, B; fails after 100 ms without C  [A SYNC in Activation; B SYNC in Activation; C ASYNC in Activation]
    ");
}

/// Nobody waits for a request of what must be Active anyway.
#[test]
fn a_limit_for_a_request_gives_way_to_the_number() {
    let orders = activation(vec![
        number("A", 1),
        within(after("B", 2, Async, &["A"]), 100),
    ]);
    insta::assert_snapshot!(activates(named(&["A", "B"], orders)), @r"
    Activate A
    Activate B: after A  [A by number in Activation; A ASYNC in Activation]
    ");
}

/// Who is there already is not waited for.
#[test]
fn a_limit_ends_with_its_steps() {
    let orders = activation(vec![within(after("B", 1, Sync, &["A"]), 500)]);
    let mut story = running(named(&["A", "B"], orders));
    let mut all = story.world.components_mut();
    all.find(|c| c.instance == "B").unwrap().state = LifeCycleState::Inactive;
    drop(all);
    insta::assert_snapshot!(told(&story.plan(), "Activate"), @"Activate B");
}

/// An order for each kind of step: C before B before A, in each of the forms.
fn seven() -> Orders {
    let list = || vec![after("A", 1, Sync, &["B"]), after("B", 1, Async, &["C"])];
    Orders {
        start_up: list(),
        shut_down: vec![number("C", 1), number("B", 2), number("A", 3)],
        activation: list(),
        deactivation: list(),
        resetting: list(),
        initializing: vec![number("C", 1), number("A", 2)],
        finalizing: vec![within(after("A", 1, Sync, &["C"]), 700)],
    }
}

#[test]
fn all_seven_orders_order_their_steps() {
    let mut system = named(&["A", "B", "C"], seven());
    for component in &mut system.spec.components {
        component.policy.reset_on_error = true;
    }
    let mut story = Story::of(system);
    let plan = story.plan();
    let mut text = [told(&plan, "Create"), told(&plan, "Activate")].concat();
    story.turn();
    let all = story.world.components_mut();
    all.for_each(|c| c.state = LifeCycleState::Error);
    let plan = story.plan();
    text.push_str(&[told(&plan, "Reset"), told(&plan, "Activate")].concat());
    story.turn();
    story.world.delete("s");
    let plan = story.plan();
    text.push_str(&[told(&plan, "Deactivate"), told(&plan, "Delete")].concat());
    story.turn();
    assert!(story.plan().is_empty());
    insta::assert_snapshot!(text, @r"
    Create C
    Create B: after start of C  [C ASYNC in StartUp]
    Create A: after C, B  [C by number in Initializing; B SYNC in StartUp]
    Activate C
    Activate B: after start of C  [C ASYNC in Activation]
    Activate A: after B  [B SYNC in Activation]
    Reset C
    Reset B: after start of C  [C ASYNC in Resetting]
    Reset A: after B  [B SYNC in Resetting]
    Activate C
    Activate B: after start of C  [C ASYNC in Activation]
    Activate A: after B  [B SYNC in Activation]
    Deactivate C
    Deactivate B: after start of C  [C ASYNC in Deactivation]
    Deactivate A: after end of B  [B SYNC in Deactivation]
    Delete C
    Delete B: after end of C  [C by number in ShutDown]
    Delete A: after end of C, B  [C by number in ShutDown; C SYNC in Finalizing; B by number in ShutDown]
    ");
}

/// Real profiles number components in the order of a list.
#[test]
fn preceding_outweighs_a_number() {
    let orders = activation(vec![
        after("A", 1, Sync, &["B"]),
        number("B", 2),
        number("C", 3),
    ]);
    insta::assert_snapshot!(running_activates(named(&["A", "B", "C"], orders)), @r"
    Activate B
    Activate A: after B  [B SYNC in Activation]
    Activate C: after B  [B by number in Activation]
    ");
}

/// The lists that order one kind of step are named as they stand in the profile.
#[test]
fn a_rule_names_its_list() {
    let plan = Story::of(named(&["A", "B", "C"], seven())).plan();
    let creates = plan
        .steps
        .iter()
        .filter(|s| matches!(s.work, Work::Create { .. }));
    let rules = creates.flat_map(|step| &step.because).map(|b| b.rule);
    let orders: std::collections::BTreeSet<OrderName> = rules
        .filter_map(|rule| match rule {
            Rule::Sequence { order } | Rule::Sync { order } | Rule::Async { order } => Some(order),
            _ => None,
        })
        .collect();
    let expected = [OrderName::StartUp, OrderName::Initializing];
    assert!(orders.into_iter().eq(expected));
}
