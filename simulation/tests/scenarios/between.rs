//! Connectors between nodes, whose agents alone know each where an end is.

use rts_schemas::system::SystemSpec;
use rts_simulation::faults::Fault;
use rts_simulation::workload::Change;

use super::play::{CONTROLLER, NODE, Play, alpha, connector, seconds};

/// `alpha`, with connectors between both nodes in both directions.
fn across() -> SystemSpec {
    let mut spec = alpha();
    spec.connectors.push(connector("A1", "B0"));
    spec.connectors.push(connector("B1", "A0"));
    spec
}

fn dies(instance: &str, node: &str) -> Fault {
    Fault::ManagerDies {
        node: node.to_owned(),
        manager: Some(format!("alpha.{instance}")),
    }
}

fn cut(from: &str, to: &str, lasts: f64) -> Fault {
    Fault::Cut {
        from: from.to_owned(),
        to: to.to_owned(),
        lasts: Some(seconds(lasts)),
    }
}

/// How each of these is told when it is connected.
const BETWEEN: [&str; 2] = [" connected A1.out-B0.in", " connected B1.out-A0.in"];

#[test]
fn whichever_end_dies_is_connected_again_and_nobody_else_is_touched() {
    let play = Play::until(60.0).apply(0.5, across());
    let story = play
        .strike(10.0, dies("B0", NODE))
        .strike(30.0, dies("A1", "local"))
        .play();
    assert_eq!(
        story.times(&[BETWEEN[0]]).len(),
        3,
        "at first, and for each death"
    );
    assert_eq!(story.times(&[BETWEEN[1]]).len(), 1, "both its ends live on");
    for (instance, times) in [("A0", 1), ("A1", 2), ("B0", 2), ("B1", 1)] {
        assert_eq!(
            story.times(&[instance, "created"]).len(),
            times,
            "{instance}"
        );
    }
}

#[test]
fn agents_alone_connect_again_as_soon_as_they_can_ask_each_other() {
    let play = Play::until(90.0).apply(0.5, across());
    let story = play
        .crash(9.0, CONTROLLER, 71.0)
        .strike(10.0, cut("local", NODE, 20.0))
        .strike(10.0, cut(NODE, "local", 20.0))
        .strike(11.0, dies("B0", NODE))
        .play();
    let again = story.first(11.0, &["node1", "B0", "created"]);
    assert!(again < 20.0, "its own agent makes it: {again}");
    let connected = story.first(11.0, &[BETWEEN[0]]);
    assert!(
        (30.0..79.0).contains(&connected),
        "after the cut, before the controller: {connected}"
    );
    assert_eq!(story.times(&[BETWEEN[1]]).len(), 1, "samples need no agent");
}

#[test]
fn a_target_that_moves_to_another_node_is_connected_there() {
    let play = Play::until(60.0).apply(0.5, across());
    let to = Change::Move {
        instance: "B0".to_owned(),
        node: "node2".to_owned(),
    };
    let story = play.change(10.0, to).play();
    let moved = story.first(10.0, &["node2", "B0", "created"]);
    assert!(story.first(10.0, &[BETWEEN[0]]) > moved);
}
