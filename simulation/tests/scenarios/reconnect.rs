//! A reconnect that kills healthy work, or starts a replacement first; an old connection's time-out that removes the new
//! registration.

use rts_simulation::faults::Fault;
use rts_simulation::workload::Change;

use super::play::{CONTROLLER, NODE, Play, Story, alpha, clock_jumps, lone, seconds};

/// Nothing was ended, and nothing was made a second time, before the story's own end.
fn undisturbed(story: &Story) {
    let end = story.settled();
    assert_eq!(story.times(&["process of", "started"]).len(), 4);
    assert_eq!(story.times(&["created"]).len(), 4);
    for words in [
        ["process of", "ended"],
        ["Active to", ""],
        ["disconnected", ""],
    ] {
        story.never(0.0, end, &words);
    }
}

#[test]
fn a_cable_that_is_pulled_and_put_back_disturbs_nothing() {
    let play = Play::until(60.0).apply(0.5, alpha());
    undisturbed(&play.pull_cable(5.0, NODE, 30.0).play());
}

#[test]
fn one_way_that_is_cut_disturbs_nothing() {
    for (from, to) in [(CONTROLLER, NODE), (NODE, CONTROLLER)] {
        let cut = Fault::Cut {
            from: from.to_owned(),
            to: to.to_owned(),
            lasts: Some(seconds(30.0)),
        };
        let play = Play::until(60.0).apply(0.5, alpha());
        undisturbed(&play.strike(5.0, cut).play());
    }
}

#[test]
fn programs_that_die_and_come_back_disturb_nothing() {
    let play = Play::until(60.0).apply(0.5, alpha());
    let play = play.crash(5.0, NODE, 0.1).crash(10.0, NODE, 20.0);
    let play = play
        .crash(7.0, CONTROLLER, 0.1)
        .crash(35.0, CONTROLLER, 15.0);
    undisturbed(&play.crash(36.0, "local", 20.0).play());
}

#[test]
fn wall_clocks_that_are_set_disturb_nothing() {
    let play = Play::until(60.0).apply(0.5, alpha());
    let play = play.strike(5.0, clock_jumps(NODE, 48));
    let play = play.strike(10.0, clock_jumps(CONTROLLER, -48));
    undisturbed(&play.crash(20.0, NODE, 5.0).play());
}

#[test]
fn what_is_moved_away_from_a_lost_node_waits_for_that_node() {
    let away = Change::Move {
        instance: "B0".to_owned(),
        node: "node2".to_owned(),
    };
    let play = Play::until(60.0).apply(0.5, lone());
    let story = play.pull_cable(5.0, NODE, 30.0).change(10.0, away).play();
    let gone = story.only(&["node1", "B0", "deleted"]);
    let there = story.only(&["node2", "B0", "created"]);
    assert!(35.0 < gone && gone < there, "{gone} {there}");
}

#[test]
fn what_is_moved_away_waits_for_that_node_without_a_controller_too() {
    let away = Change::Move {
        instance: "B0".to_owned(),
        node: "node2".to_owned(),
    };
    let play = Play::until(60.0).apply(0.5, lone());
    let play = play.pull_cable(5.0, NODE, 30.0).change(10.0, away);
    let story = play.crash(12.0, CONTROLLER, 15.0).play();
    let gone = story.only(&["node1", "B0", "deleted"]);
    let there = story.only(&["node2", "B0", "created"]);
    assert!(35.0 < gone && gone < there, "{gone} {there}");
}

#[test]
fn the_time_out_of_an_old_session_does_not_touch_the_new_one() {
    let play = Play::until(60.0).apply(0.5, alpha());
    let storm = Fault::Weather {
        lost: 0,
        doubled: 500,
        delay: seconds(0.4),
        lasts: seconds(20.0),
    };
    // Each new agent has another session; that of the one before is over 3 s later.
    let play = play.strike(4.0, storm);
    let story = (0..5).fold(play, |play, n| {
        play.crash(5.0 + f64::from(n) * 1.7, NODE, 0.1)
    });
    let story = story.play();
    undisturbed(&story);
    story.never(0.0, story.settled(), &["node1", "no heartbeat"]);
}
