//! What a plan does about what a person changed by hand, as a story in text: each kind of change under each policy.

use rts_plan::StoredSystem;
use rts_plan::observed::{ConnectorState, LifeCycleState};
use rts_schemas::system::{DriftPolicy, OnDisconnect, SendingTiming};

use crate::world::World;
use crate::world::specs::{after, set, with_policy};
use crate::world::story::{Story, tell_drift};

const POLICIES: [DriftPolicy; 3] = [DriftPolicy::Repair, DriftPolicy::Ignore, DriftPolicy::Adopt];

/// Under each policy: what is planned after `act`, and that it is as settled as it should be once that is done.
fn under_each_policy(act: impl Fn(&mut World)) -> String {
    let mut text = String::new();
    for policy in POLICIES {
        let mut story = Story::started(with_policy(policy));
        act(&mut story.world);
        let plan = story.plan();
        text.push_str(&format!("-- {}\n{}", policy.as_str(), tell_drift(&plan)));
        story.turn();
        let then = story.plan();
        assert!(then.in_step(), "{then}");
        match policy {
            DriftPolicy::Repair => assert_eq!(then.drift, []),
            _ => assert_eq!(then.drift, plan.drift),
        }
    }
    text
}

#[test]
fn a_changed_value() {
    insta::assert_snapshot!(under_each_policy(|world| world.set_gain("2.0")));
}

#[test]
fn another_active_set() {
    insta::assert_snapshot!(under_each_policy(|world| {
        let (desired, filter) = (world.desired(), world.component("Filter0").unwrap().clone());
        world.set_by_hand(&desired, &filter, "fast", "");
    }));
}

/// A value that the profile does not write stands against the module's default.
#[test]
fn a_changed_default() {
    insta::assert_snapshot!(under_each_policy(|world| {
        let mut printers = world.components_mut().filter(|c| c.instance == "Printer0");
        let printer = printers.next().unwrap();
        printer.defaults.insert("gain".to_owned(), "0".to_owned());
        drop(printers);
        let (desired, printer) = (
            world.desired(),
            world.component("Printer0").unwrap().clone(),
        );
        world.set_by_hand(&desired, &printer, "default", "5");
    }));
}

#[test]
fn a_deactivated_component() {
    insta::assert_snapshot!(under_each_policy(|world| world.deactivate("Filter0")));
}

/// Its values are adopted; that it is Inactive cannot be, and stays as it is.
#[test]
fn a_deactivated_and_changed_component() {
    insta::assert_snapshot!(under_each_policy(|world| {
        world.deactivate("Filter0");
        world.set_gain("2.0");
    }));
}

#[test]
fn a_connector_taken_away() {
    insta::assert_snapshot!(under_each_policy(|world| {
        world.disconnect("Sine0", "Sine0.out-Filter0.in");
    }));
}

#[test]
fn a_connector_too_many() {
    insta::assert_snapshot!(under_each_policy(
        |world| world.connect_new("Sine0", "Printer0")
    ));
}

#[test]
fn a_connector_made_anew() {
    insta::assert_snapshot!(under_each_policy(
        |world| world.connect_new("Sine0", "Filter0")
    ));
}

/// Set by hand to what it was: nothing differs.
#[test]
fn back_to_what_is_desired_is_no_drift() {
    let mut story = Story::started(with_policy(DriftPolicy::Adopt));
    story.world.set_gain("2.0");
    story.world.set_gain("1.0");
    assert!(story.plan().in_step() && story.plan().drift.is_empty());
}

/// Without a mark nobody did it: it is mended whatever the policy.
#[test]
fn what_nobody_did_is_mended() {
    let mut story = Story::started(with_policy(DriftPolicy::Ignore));
    for component in story.world.components_mut() {
        component.state = LifeCycleState::Inactive;
        component.connectors.clear();
        component.configuration.active = Some("other".to_owned());
    }
    assert_eq!(story.plan().drift, []);
    story.turn();
    assert!(story.plan().in_step(), "{}", story.plan());
    assert!(
        story
            .world
            .components()
            .all(|(_, _, c)| c.state == LifeCycleState::Active)
    );
}

/// What is ordered after a component that a person deactivated waits for it, unless it is optional.
#[test]
fn what_is_ordered_after_it_waits() {
    let mut text = String::new();
    for required in [true, false] {
        let mut system = with_policy(DriftPolicy::Ignore);
        system.spec.components[2].required = required;
        let mut story = Story::started(system);
        story.world.deactivate("Printer0");
        assert!(story.plan().in_step());
        for component in story
            .world
            .components_mut()
            .filter(|c| c.instance == "Filter0")
        {
            component.state = LifeCycleState::Inactive;
        }
        let required = if required { "required" } else { "optional" };
        text.push_str(&format!("-- {required}\n{}", tell_drift(&story.plan())));
    }
    insta::assert_snapshot!(text);
}

