//! What an agent plans over its own node alone, where orders name components of other nodes.

use rts_plan::desired::{Desired, Elsewhere};
use rts_plan::observed::{LifeCycleState, Observed};
use rts_plan::plan::{Blocked, Plan};
use rts_plan::{StoredSystem, plan};
use rts_schemas::system::{Orders, SendingTiming};

use super::tell::*;
use crate::world::World;
use crate::world::specs::after;
use crate::world::story::Story;
use SendingTiming::{Async, Sync};

/// A on node one, all others on node two.
fn on_two_nodes(names: &[&str], orders: Orders) -> StoredSystem {
    let mut system = named(names, orders);
    for component in &mut system.spec.components {
        let node = if component.instance == "A" {
            "one"
        } else {
            "two"
        };
        component.placement.node = Some(node.to_owned());
    }
    system
}

fn applied(system: StoredSystem) -> Story {
    let mut story = Story::of(system.clone());
    story.world = World::new(&["one", "two"]);
    story.world.apply(system);
    story
}

/// What the agent of node two plans.
fn alone(story: &Story) -> Plan {
    let (mut desired, mut observed) = (story.world.desired(), story.world.observed());
    desired.nodes.retain(|node, _| node == "two");
    observed.nodes.retain(|node, _| node == "two");
    let (desired, observed): (Desired, Observed) = (desired, observed);
    plan(&desired, &observed, &Blocked::new())
}

/// All processes of node two have ended.
fn reboot(story: &mut Story) {
    let all = story.world.managers();
    let gone = all.enumerate().filter(|(_, (node, _))| *node == "two");
    let gone: Vec<usize> = gone.map(|(nth, _)| nth).collect();
    // From the last to the first, so that the numbers hold.
    gone.into_iter().rev().for_each(|nth| story.world.kill(nth));
}

