//! Systems written with what a person changed by hand.

use rts_plan::{StoredSystem, with_drift};
use rts_schemas::system::{Direction, DriftPolicy, PortKind, PortSpec};

use crate::world::specs::{component, connector, hello, stored, with_policy};
use crate::world::story::{Story, tell_drift};

/// The system with all that was changed by hand.
#[test]
fn all_that_was_changed() {
    let mut system = hello();
    system.spec.components[0].ports.push(PortSpec {
        name: "out".to_owned(),
        kind: PortKind::Data,
        direction: Some(Direction::Out),
        data_type: Some("IDL:RTC/TimedDouble:1.0".to_owned()),
    });
    let mut story = Story::started(system.clone());
    story.world.set_gain("2.0");
    story.world.connect_new("Sine0", "Filter0");
    story.world.connect_new("Sine0", "Printer0");
    story.world.disconnect("Filter0", "Filter0.out-Printer0.in");
    let (spec, notes) = with_drift(&system.spec, &story.plan().drift, |_| true);
    insta::assert_json_snapshot!((&spec.components[1].configuration, &spec.connectors));
    assert_eq!(notes, Vec::<String>::new());
    story.world.apply(StoredSystem { spec, ..system });
    assert!(
        story.plan().in_step() && story.plan().drift.is_empty(),
        "{}",
        story.plan()
    );
}

#[test]
fn tells_what_no_profile_can_say() {
    let system = hello();
    let mut story = Story::started(system.clone());
    story.world.deactivate("Printer0");
    story.world.create_by_hand(0, "Mine0", true);
    story.world.connect_new("Sine0", "Mine0");
    let mut other = story.world.component("Filter0").unwrap().connectors[0].clone();
    other.by_hand = Some(digest(&story));
    other.target.port = "other".to_owned();
    for component in story
        .world
        .components_mut()
        .filter(|c| c.instance == "Filter0")
    {
        component.connectors[0] = other.clone();
    }
    let (spec, notes) = with_drift(&system.spec, &story.plan().drift, |_| true);
    assert_eq!(spec, system.spec);
    insta::assert_snapshot!(notes.join("\n"));
    // Nor is any of it adopted.
    story.world.apply(with_policy(DriftPolicy::Adopt));
    insta::assert_snapshot!("none_of_it_is_adopted", tell_drift(&story.plan()));
}

/// The digest of the connector from Filter0 to Printer0.
fn digest(story: &Story) -> String {
    let desired = story.world.desired();
    let connectors = &desired.nodes["local"].systems[0].connectors;
    let name = "Filter0.out-Printer0.in";
    connectors
        .iter()
        .find(|c| c.spec.name == name)
        .unwrap()
        .digest()
}

/// Names of sets and instances may hold dots.
#[test]
fn dots_in_names_are_written_back() {
    let mut system = hello();
    system.spec.components = ["A", "A.b"].map(|name| component(name, "T")).to_vec();
    let values = [("gain".to_owned(), "1".to_owned())].into();
    let sets = &mut system.spec.components[1].configuration.sets;
    sets.insert("set.of.mine".to_owned(), values);
    system.spec.connectors = vec![connector(("A", "out"), ("A.b", "in"))];
    system.spec.orders = Default::default();
    let system = stored(system.spec);
    let mut story = Story::started(system.clone());
    let (desired, live) = (
        story.world.desired(),
        story.world.component("A.b").unwrap().clone(),
    );
    story
        .world
        .set_by_hand(&desired, &live, "set.of.mine", "2.5");
    story.world.connect_new("A.b", "A");
    let (spec, notes) = with_drift(&system.spec, &story.plan().drift, |_| true);
    assert_eq!(notes, Vec::<String>::new());
    story.world.apply(StoredSystem { spec, ..system });
    assert!(
        story.plan().in_step() && story.plan().drift.is_empty(),
        "{}",
        story.plan()
    );
}
