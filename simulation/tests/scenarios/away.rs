//! Work that was deleted while its agent was away and keeps running; a dead entry that is kept for ever.

use rts_simulation::faults::Fault;
use rts_simulation::workload::Change;

use super::play::{NODE, Play, alpha, lone, seconds};

#[test]
fn what_was_torn_down_while_its_agent_was_away_ends_when_that_is_back() {
    let play = Play::until(60.0).apply(0.5, alpha()).crash(5.0, NODE, 20.0);
    let story = play.delete(10.0).play();
    let ended = story.times(&["node1", "process of", "ended"]);
    assert_eq!(ended.len(), 2);
    // Soon after its agent is back, and not only when the story ends.
    let soon = |time: &f64| (25.0..35.0).contains(time);
    assert!(ended.iter().all(soon), "{ended:?}");
}

#[test]
fn a_component_that_was_removed_while_its_agent_was_away_ends_when_that_is_back() {
    let play = Play::until(60.0).apply(0.5, lone()).crash(5.0, NODE, 20.0);
    let remove = Change::Remove {
        instance: "B0".to_owned(),
    };
    let story = play.change(10.0, remove).play();
    let gone = story.only(&["node1", "B0", "deleted"]);
    assert!((25.0..35.0).contains(&gone), "{gone}");
    story.never(0.0, story.settled(), &["local", "deleted"]);
}

#[test]
fn what_was_torn_down_while_its_machine_was_off_does_not_come_back_with_it() {
    let dark = Fault::Reboot {
        node: NODE.to_owned(),
        down: seconds(20.0),
    };
    let play = Play::until(60.0).apply(0.5, alpha()).strike(5.0, dark);
    let story = play.delete(10.0).play();
    assert_eq!(story.times(&["node1", "created"]).len(), 2);
}
