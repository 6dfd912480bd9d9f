//! Stand-ins come without a module, and give way to what they stand in for.

use rts_plan::StoredSystem;
use rts_schemas::stand_in::shapes;

use crate::world::specs::{hello, set};
use crate::world::story::{Story, tell};

/// The hello system with stand-ins for these.
fn with(stand_ins: &[&str]) -> StoredSystem {
    let mut system = hello();
    settle(&mut system, stand_ins);
    system
}

/// What the stand-ins are made of is decided when it is applied.
fn settle(system: &mut StoredSystem, stand_ins: &[&str]) {
    let names: Vec<String> = stand_ins.iter().map(|name| (*name).to_owned()).collect();
    system.stand_ins = shapes(&system.spec, &names, &system.stand_ins);
}

#[test]
fn no_module_is_loaded_for_one() {
    let mut story = Story::new();
    story.world.apply(with(&["Filter0", "Printer0", "Sine0"]));
    insta::assert_snapshot!(tell(&story.plan()));
    story.turn();
    assert!(story.plan().is_empty());
}

#[test]
fn one_gives_way_to_the_component_itself_and_back() {
    let mut story = Story::new();
    story.world.apply(with(&["Filter0"]));
    story.turn();
    assert!(story.plan().is_empty());
    story.world.apply(hello());
    insta::assert_snapshot!("real", tell(&story.plan()));
    story.turn();
    assert!(story.plan().is_empty());
    story.world.apply(with(&["Filter0"]));
    insta::assert_snapshot!("stand_in", tell(&story.plan()));
    story.turn();
    assert!(story.plan().is_empty());
}

#[test]
fn a_parameter_that_changes_leaves_it_and_its_behaviour_does_not() {
    let mut story = Story::new();
    story.world.apply(with(&["Filter0"]));
    story.turn();
    let mut changed = with(&["Filter0"]);
    set(&mut changed.spec.components[1], "gain", "3.0");
    settle(&mut changed, &["Filter0"]);
    story.world.apply(changed.clone());
    insta::assert_snapshot!("value", tell(&story.plan()));
    story.turn();
    changed.spec.components[1].stand_in.crash_after_ms = Some(5000);
    settle(&mut changed, &["Filter0"]);
    story.world.apply(changed.clone());
    insta::assert_snapshot!("behaviour", tell(&story.plan()));
    story.turn();
    assert!(story.plan().is_empty());
    let played = ("out".to_owned(), vec![vec!["1".to_owned()]]);
    changed.spec.components[1].stand_in.data = [played].into();
    settle(&mut changed, &["Filter0"]);
    story.world.apply(changed);
    assert!(
        tell(&story.plan())
            .starts_with("! component/Filter0                  its stand-in changed")
    );
}

#[test]
fn what_is_undetermined_is_declared_only() {
    let mut story = Story::new();
    let mut system = with(&["Filter0"]);
    for connector in &mut system.spec.connectors {
        connector.data_type = None;
    }
    for component in &mut system.spec.components {
        component.ports.clear();
    }
    system.stand_ins.clear();
    settle(&mut system, &["Filter0"]);
    story.world.apply(system);
    let text = tell(&story.plan());
    assert!(!text.contains("Connect "), "{text}");
    insta::assert_snapshot!(text);
    story.turn();
    assert!(story.plan().is_empty());
}
