//! A teardown that returns before the work has stopped, or leaves behind what that had started.

use rts_simulation::faults::{Fault, Misbehaviour};
use rts_simulation::workload::Change;

use super::play::{NODE, Play, Story, alpha, crash};

/// Deletes the system at 10 s and applies it again and again: that is accepted as soon as the controller says that the old
/// one is gone. Nothing of it may live then.
fn gone_when_told(play: Play) -> Story {
    let again = (11..35).map(f64::from);
    let story = again.fold(play.delete(10.0), |play, at| play.change(at, Change::None));
    let story = story.play();
    let deleted = story.first(10.0, &["deletion of alpha acknowledged"]);
    let told = story.first(deleted, &["user: alpha generation"]);
    let until = |words: &str| {
        let times = story.times(&["process of", words]).into_iter();
        times.filter(|time| *time <= told).count()
    };
    let (started, ended) = (until("started"), until("ended"));
    assert_eq!(started, ended, "told at {told} s");
    story
}

#[test]
fn a_teardown_is_not_over_before_what_hangs_has_ended() {
    for how in [
        Misbehaviour::HangDeactivate,
        Misbehaviour::HangFinalize,
        Misbehaviour::IgnoreDeactivate,
        Misbehaviour::HangExecute,
    ] {
        let hangs = Fault::Misbehaves {
            instance: "B0".to_owned(),
            how,
            lasts: None,
        };
        let play = Play::until(60.0).apply(0.5, alpha()).strike(5.0, hangs);
        gone_when_told(play);
    }
}

#[test]
fn a_teardown_is_not_over_before_a_process_that_does_not_answer_has_ended() {
    let hangs = Fault::ManagerHangs {
        node: NODE.to_owned(),
        manager: None,
    };
    let play = Play::until(60.0).apply(0.5, alpha()).strike(9.9, hangs);
    gone_when_told(play);
}

#[test]
fn a_teardown_that_is_interrupted_everywhere_leaves_nothing() {
    for step in (18..30).step_by(2) {
        let play = Play::until(40.0).seed(step.into()).apply(0.5, alpha());
        let play = play.at_step(step, crash(NODE, 1.0));
        let play = play.at_step(step + 1, crash("controller", 2.0));
        gone_when_told(play.at_step(step + 2, crash("local", 0.5)));
    }
}

#[test]
fn what_a_process_had_started_ends_with_it() {
    // Some processes start one of their own, by chance of the seed.
    for seed in 0..4 {
        let dies = Fault::ManagerDies {
            node: NODE.to_owned(),
            manager: None,
        };
        let play = Play::until(30.0).seed(seed).apply(0.5, alpha());
        // The agent is away when it dies: its children are the next one's to find.
        let play = play.crash(5.0, NODE, 3.0).strike(6.0, dies);
        let story = play.play();
        assert_eq!(story.times(&["process of", "started"]).len(), 5);
    }
}
