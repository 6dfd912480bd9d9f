//! What is written comes first, whoever dies when.

use rts_simulation::faults::Fault;

use super::play::{CONTROLLER, NODE, Play, Story, alpha, crash, seconds, sequence};

const ORDER: [&str; 4] = ["B1", "A1", "B0", "A0"];

fn ordered() -> Play {
    let mut spec = alpha();
    spec.orders.start_up = sequence(&ORDER);
    spec.orders.activation = sequence(&ORDER);
    Play::until(60.0).apply(0.5, spec)
}

/// Each became Active after the one before it, the first time.
fn in_order(story: &Story) {
    let active = ORDER.map(|name| {
        let times = story.times(&[name, "Inactive to Active"]);
        times.into_iter().reduce(f64::min).unwrap()
    });
    assert!(active.is_sorted(), "{active:?}");
}

#[test]
fn what_is_ordered_comes_up_in_its_order() {
    in_order(&ordered().play());
}

#[test]
fn what_is_interrupted_goes_on_in_its_order() {
    for step in (2..26).step_by(3) {
        let play = ordered().at_step(step, crash(CONTROLLER, 1.0));
        in_order(&play.at_step(step + 1, crash("local", 0.5)).play());
    }
}

#[test]
fn what_lost_its_power_comes_up_in_its_order() {
    let dark = Fault::Reboot {
        node: NODE.to_owned(),
        down: seconds(5.0),
    };
    in_order(&ordered().strike(10.0, dark).play());
}
