//! What was acknowledged and is lost; what is of the past and is obeyed.

use rts_simulation::faults::Fault;
use rts_simulation::workload::Change;

use super::play::{CONTROLLER, NODE, Play, alpha, crash, lone, seconds};

fn dark(down: f64) -> Fault {
    Fault::Reboot {
        node: NODE.to_owned(),
        down: seconds(down),
    }
}

#[test]
fn a_set_that_was_acknowledged_outlives_a_loss_of_power() {
    for tenths in (6..14).step_by(2) {
        let play = Play::until(30.0).seed(tenths).apply(0.5, alpha());
        let faster = Change::Rate {
            instance: "B0".to_owned(),
            rate: 20,
        };
        let play = play.change(5.0, faster);
        let tenths = f64::from(u32::try_from(tenths).unwrap());
        play.strike(4.4 + tenths / 10.0, dark(3.0)).play();
    }
}

#[test]
fn what_the_controller_acknowledged_outlives_it() {
    for calls in (1..40).step_by(4) {
        let dies = Fault::Crash {
            host: CONTROLLER.to_owned(),
            calls,
            down: Some(seconds(0.5)),
        };
        let play = Play::until(20.0).seed(calls).apply(0.5, alpha());
        play.strike(0.5, dies)
            .delete(8.0)
            .at_step(30, crash(CONTROLLER, 1.0))
            .play();
    }
}

#[test]
fn a_controller_of_the_past_is_not_obeyed() {
    for seed in 0..8 {
        let gain = |at: f64, play: Play, instance: &str| {
            let change = Change::Configure {
                instance: instance.to_owned(),
                parameter: "gain".to_owned(),
                value: "8".to_owned(),
            };
            play.change(at, change)
        };
        // What the one before sends just before comes late, and once more.
        let storm = Fault::Weather {
            lost: 0,
            doubled: 1000,
            delay: seconds(2.5),
            lasts: seconds(0.15),
        };
        let play = Play::until(40.0).seed(seed).apply(0.5, alpha());
        let play = gain(8.99, play, "B0").strike(9.0, storm);
        let play = play.strike(9.1, Fault::Usurper);
        gain(20.0, play, "A0").play();
    }
}

/// Its store is of before the component came to the node that is away.
#[test]
fn what_a_restored_store_does_not_know_of_is_not_made_a_second_time() {
    let to = |node: &str| Change::Move {
        instance: "B0".to_owned(),
        node: node.to_owned(),
    };
    for seed in 0..24 {
        let play = Play::until(60.0).seed(seed).apply(0.5, lone());
        let play = play.change(5.0, to("node2")).pull_cable(10.0, NODE, 30.0);
        let play = play.pull_cable(10.0, "node2", 40.0);
        let play = play.change(15.0, to("local"));
        play.strike(17.0, Fault::Usurper).play();
    }
}