/// `onDisconnect` says what must not run without its connector, whoever took that away; but nobody is deleted for what
/// a person did and is left.
#[test]
fn without_a_connector_that_a_person_took_away() {
    let mut text = String::new();
    for on_disconnect in [OnDisconnect::Deactivate, OnDisconnect::Stop] {
        let mut system = with_policy(DriftPolicy::Ignore);
        system.spec.components[0].policy.on_disconnect = on_disconnect;
        let mut story = Story::started(system);
        story.world.disconnect("Sine0", "Sine0.out-Filter0.in");
        let on_disconnect = on_disconnect.as_str();
        text.push_str(&format!("-- {on_disconnect}\n{}", story.turn()));
        assert!(story.plan().steps.is_empty(), "{}", story.plan());
        assert_eq!(
            story.world.component("Sine0").unwrap().state,
            LifeCycleState::Inactive
        );
    }
    insta::assert_snapshot!(text);
}

/// A connector made by hand is left as long as it works.
#[test]
fn a_connector_made_by_hand_that_is_lost() {
    let mut story = Story::started(with_policy(DriftPolicy::Ignore));
    story.world.connect_new("Sine0", "Printer0");
    story.world.connect_new("Filter0", "Printer0");
    assert_eq!(story.plan().drift.len(), 2);
    for connector in story.world.components_mut().flat_map(|c| &mut c.connectors) {
        if connector.by_hand.is_some() {
            connector.state = ConnectorState::Disconnected;
        }
    }
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().in_step() && story.plan().drift.is_empty());
}

/// A mark counts for what was desired then: another wish replaces what a person did. That a component is Active is
/// always wished: what a person deactivated stays so.
#[test]
fn a_changed_profile_replaces_it() {
    let mut story = Story::started(with_policy(DriftPolicy::Ignore));
    story.world.set_gain("2.0");
    story.world.deactivate("Printer0");
    story.world.disconnect("Sine0", "Sine0.out-Filter0.in");
    assert!(story.plan().in_step());
    let mut changed = with_policy(DriftPolicy::Ignore);
    set(&mut changed.spec.components[1], "gain", "3.0");
    set(&mut changed.spec.components[2], "width", "80");
    let properties = &mut changed.spec.connectors[0].properties;
    properties.insert("dataport.subscription_type".to_owned(), "new".to_owned());
    story.world.apply(changed);
    insta::assert_snapshot!(tell_drift(&story.plan()));
    story.turn();
    let plan = story.plan();
    assert!(plan.in_step() && plan.drift.len() == 1, "{plan}");
}

/// hello, under a policy, with one more value in Filter0.
fn with_alpha(policy: DriftPolicy) -> StoredSystem {
    let mut system = with_policy(policy);
    set(&mut system.spec.components[1], "alpha", "0.1");
    system
}

/// The profile changes one value and the rate of a component: what a person changed besides stays.
#[test]
fn what_is_left_stays_when_something_else_changes() {
    let mut story = Story::started(with_alpha(DriftPolicy::Ignore));
    story.world.set_gain("2.0");
    story.world.deactivate("Filter0");
    let mut changed = with_alpha(DriftPolicy::Ignore);
    set(&mut changed.spec.components[1], "alpha", "0.9");
    changed.spec.components[1].execution_context.rate = Some(50.0);
    story.world.apply(changed);
    insta::assert_snapshot!(tell_drift(&story.plan()));
    story.turn();
    story.world.forget_stale_marks();
    let plan = story.plan();
    assert!(plan.in_step() && plan.drift.len() == 1, "{plan}");
    // Repaired after all.
    let mut repaired = with_alpha(DriftPolicy::Repair);
    set(&mut repaired.spec.components[1], "alpha", "0.9");
    repaired.spec.components[1].execution_context.rate = Some(50.0);
    story.world.apply(repaired);
    insta::assert_snapshot!("and_is_repaired", tell_drift(&story.plan()));
    story.turn();
    let plan = story.plan();
    assert!(plan.in_step() && plan.drift.is_empty(), "{plan}");
}

/// Stores what is to be adopted at this moment, while a person goes on.
fn adopt_late(meanwhile: impl Fn(&mut World)) -> String {
    let system = with_alpha(DriftPolicy::Adopt);
    let mut story = Story::started(system.clone());
    story.world.set_gain("2.0");
    let seen = story.plan().drift;
    meanwhile(&mut story.world);
    let (spec, _) = rts_plan::with_drift(&system.spec, &seen, |_| true);
    story.world.apply(StoredSystem { spec, ..system });
    let plan = story.plan();
    assert!(plan.in_step(), "{plan}");
    // Whether agents come to forget before or after.
    story.world.forget_stale_marks();
    assert_eq!(story.plan(), plan);
    tell_drift(&plan)
}

