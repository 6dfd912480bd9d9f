//! What is written comes first, whoever dies when.

use rts_schemas::system::{Condition, WaitFor};
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

/// B0 is activated 20 s later than it could be.
fn patient() -> Play {
    let mut spec = alpha();
    spec.orders.activation = vec![Condition {
        target: "B0".to_owned(),
        sequence: 1,
        wait: Some(WaitFor::Time {
            milliseconds: 20_000,
        }),
    }];
    Play::until(60.0).apply(0.5, spec)
}

fn dies(instance: &str) -> Fault {
    Fault::ManagerDies {
        node: NODE.to_owned(),
        manager: Some(format!("alpha.{instance}")),
    }
}

/// What has died is back long before the other's wait is over.
fn soon_back(story: &Story, died: f64) {
    let back = story.first(died, &["B1", "Inactive to Active"]);
    let waits = story.first(died, &["B0", "Inactive to Active"]);
    assert!(back < died + 6.0, "died at {died} s, back at {back} s");
    assert!(waits > died + 6.0, "died at {died} s, Active at {waits} s");
}

#[test]
fn what_dies_while_another_one_waits_is_back_at_once() {
    soon_back(&patient().strike(4.0, dies("B1")).play(), 4.0);
}

#[test]
fn what_dies_while_another_one_waits_is_back_at_once_without_a_controller() {
    // The controller's last batch goes on.
    let play = patient().crash(3.0, CONTROLLER, 30.0);
    soon_back(&play.strike(8.0, dies("B1")).play(), 8.0);
    // The agent's own does.
    let dark = Fault::Reboot {
        node: NODE.to_owned(),
        down: seconds(1.0),
    };
    let play = patient().crash(25.0, CONTROLLER, 40.0).strike(26.0, dark);
    soon_back(&play.strike(36.0, dies("B1")).play(), 36.0);
}
