//! The hello system's life as a story in text: what is planned at each turn, then carried out.

use rts_plan::observed::LifeCycleState;
use rts_plan::plan::{Blocked, Plan};
use rts_plan::{plan, render};
use rts_schemas::system::{DriftPolicy, PortKind};

use crate::world::World;
use crate::world::execute::Chance;
use crate::world::specs::{component, connector, hello, set, stored};
use crate::world::story::{Story, tell};

#[test]
fn first_apply() {
    let mut story = Story::new();
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().is_empty());
}

#[test]
fn no_change() {
    insta::assert_snapshot!(tell(&Story::running().plan()), @"Plan: 0 to add, 0 to change, 0 to remove");
}

#[test]
fn changed_configuration() {
    let mut story = Story::running();
    let mut changed = hello();
    set(&mut changed.spec.components[1], "gain", "2.0");
    set(&mut changed.spec.components[0], "amplitude", "1");
    changed.spec.components[0].execution_context.rate = Some(50.0);
    story.world.apply(changed);
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().is_empty());
}

#[test]
fn changed_order_in_an_execution_context() {
    let mut shared = hello();
    for (component, order) in shared.spec.components.iter_mut().zip([10, 20]) {
        component.execution_context.name = Some("control".to_owned());
        component.execution_context.order = order;
    }
    let mut story = Story::running();
    story.world.apply(shared.clone());
    let made = story.turn();
    assert!(story.plan().is_empty());
    shared.spec.components[0].execution_context.order = 30;
    story.world.apply(shared);
    let changed = story.turn();
    insta::assert_snapshot!(format!("{made}\n{changed}"));
    assert!(story.plan().is_empty());
}

#[test]
fn changed_connector() {
    let mut story = Story::running();
    let mut changed = hello();
    let properties = &mut changed.spec.connectors[0].properties;
    properties.insert("dataport.subscription_type".to_owned(), "new".to_owned());
    story.world.apply(changed);
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().is_empty());
}

#[test]
fn moved_component() {
    let mut story = Story::running();
    let mut changed = hello();
    changed.spec.components[2].placement.isolated = false;
    story.world.apply(changed);
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().is_empty());
}

#[test]
fn changed_module_restarts_its_process() {
    let mut story = Story::running();
    let mut changed = hello();
    let digest = changed.module_digests.get_mut("LowPassFilter").unwrap();
    *digest = "digest-LowPassFilter-1".to_owned();
    story.world.apply(changed);
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().is_empty());
}

#[test]
fn changed_type_restarts_one_component() {
    let mut story = Story::running();
    let mut changed = hello();
    changed.spec.components[0].type_name = "SquareSource".to_owned();
    story.world.apply(changed);
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().is_empty());
}

#[test]
fn killed_manager() {
    let mut story = Story::running();
    story.world.kill(0);
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().is_empty());
}

#[test]
fn teardown() {
    let mut story = Story::running();
    story.world.delete("hello");
    insta::assert_snapshot!(story.turn());
    assert_eq!(story.world.managers().count(), 0);
    assert!(story.plan().is_empty());
}

#[test]
fn component_removed() {
    let mut story = Story::running();
    let mut changed = hello();
    changed.spec.components.remove(0);
    changed.spec.connectors.remove(0);
    changed.spec.orders.activation.pop();
    story.world.apply(changed);
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().is_empty());
}

#[test]
fn what_was_left_at_an_in_port_is_unbound() {
    let mut story = Story::running();
    let names = |story: &Story| -> Vec<String> {
        let all = story.world.components();
        all.map(|(_, _, c)| c.instance.clone()).collect()
    };
    let filter = names(&story).iter().position(|name| name == "Filter0");
    story.world.leave_end(filter.unwrap(), false);
    let left = story.turn();
    assert_eq!(story.world.left_ends(), []);
    assert!(story.plan().is_empty());
    // An end of a name that is connected elsewhere anew: the old one goes first.
    let printer = names(&story).iter().position(|name| name == "Printer0");
    story.world.leave_end(printer.unwrap(), true);
    story.world.disconnect("Sine0", "Sine0.out-Filter0.in");
    let elsewhere = story.turn();
    assert_eq!(story.world.left_ends(), []);
    assert!(story.plan().is_empty());
    insta::assert_snapshot!(format!("{left}\n{elsewhere}"));
}

#[test]
fn the_end_of_what_a_person_connected_stays_as_long_as_it_has_a_source() {
    let mut story = Story::running();
    for component in &mut story.world.systems[0].spec.components {
        component.policy.drift = DriftPolicy::Ignore;
    }
    story.world.connect_new("Sine0", "Printer0");
    assert!(story.plan().is_empty());
    let mut managers = story.world.managers();
    let source = managers.position(|(_, m)| m.key.name == "main");
    drop(managers);
    story.world.kill(source.unwrap());
    insta::assert_snapshot!(story.turn());
    assert_eq!(story.world.left_ends(), []);
    assert!(story.plan().is_empty());
}