/// What a person changes while an earlier change is being adopted is not lost.
#[test]
fn what_is_changed_while_another_change_is_adopted() {
    let same = adopt_late(|world| ["3.0", "4.0"].iter().for_each(|v| world.set_gain(v)));
    let other = adopt_late(|world| world.set_value("Filter0", "alpha", "0.5"));
    let back = adopt_late(|world| world.set_gain("1.0"));
    let idle = adopt_late(|world| world.deactivate("Filter0"));
    let all = [
        ("same", same),
        ("other", other),
        ("back", back),
        ("idle", idle),
    ];
    let all = all.map(|(name, text)| format!("-- {name}\n{text}"));
    insta::assert_snapshot!(all.concat());
}

/// Under a policy that leaves it, what a person set is no wish: written in the profile, an earlier value comes.
#[test]
fn an_earlier_value_may_be_written() {
    let mut story = Story::started(with_policy(DriftPolicy::Ignore));
    story.world.set_gain("2.0");
    story.world.set_gain("3.0");
    let mut changed = with_policy(DriftPolicy::Ignore);
    set(&mut changed.spec.components[1], "gain", "2.0");
    story.world.apply(changed);
    story.turn();
    let filter = story.world.component("Filter0").unwrap();
    assert_eq!(filter.configuration.sets["default"]["gain"], "2.0");
    assert!(story.plan().in_step() && story.plan().drift.is_empty());
}

/// What a component outside of all systems feeds into one is in no plan, but is told.
#[test]
fn a_connector_from_a_component_made_by_hand() {
    let mut story = Story::started(with_policy(DriftPolicy::Repair));
    story.world.create_by_hand(0, "Mine0", true);
    story.world.connect_new("Mine0", "Filter0");
    let plan = story.plan();
    assert!(plan.in_step() && plan.drift.is_empty(), "{plan}");
    insta::assert_snapshot!(plan.notes.join("\n"));
}

/// What is changed besides is changed, and the rest left: a plan's change of the rate or a policy ends no mark.
#[test]
fn what_is_left_survives_other_changes() {
    let mut story = Story::started(with_policy(DriftPolicy::Ignore));
    story.world.set_gain("2.0");
    let mut changed = with_policy(DriftPolicy::Ignore);
    changed.spec.components[1].policy.on_disconnect = OnDisconnect::Deactivate;
    story.world.apply(changed);
    insta::assert_snapshot!(tell_drift(&story.plan()));
    story.turn();
    assert!(story.plan().in_step());
    assert_eq!(story.plan().drift.len(), 1);
}

/// Marks die with the instance: what starts again is as desired.
#[test]
fn a_new_instance_is_as_desired() {
    let mut story = Story::started(with_policy(DriftPolicy::Ignore));
    story.world.set_gain("2.0");
    story.world.disconnect("Sine0", "Sine0.out-Filter0.in");
    let mut all = story.world.managers();
    let main = all.position(|(_, m)| m.key.name == "main").unwrap();
    drop(all);
    story.world.kill(main);
    story.turn();
    assert!(story.plan().in_step() && story.plan().drift.is_empty());
}

/// What cannot be seen is not told of.
#[test]
fn what_does_not_answer_has_no_drift() {
    let mut story = Story::started(with_policy(DriftPolicy::Adopt));
    story.world.set_gain("2.0");
    story.world.connect_new("Sine0", "Printer0");
    story
        .world
        .managers_mut()
        .for_each(|m| m.responsive = false);
    assert_eq!(story.plan().drift, []);
}

/// An ordered chain of which the middle is deactivated by hand: what runs is not touched, what is ordered after waits.
#[test]
fn a_chain_with_a_gap() {
    let mut system = with_policy(DriftPolicy::Ignore);
    system.spec.orders.activation = vec![
        after("Printer0", 0, SendingTiming::Sync, &[]),
        after("Filter0", 1, SendingTiming::Sync, &[]),
        after("Sine0", 2, SendingTiming::Sync, &[]),
    ];
    let mut story = Story::started(system);
    story.world.deactivate("Printer0");
    for component in story
        .world
        .components_mut()
        .filter(|c| c.instance == "Sine0")
    {
        component.state = LifeCycleState::Inactive;
    }
    insta::assert_snapshot!(tell_drift(&story.plan()));
}
