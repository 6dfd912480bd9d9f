//! A caller that hangs when an agent dies in the middle of an operation; an interrupted run that blocks the next one.

use rts_simulation::workload::Change;

use super::play::{CONTROLLER, NODE, Play, alpha, crash, sequence};

/// Steps of the first plan; the story is told for an interruption at some of them.
const STEPS: u32 = 20;

#[test]
fn nobody_waits_for_an_agent_that_died_in_the_middle() {
    for step in (1..STEPS).step_by(3) {
        let mut spec = alpha();
        spec.orders.activation = sequence(&["B1", "B0", "A1", "A0"]);
        let play = Play::until(90.0).seed(step.into()).apply(0.5, spec);
        let story = play.at_step(step, crash(NODE, 6.0)).play();
        let back = story.only(&["node1 #2 started"]);
        let active = story.first(0.0, &["A0", "Inactive to Active"]);
        // A batch might take minutes; the loss of its agent ends it at once.
        assert!(
            active < back + 6.0,
            "step {step}: back at {back} s, Active at {active} s"
        );
    }
}

#[test]
fn a_run_that_was_interrupted_does_not_block_the_next() {
    for step in (1..STEPS).step_by(3) {
        let faster = Change::Rate {
            instance: "A0".to_owned(),
            rate: 20,
        };
        let play = Play::until(90.0).seed(step.into()).apply(0.5, alpha());
        let play = play
            .at_step(step, crash(CONTROLLER, 1.5))
            .change(1.0, faster);
        let story = play.play();
        let acked = story.first(0.0, &["user: alpha generation 2 acknowledged"]);
        let again = story.times(&["Inactive to Active"]);
        assert!(
            again.iter().all(|time| *time < acked + 6.0),
            "step {step}: {again:?}"
        );
        assert!(acked < 6.0, "step {step}: {acked}");
    }
}