#[test]
fn who_comes_after_another_nodes_component_waits_for_the_controller() {
    let orders = activation(vec![
        number("A", 1),
        number("B", 2),
        number("C", 3),
        after("D", 0, Sync, &["A"]),
        after("E", 0, Async, &["A"]),
        after("F", 0, Sync, &["G"]),
    ]);
    let system = on_two_nodes(&["A", "B", "C", "D", "E", "F", "G"], orders);
    let mut story = applied(system);
    let mut text = told(&alone(&story), "Activate");
    story.turn();
    assert!(story.plan().is_empty(), "{}", story.plan());
    // What runs is not touched.
    assert!(alone(&story).is_empty() && alone(&story).waiting_on.is_empty());
    reboot(&mut story);
    assert_eq!(text, told(&alone(&story), "Activate"));
    text.push_str(&format!(
        "-- the controller\n{}",
        told(&story.plan(), "Activate")
    ));
    insta::assert_snapshot!(text, @r"
    Activate G
    Activate F: after G  [G SYNC in Activation]
    waiting: component/B: waits for A, which is on one, where only a controller can ask (Activation order)
    waiting: component/C: waits for B (Activation order)
    waiting: component/D: waits for A, which is on one, where only a controller can ask (Activation order)
    waiting: component/E: waits for A, which is on one, where only a controller can ask (Activation order)
    -- the controller
    Activate D
    Activate E
    Activate G
    Activate F: after G  [G SYNC in Activation]
    Activate B: after F  [F by number in Activation]
    Activate C: after B  [B by number in Activation]
    ");
}

#[test]
fn it_is_not_created_either() {
    let orders = Orders {
        start_up: vec![after("B", 1, Sync, &["A"]), after("C", 1, Sync, &["B"])],
        ..Orders::default()
    };
    let story = applied(on_two_nodes(&["A", "B", "C", "D"], orders));
    insta::assert_snapshot!(told(&alone(&story), "Create"), @r"
    Create D
    waiting: component/B: waits for A, which is on one, where only a controller can ask (StartUp order)
    waiting: component/C: waits for B (StartUp order)
    ");
}

/// It may be in Error.
#[test]
fn it_is_not_reset_either() {
    let orders = Orders {
        resetting: vec![after("B", 1, Sync, &["A"])],
        ..Orders::default()
    };
    let mut system = on_two_nodes(&["A", "B", "C"], orders);
    let all = system.spec.components.iter_mut();
    all.for_each(|c| c.policy.reset_on_error = true);
    let mut story = applied(system);
    story.turn();
    let all = story.world.components_mut();
    all.for_each(|c| c.state = LifeCycleState::Error);
    insta::assert_snapshot!(told(&alone(&story), "Reset"), @r"
    Reset C
    waiting: component/B: waits for A, which is on one, where only a controller can ask (Resetting order)
    ");
}

#[test]
fn an_optional_component_elsewhere_holds_nobody_up() {
    let orders = activation(vec![after("B", 1, Sync, &["A"])]);
    let story = applied(optional(on_two_nodes(&["A", "B"], orders), &["A"]));
    insta::assert_snapshot!(told(&alone(&story), "Activate"), @r"
    Activate B
    note: B does not wait for A (Activation order): it is optional and cannot be brought up now
    ");
}

/// No order keeps anything alive.
#[test]
fn going_down_waits_for_nobody_elsewhere() {
    let list = || vec![after("B", 1, Sync, &["A"]), after("C", 1, Sync, &["B"])];
    let orders = Orders {
        deactivation: list(),
        finalizing: list(),
        shut_down: list(),
        ..Orders::default()
    };
    let mut story = applied(on_two_nodes(&["A", "B", "C"], orders.clone()));
    story.turn();
    let mut smaller = on_two_nodes(&["A", "B", "C"], orders);
    smaller.spec.components.truncate(1);
    story.world.apply(smaller);
    let mut text = told(&alone(&story), "Delete");
    story.world.delete("s");
    text.push_str(&format!(
        "-- torn down\n{}",
        told(&alone(&story), "Deactivate")
    ));
    insta::assert_snapshot!(text, @r"
    Delete B
    Delete C
    -- torn down
    Deactivate B
    Deactivate C
    ");
}

#[test]
fn a_part_tells_only_what_its_orders_name_elsewhere() {
    let orders = activation(vec![after("B", 1, Sync, &["A"])]);
    let story = applied(optional(on_two_nodes(&["A", "B", "C"], orders), &["A"]));
    let parts = story.world.desired().nodes;
    let told = |node: &str| serde_json::to_value(&parts[node].systems[0]).unwrap();
    assert_eq!(
        told("two")["elsewhere"],
        serde_json::json!({"A": {"node": "one", "required": false}})
    );
    assert_eq!(
        told("one")["elsewhere"],
        serde_json::json!({"B": {"node": "two", "required": true}})
    );
    let story = applied(on_two_nodes(
        &["B", "C"],
        activation(vec![after("B", 1, Sync, &["C"])]),
    ));
    let part = serde_json::to_value(&story.world.desired().nodes["two"].systems[0]).unwrap();
    assert_eq!(part.get("elsewhere"), None);
}

/// It was moved here, and nobody has seen it gone from where it was.
#[test]
fn what_may_still_run_on_another_node_is_made_by_a_controller_alone() {
    let orders = Orders {
        start_up: vec![after("C", 1, Sync, &["B"])],
        ..Orders::default()
    };
    let mut story = applied(on_two_nodes(&["A", "B", "C", "D"], orders));
    let of = |story: &Story, only: &[&str], may: bool| {
        let (mut desired, mut observed) = (story.world.desired(), story.world.observed());
        desired
            .nodes
            .retain(|node, _| only.contains(&node.as_str()));
        observed
            .nodes
            .retain(|node, _| only.contains(&node.as_str()));
        let part = &mut desired.nodes.get_mut("two").unwrap().systems[0];
        let there = Elsewhere {
            node: "one".to_owned(),
            required: true,
        };
        part.elsewhere.extend(may.then(|| ("B".to_owned(), there)));
        plan(&desired, &observed, &Blocked::new())
    };
    let mut text = told(&of(&story, &["two"], true), "Create");
    text.push_str("-- the controller\n");
    text.push_str(&told(&of(&story, &["one", "two"], true), "Create"));
    insta::assert_snapshot!(text, @r"
    Create D
    waiting: component/B: may still run on one, where only a controller can ask
    waiting: component/C: waits for B (StartUp order)
    -- the controller
    Create A
    Create B
    Create C: after B  [B SYNC in StartUp]
    Create D
    ");
    let sure = told(&of(&story, &["two"], false), "Create");
    assert!(sure.contains("Create B"), "{sure}");
    // Once it is there, it is this node's.
    story.turn();
    let done = of(&story, &["two"], true);
    assert!(done.is_empty() && done.waiting_on.is_empty(), "{done}");
    story
        .world
        .components_mut()
        .for_each(|c| c.state = LifeCycleState::Inactive);
    let awake = told(&of(&story, &["two"], true), "Activate");
    assert!(awake.contains("Activate B"), "{awake}");
}
