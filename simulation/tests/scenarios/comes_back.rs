//! A component that crashed and comes back empty.

use rts_simulation::faults::{Fault, Misbehaviour};
use rts_simulation::workload::Change;

use super::play::{CONTROLLER, NODE, Play, Story, alpha, seconds};

fn dies() -> Fault {
    Fault::ManagerDies {
        node: NODE.to_owned(),
        manager: Some("alpha.B1".to_owned()),
    }
}

/// The connector was made again; that all values are as desired is looked at in every story.
fn is_whole_again(story: &Story) {
    let ended = story.only(&["node1 process of alpha.B1 ended", "Fault"]);
    let back = story.first(ended, &["node1", "B1", "created"]);
    let connected = story.first(ended, &["connected B0.out-B1.in"]);
    let active = story.first(back, &["B1", "Inactive to Active"]);
    assert!(
        active < ended + 6.0 && connected < ended + 6.0,
        "{active} {connected}"
    );
    // Nobody else was touched.
    story.never(0.0, story.settled(), &["B0", "deleted"]);
}

#[test]
fn what_crashed_comes_back_with_its_configuration_and_connectors() {
    let play = Play::until(30.0).apply(0.5, alpha());
    is_whole_again(&play.strike(5.0, dies()).play());
}

#[test]
fn it_does_so_without_a_controller() {
    let play = Play::until(30.0).apply(0.5, alpha());
    let play = play.crash(5.0, CONTROLLER, 20.0);
    is_whole_again(&play.strike(10.0, dies()).play());
}

#[test]
fn it_comes_back_with_what_was_changed_since() {
    let change = Change::Configure {
        instance: "B1".to_owned(),
        parameter: "gain".to_owned(),
        value: "42".to_owned(),
    };
    let play = Play::until(30.0).apply(0.5, alpha()).change(5.0, change);
    is_whole_again(&play.strike(10.0, dies()).play());
}

#[test]
fn what_failed_is_tried_again() {
    let fails = Fault::Misbehaves {
        instance: "B1".to_owned(),
        how: Misbehaviour::ErrorInitialize,
        lasts: Some(seconds(20.0)),
    };
    let story = Play::until(60.0)
        .apply(0.5, alpha())
        .strike(0.1, fails)
        .play();
    let active = story.first(20.0, &["B1", "Inactive to Active"]);
    // Its delay is 16 s by then, and 20 % of it.
    assert!(active < 42.0, "{active}");
}