#[test]
fn failed_module_blocks_its_component_and_what_needs_it() {
    let mut story = Story::new();
    let why = "dlopen: undefined symbol: foo".to_owned();
    story
        .blocked
        .insert("local|module/Printer@hello.Printer0".to_owned(), why);
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().steps.is_empty(), "{}", story.plan());
    story.blocked.clear();
    story.ends_well();
    assert!(story.plan().waiting_on.is_empty());
}

#[test]
fn nothing_is_stopped_whose_replacement_is_blocked() {
    let mut story = Story::running();
    let mut changed = hello();
    changed.spec.components[0].type_name = "SquareSource".to_owned();
    story.world.apply(changed);
    let why = "no module file for SquareSource".to_owned();
    story
        .blocked
        .insert("local|package/SquareSource@local".to_owned(), why);
    insta::assert_snapshot!(story.turn(), @r"
    ~ component/Sine0  is not as written; waits, see below
    waiting: component/Sine0: package/SquareSource@local is blocked: no module file for SquareSource
    Plan: 0 to add, 1 to change, 0 to remove
    ");
}

#[test]
fn error_waits_for_a_person_or_is_reset() {
    let mut story = Story::running();
    let filter = story
        .world
        .components_mut()
        .find(|c| c.instance == "Filter0");
    let filter = filter.unwrap();
    filter.state = LifeCycleState::Error;
    filter.message = Some("on_execute returned BAD_PARAMETER".to_owned());
    let waits = story.turn();
    let mut changed = hello();
    changed.spec.components[1].policy.reset_on_error = true;
    story.world.apply(changed);
    let reset = story.turn();
    insta::assert_snapshot!(format!("{waits}\n{reset}"));
    assert!(story.plan().is_empty());
}

#[test]
fn what_cannot_be_seen_is_left_alone() {
    let mut story = Story::running();
    story.world.managers_mut().next().unwrap().responsive = false;
    let manager = story.turn();
    story.world.silent.insert("local".to_owned());
    let node = story.turn();
    story.world.delete("hello");
    let deletion = story.turn();
    insta::assert_snapshot!(format!("{manager}\n{node}\n{deletion}"));
}

#[test]
fn what_has_not_said_what_it_holds_is_not_empty() {
    let mut story = Story::running();
    let main = |story: &Story| {
        let mut managers = story.world.managers();
        managers.position(|(_, m)| m.key.name == "main").unwrap()
    };
    let nth = main(&story);
    story.world.lose_sight_of_manager(nth);
    let silent = story.turn();
    // Somewhere else it may be a second one.
    for component in &mut story.world.systems[0].spec.components {
        component.placement.isolated = component.instance != "Sine0";
    }
    let moved = story.turn();
    assert!(story.plan().steps.is_empty());
    for component in &mut story.world.systems[0].spec.components {
        component.placement.isolated = true;
    }
    // Nothing is desired in it any more.
    let all_moved = story.turn();
    insta::assert_snapshot!(format!("{silent}\n{moved}\n{all_moved}"));
    assert!(story.plan().is_empty());
}

#[test]
fn what_has_not_said_what_it_holds_is_replaced_or_goes_with_its_system() {
    let mut replaced = Story::running();
    let nth = replaced
        .world
        .managers()
        .position(|(_, m)| m.key.name == "main");
    let nth = nth.unwrap();
    replaced.world.lose_sight_of_manager(nth);
    let main = replaced.world.managers_mut().nth(nth);
    main.unwrap().expired = Some("its process has not answered for longer than 5 s".to_owned());
    let replacement = replaced.turn();
    replaced.ends_well();
    let mut deleted = Story::running();
    deleted.world.lose_sight_of_manager(nth);
    deleted.world.delete("hello");
    let deletion = deleted.turn();
    insta::assert_snapshot!(format!("{replacement}\n{deletion}"));
    assert_eq!(deleted.world.managers().count(), 0);
}

#[test]
fn made_by_hand_is_drift() {
    let mut story = Story::running();
    story.world.create_by_hand(0, "Mine0", false);
    story.world.create_by_hand(0, "Mine1", true);
    let drift = story.turn();
    story.world.delete("hello");
    let teardown = story.turn();
    insta::assert_snapshot!(format!("{drift}\n{teardown}"));
    assert_eq!(story.world.components().count(), 1);
}

#[test]
fn a_name_taken_by_hand_waits() {
    let mut story = Story::new();
    story.world.create_by_hand(0, "Sine0", true);
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().steps.is_empty());
}

