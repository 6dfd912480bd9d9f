//! A new instance that is started before the old one has freed what it held.

use rts_schemas::system::OnHang;
use rts_simulation::faults::{Fault, Misbehaviour};
use rts_simulation::workload::Change;

use super::play::{CONTROLLER, NODE, Play, Story, alpha};

/// Every process of a manager began after the end of the one before.
fn one_after_the_other(story: &Story, manager: &str) {
    let process = |words: &str| story.times(&[NODE, &format!("process of {manager} {words}")]);
    let (started, ended) = (process("started"), process("ended"));
    assert!(started.len() > 1, "it was never replaced");
    for (next, last) in started.iter().skip(1).zip(&ended) {
        assert!(last <= next, "started at {next} s, ended at {last} s");
    }
}

#[test]
fn a_process_that_does_not_end_is_not_replaced_before_it_does() {
    let mut spec = alpha();
    for component in &mut spec.components {
        component.policy.on_hang = OnHang::Restart;
    }
    let hangs = Fault::ManagerHangs {
        node: NODE.to_owned(),
        manager: Some("alpha.B0".to_owned()),
    };
    let play = Play::until(60.0).apply(0.5, spec).strike(5.0, hangs);
    one_after_the_other(&play.play(), "alpha.B0");
}

#[test]
fn a_process_that_was_just_started_is_found_by_the_next_agent() {
    // The agent dies at many moments of a start.
    for calls in (1..40).step_by(4) {
        let dies = Fault::Crash {
            host: NODE.to_owned(),
            calls,
            down: Some(super::play::seconds(0.2)),
        };
        let play = Play::until(40.0).seed(calls).apply(0.5, alpha());
        let story = play.strike(0.6, dies).play();
        assert!(story.settled() < 41.0);
    }
}

#[test]
fn what_dies_again_and_again_is_never_there_twice() {
    let dies = Fault::Misbehaves {
        instance: "B0".to_owned(),
        how: Misbehaviour::CrashLater,
        lasts: Some(super::play::seconds(30.0)),
    };
    let play = Play::until(60.0).apply(0.5, alpha()).strike(5.0, dies);
    let play = play.crash(12.0, CONTROLLER, 20.0);
    one_after_the_other(&play.play(), "alpha.B0");
}

#[test]
fn what_was_just_made_in_a_process_that_hangs_since_is_not_made_elsewhere_beside_it() {
    for step in 1..24 {
        let hangs = Fault::ManagerHangs {
            node: NODE.to_owned(),
            manager: Some("alpha.B0".to_owned()),
        };
        let away = Change::Move {
            instance: "B0".to_owned(),
            node: "node2".to_owned(),
        };
        let play = Play::until(60.0).seed(step.into()).apply(0.5, alpha());
        play.at_step(step, hangs).change(3.0, away).play();
    }
}
