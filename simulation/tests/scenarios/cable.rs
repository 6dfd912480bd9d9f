//! A pulled cable that is not noticed, or late.

use rts_simulation::faults::Fault;

use super::play::{NODE, Play, alpha, seconds};

/// Seconds without a word until a node is unknown, and the time that its last word may have been on its way before.
const LIMIT: (f64, f64) = (1.9, 4.2);

#[test]
fn a_pulled_cable_is_noticed_within_moments() {
    let play = Play::until(30.0).apply(0.5, alpha());
    let story = play.pull_cable(10.0, NODE, 10.0).play();
    let noticed = story.first(10.0, &["no heartbeat", NODE]);
    assert!((LIMIT.0..LIMIT.1).contains(&(noticed - 10.0)), "{noticed}");
}

#[test]
fn a_machine_without_power_is_noticed_within_moments() {
    let play = Play::until(30.0).apply(0.5, alpha());
    let dark = Fault::Reboot {
        node: NODE.to_owned(),
        down: seconds(10.0),
    };
    let story = play.strike(10.0, dark).play();
    let noticed = story.first(10.0, &["no heartbeat", NODE]);
    assert!((LIMIT.0..LIMIT.1).contains(&(noticed - 10.0)), "{noticed}");
    // All of it comes back, and what the other node runs knows nothing of it.
    assert_eq!(story.times(&["node1", "created"]).len(), 4);
    assert_eq!(story.times(&["local", "created"]).len(), 2);
}