#[test]
fn data_flow_in_a_circle_gives_no_order() {
    let mut system = hello();
    system.spec.orders.activation.clear();
    let feedback = connector(("Printer0", "out"), ("Sine0", "in"));
    system.spec.connectors.push(feedback);
    let mut service = connector(("Printer0", "svc"), ("Sine0", "svc"));
    service.kind = PortKind::Service;
    system.spec.connectors.push(service);
    let mut story = Story::new();
    story.world.apply(system);
    insta::assert_snapshot!(story.turn());
    assert!(story.plan().is_empty());
}

/// Orders with a cycle are refused when a system is applied; a planner that gets them all the same must not hang.
#[test]
fn a_cycle_of_hard_orders_waits() {
    let mut system = hello();
    let sync = rts_schemas::system::SendingTiming::Sync;
    let closing = crate::world::specs::after("Printer0", 0, sync, &["Sine0"]);
    system.spec.orders.activation.push(closing.clone());
    system.spec.orders.deactivation = system.spec.orders.activation.clone();
    system.spec.orders.shut_down = system.spec.orders.activation.clone();
    let errors = rts_plan::check_orders(&system.spec);
    let errors: Vec<String> = errors.iter().map(ToString::to_string).collect();
    let mut story = Story::new();
    story.world.apply(system);
    let plan = story.plan();
    let chance = Chance {
        pick: &mut |_| 0,
        fails: &mut |_| false,
    };
    story.world.execute(&plan, chance).unwrap();
    insta::assert_snapshot!(format!("{}\n{}", errors.join("\n"), render(&story.plan())));
    // Nor must it keep anything alive.
    story.world.delete("hello");
    let kinds: Vec<&str> = story.plan().steps.iter().map(|s| s.work.kind()).collect();
    let expected = ["Delete", "Delete", "Delete", "StopManager", "StopManager"];
    assert_eq!(kinds, expected);
}

/// Ten processes start at once: nothing makes one wait for another.
#[test]
fn independent_steps_need_nothing() {
    let mut system = hello();
    system.spec.components = (0..10)
        .map(|number| {
            let mut spec = component(&format!("Sine{number}"), "SineSource");
            spec.placement.isolated = true;
            spec
        })
        .collect();
    system.spec.connectors.clear();
    system.spec.orders.activation.clear();
    let mut world = World::new(&["local"]);
    world.apply(stored(system.spec));
    let plan = plan(&world.desired(), &world.observed(), &Blocked::new());
    let count = |kind| plan.steps.iter().filter(|s| s.work.kind() == kind).count();
    assert_eq!(count("StartManager"), 10);
    assert_eq!(count("Install"), 1);
    for step in &plan.steps {
        let needs = match step.work.kind() {
            "Install" | "StartManager" => 0,
            "LoadModule" => 2,
            _ => 1,
        };
        assert_eq!(step.needs.len(), needs, "{step:?}");
    }
}

/// A plan travels as JSON.
#[test]
fn plan_survives_json() {
    let plan = Story::new().plan();
    let json = serde_json::to_string(&plan).unwrap();
    assert_eq!(serde_json::from_str::<Plan>(&json).unwrap(), plan);
}

/// A target that was replaced is seen by its incarnation, even when the source has not noticed.
#[test]
fn replaced_target_is_connected_anew() {
    let mut story = Story::running();
    let printer = story
        .world
        .components_mut()
        .find(|c| c.instance == "Printer0");
    printer.unwrap().incarnation = "another".to_owned();
    insta::assert_snapshot!(tell(&story.plan()), @r"
    ~ connector/Filter0.out-Printer0.in  its target Printer0 was made again
    Plan: 0 to add, 1 to change, 0 to remove
      1 Disconnect   connector/Filter0.out-Printer0.in  (its target Printer0 was made again)
      2 Connect      connector/Filter0.out-Printer0.in  after 1  (its target Printer0 was made again)
    critical path: 1 → 2 (2 steps)
    ");
}

/// Planning stays near n log n: here a quadratic step would be felt at once.
#[test]
fn large_systems_are_planned() {
    const COUNT: usize = 3000;
    let mut system = hello();
    let name = |number: usize| format!("C{number}");
    system.spec.components = (0..COUNT).map(|n| component(&name(n), "T")).collect();
    system.spec.connectors = (1..COUNT)
        .map(|n| connector((&name(n - 1), "out"), (&name(n), "in")))
        .collect();
    let sync = rts_schemas::system::SendingTiming::Sync;
    system.spec.orders.activation = (0..COUNT)
        .map(|n| crate::world::specs::after(&name(n), (COUNT - n) as u32, sync, &[]))
        .collect();
    let mut world = World::new(&["local"]);
    world.apply(stored(system.spec));
    let plan = plan(&world.desired(), &world.observed(), &Blocked::new());
    assert_eq!(plan.steps.len(), 3 + 2 * COUNT + COUNT - 1);
    assert_eq!(plan.notes, Vec::<String>::new());
}
