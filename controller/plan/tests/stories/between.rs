//! Connectors between nodes: what the controller plans, and what the agent of one of the nodes plans alone.

use rts_plan::observed::{LifeCycleState, ManagerObserved};
use rts_plan::plan::{Blocked, Plan, Work};
use rts_plan::{StoredSystem, plan};
use rts_schemas::system::{OnDisconnect, Orders};

use crate::world::World;
use crate::world::specs::hello;
use crate::world::story::Story;

/// The hello line, with Filter0 on node two and the others on node one.
fn two_nodes(policy: OnDisconnect) -> StoredSystem {
    let mut system = hello();
    for component in &mut system.spec.components {
        let filter = component.instance == "Filter0";
        component.placement.node = Some(if filter { "two" } else { "one" }.to_owned());
        component.policy.on_disconnect = policy;
    }
    system
}

fn running(system: StoredSystem) -> Story {
    let mut story = Story::of(system.clone());
    story.world = World::new(&["one", "two"]);
    story.world.apply(system);
    story.turn();
    assert!(story.plan().is_empty(), "{}", story.plan());
    story
}

/// What the agent of a node plans.
fn alone(story: &Story, own: &str) -> Plan {
    let (mut desired, mut observed) = (story.world.desired(), story.world.observed());
    desired.nodes.retain(|node, _| node == own);
    observed.nodes.retain(|node, _| node == own);
    plan(&desired, &observed, &Blocked::new())
}

/// The process `main` of a node.
fn kill_on(story: &mut Story, node: &str) {
    let is = |(n, m): (&str, &ManagerObserved)| n == node && m.key.name == "main";
    let at = story.world.managers().position(is);
    story.world.kill(at.unwrap());
}

/// Both its connectors are made again by the nodes of their out-ports, after it is there.
#[test]
fn one_of_two_nodes_has_lost_its_process() {
    let mut story = running(two_nodes(OnDisconnect::Keep));
    kill_on(&mut story, "two");
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().is_empty());
}

/// The other node's agent makes the component again; this one's tries to reach it, as nobody tells it that it is there.
#[test]
fn an_agent_alone_reaches_for_a_lost_target_and_leaves_a_lost_source_to_its_node() {
    let mut story = running(two_nodes(OnDisconnect::Keep));
    for node in ["one", "two"] {
        let plan = alone(&story, node);
        assert!(plan.is_empty() && plan.waiting_on.is_empty(), "{plan}");
    }
    kill_on(&mut story, "two");
    let connects = |plan: &Plan| {
        let steps = plan.steps.iter();
        let connects = steps.filter_map(|step| match &step.work {
            Work::Connect { connector } => Some(connector.spec.name.clone()),
            _ => None,
        });
        connects.collect::<Vec<_>>()
    };
    let plan = alone(&story, "one");
    assert_eq!(connects(&plan), ["Sine0.out-Filter0.in"]);
    assert!(plan.steps.len() <= 2, "nothing else but to part: {plan}");
    let plan = alone(&story, "two");
    assert_eq!(connects(&plan), ["Filter0.out-Printer0.in"]);
}

/// Its own in-port tells whether the source of another node is there.
#[test]
fn an_agent_alone_activates_what_is_fed_from_another_node_and_nothing_else() {
    let mut system = two_nodes(OnDisconnect::Deactivate);
    system.spec.orders = Orders::default();
    let mut story = running(system);
    let set = |story: &mut Story| {
        let filter = story
            .world
            .components_mut()
            .find(|c| c.instance == "Filter0");
        filter.unwrap().state = LifeCycleState::Inactive;
    };
    let activates = |plan: &Plan| {
        let mut steps = plan.steps.iter();
        steps.any(|s| matches!(&s.work, Work::Activate { instance, .. } if instance == "Filter0"))
    };
    set(&mut story);
    assert!(activates(&alone(&story, "two")));
    kill_on(&mut story, "one");
    let plan = alone(&story, "two");
    assert!(!activates(&plan), "{plan}");
    let why = "waits for connector Sine0.out-Filter0.in: rtsctl.onDisconnect is deactivate";
    assert!(
        plan.to_string().contains(why) || format!("{:?}", plan.waiting_on).contains(why),
        "{plan}"
    );
}
