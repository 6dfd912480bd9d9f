//! What a plan does when a process has died or hangs, as a story in text: policies, and what is held.

use rts_plan::StoredSystem;
use rts_plan::observed::{ConnectorState, Held, LifeCycleState};
use rts_plan::plan::Step;
use rts_schemas::system::OnDisconnect;

use crate::world::World;
use crate::world::specs::{component, connector, hello, stored};
use crate::world::story::Story;

/// The hello line with each component in a process of its own.
fn three_processes() -> StoredSystem {
    let mut system = hello();
    for component in &mut system.spec.components {
        component.placement.isolated = true;
    }
    system
}

fn with_policy(instances: &[&str], policy: OnDisconnect) -> StoredSystem {
    let mut system = three_processes();
    for component in &mut system.spec.components {
        if instances.contains(&component.instance.as_str()) {
            component.policy.on_disconnect = policy;
        }
    }
    system
}

fn running(system: StoredSystem) -> Story {
    let mut story = Story::of(system);
    story.turn();
    assert!(story.plan().is_empty(), "{}", story.plan());
    story
}

fn kill(world: &mut World, manager: &str) {
    let mut all = world.managers();
    let at = all.position(|(_, m)| m.key.display_name() == manager);
    drop(all);
    world.kill(at.unwrap());
}

/// Its process died too often: its agent holds it.
fn hold(story: &mut Story, instance: &str) {
    let system = story.world.systems[0].reference.clone();
    story.world.nodes.get_mut("local").unwrap().held.push(Held {
        part: None,
        system,
        instance: instance.to_owned(),
        reason: "its process died 4 times within 10 min".to_owned(),
    });
}

fn state(story: &Story, instance: &str) -> Option<LifeCycleState> {
    story.world.component(instance).map(|c| c.state)
}

/// Both its connectors are made again, and nothing else is touched.
#[test]
fn one_of_three_processes_is_gone() {
    let mut story = running(three_processes());
    kill(&mut story.world, "hello.Filter0");
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().is_empty());
}

#[test]
fn what_is_held_is_not_brought_up() {
    let mut story = running(three_processes());
    kill(&mut story.world, "hello.Filter0");
    hold(&mut story, "Filter0");
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().steps.is_empty());
    story.world.apply(three_processes());
    story.turn();
    assert!(story.plan().is_empty());
}

#[test]
fn what_is_there_is_not_held() {
    let mut story = running(three_processes());
    hold(&mut story, "Filter0");
    assert!(story.plan().is_empty());
}

fn expire(story: &mut Story, responsive: bool) {
    let mut managers = story.world.managers_mut();
    let main = managers.find(|m| m.key.display_name() == "hello.main");
    let main = main.unwrap();
    main.expired = Some("Sine0 has been in on_execute for 9 s".to_owned());
    main.responsive = responsive;
}

/// Nothing is asked of what is in it, whether it answers or not.
#[test]
fn an_expired_process_is_replaced() {
    let replaced = |responsive| {
        let mut story = Story::running();
        expire(&mut story, responsive);
        let told = story.turn();
        assert!(story.plan().is_empty());
        told
    };
    insta::assert_snapshot!(replaced(true));
    assert_eq!(replaced(true), replaced(false));
}

#[test]
fn an_expired_process_in_its_back_off_is_left_alone() {
    let mut story = Story::running();
    expire(&mut story, false);
    let manager = "local|manager/hello.main".to_owned();
    story
        .blocked
        .insert(manager, "died a second ago".to_owned());
    insta::assert_snapshot!(story.turn());
}

#[test]
fn deactivated_for_a_lost_peer() {
    let mut story = running(with_policy(
        &["Sine0", "Printer0"],
        OnDisconnect::Deactivate,
    ));
    kill(&mut story.world, "hello.Filter0");
    assert_eq!(state(&story, "Sine0"), Some(LifeCycleState::Inactive));
    let target = "local|manager/hello.Filter0".to_owned();
    story.blocked.insert(target, "died a second ago".to_owned());
    let waits = story.turn();
    assert!(story.plan().steps.is_empty());
    story.blocked.clear();
    let back = story.turn();
    insta::assert_snapshot!(format!("{waits}\n{back}"));
    assert!(story.plan().is_empty());
}

#[test]
fn stopped_for_a_lost_peer() {
    let mut story = running(with_policy(&["Sine0", "Printer0"], OnDisconnect::Stop));
    kill(&mut story.world, "hello.Filter0");
    assert_eq!(state(&story, "Sine0"), None);
    hold(&mut story, "Filter0");
    let waits = story.turn();
    assert!(story.plan().steps.is_empty());
    story
        .world
        .apply(with_policy(&["Sine0", "Printer0"], OnDisconnect::Stop));
    let back = story.turn();
    insta::assert_snapshot!(format!("{waits}\n{back}"));
    assert!(story.plan().is_empty());
}

/// The managers have not acted: the plan does.
#[test]
fn the_plan_acts_where_the_manager_did_not() {
    let mut told = String::new();
    for policy in [OnDisconnect::Deactivate, OnDisconnect::Stop] {
        let mut story = running(with_policy(&["Sine0"], policy));
        let connector = story.world.components_mut().find(|c| c.instance == "Sine0");
        connector.unwrap().connectors[0].state = ConnectorState::Disconnected;
        let target = "local|connector/Sine0.out-Filter0.in".to_owned();
        story.blocked.insert(target, "no answer".to_owned());
        told.push_str(&story.turn());
        assert_ne!(state(&story, "Sine0"), Some(LifeCycleState::Active));
        story.blocked.clear();
        story.ends_well();
        assert_eq!(state(&story, "Sine0"), Some(LifeCycleState::Active));
    }
    insta::assert_snapshot!(told);
}

#[test]
fn a_changed_policy_is_set_in_place() {
    let mut story = running(three_processes());
    story
        .world
        .apply(with_policy(&["Filter0"], OnDisconnect::Stop));
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().is_empty());
}

/// Everyone waits for everyone's connectors, not for everyone's activation.
#[test]
fn a_circle_of_policies_comes_up() {
    for policy in [OnDisconnect::Deactivate, OnDisconnect::Stop] {
        let mut system = with_policy(&["Sine0", "Filter0", "Printer0"], policy);
        let feedback = connector(("Printer0", "out"), ("Sine0", "in"));
        system.spec.connectors.push(feedback);
        let mut story = running(system);
        kill(&mut story.world, "hello.Filter0");
        story.turn();
        assert!(story.plan().is_empty(), "{}", story.plan());
    }
}

/// The end of a long chain cannot be made: everyone stops in one plan.
#[test]
fn a_long_chain_stops_at_once() {
    const COUNT: usize = 300;
    let name = |number: usize| format!("C{number}");
    let mut system = hello();
    let policy = |number| {
        let mut spec = component(&name(number), "T");
        spec.policy.on_disconnect = OnDisconnect::Stop;
        spec
    };
    system.spec.components = (0..COUNT).map(policy).collect();
    system.spec.connectors = (1..COUNT)
        .map(|n| connector((&name(n - 1), "out"), (&name(n), "in")))
        .collect();
    system.spec.orders = Default::default();
    let mut story = running(stored(system.spec));
    for component in story.world.components_mut() {
        if component.instance == name(0) {
            component.connectors.clear();
        }
    }
    let target = "local|connector/C0.out-C1.in".to_owned();
    story.blocked.insert(target, "no answer".to_owned());
    let deleted = |step: &&Step| step.work.kind() == "Delete";
    assert_eq!(story.plan().steps.iter().filter(deleted).count(), COUNT);
}
