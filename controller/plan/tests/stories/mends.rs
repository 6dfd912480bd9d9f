//! What a plan does about processes that are silent, steps that fail again and again, and values that nobody writes.

use rts_plan::plan::{Blocked, Plan};
use rts_plan::{plan, render};

use crate::world::World;
use crate::world::execute::Chance;
use crate::world::specs::hello;

fn running() -> World {
    let mut world = World::new(&["local"]);
    world.apply(hello());
    turn(&mut world, &Blocked::new());
    world
}

fn turn(world: &mut World, blocked: &Blocked) -> Plan {
    let plan = plan(&world.desired(), &world.observed(), blocked);
    let chance = Chance {
        pick: &mut |_| 0,
        fails: &mut |_| false,
    };
    world.execute(&plan, chance).unwrap();
    plan
}

fn steps(plan: &Plan) -> Vec<String> {
    let steps = plan.steps.iter();
    steps
        .map(|step| format!("{} {}", step.work.kind(), step.target))
        .collect()
}

fn silence(world: &mut World, manager: &str) {
    let mut managers = world.managers_mut();
    let found = managers.find(|m| m.key.display_name() == manager);
    found.unwrap().responsive = false;
}

#[test]
fn a_silent_process_is_stopped_without_a_word_to_its_components() {
    let mut world = running();
    silence(&mut world, "hello.main");
    world.delete("hello");
    let plan = turn(&mut world, &Blocked::new());
    let steps = steps(&plan);
    assert!(steps.contains(&"StopManager manager/hello.main".to_owned()));
    assert!(
        !steps
            .iter()
            .any(|s| s.contains("Sine0") && !s.contains("connector")),
        "{steps:?}"
    );
    assert_eq!(world.managers().count(), 0);
}

#[test]
fn a_component_that_moves_out_of_a_silent_process_is_made_after_its_end() {
    let mut world = running();
    silence(&mut world, "hello.Printer0");
    let mut moved = hello();
    let printer = moved
        .spec
        .components
        .iter_mut()
        .find(|c| c.instance == "Printer0");
    printer.unwrap().placement.isolated = false;
    world.apply(moved);
    let plan = turn(&mut world, &Blocked::new());
    let id = |what: &str| {
        let at = steps(&plan).iter().position(|s| s == what).unwrap();
        plan.steps[at].id
    };
    let create = plan
        .steps
        .iter()
        .find(|s| s.id == id("Create component/Printer0"))
        .unwrap();
    assert!(
        create
            .needs
            .contains(&id("StopManager manager/hello.Printer0"))
    );
    turn(&mut world, &Blocked::new());
    assert!(plan_of(&world).in_step(), "{}", render(&plan_of(&world)));
}

fn plan_of(world: &World) -> Plan {
    plan(&world.desired(), &world.observed(), &Blocked::new())
}

#[test]
fn what_cannot_be_taken_down_now_waits_and_the_rest_goes_on() {
    let mut world = running();
    let mut smaller = hello();
    smaller.spec.components.retain(|c| c.instance == "Filter0");
    smaller.spec.connectors.clear();
    smaller.spec.orders = Default::default();
    world.apply(smaller);
    let why = "on_deactivated does not return".to_owned();
    let blocked = Blocked::from([("local|component/Sine0".to_owned(), why)]);
    let plan = turn(&mut world, &blocked);
    assert!(!steps(&plan).iter().any(|s| s.ends_with("component/Sine0")));
    assert!(steps(&plan).contains(&"Delete component/Printer0".to_owned()));
    let change = plan
        .changes
        .iter()
        .find(|c| c.target == "component/Sine0")
        .unwrap();
    assert!(
        change
            .reason
            .ends_with("; blocked: on_deactivated does not return")
    );
    assert!(
        plan.waiting_on
            .iter()
            .any(|w| w.target == "component/Sine0")
    );
    turn(&mut world, &Blocked::new());
    assert!(world.component("Sine0").is_none());
}

#[test]
fn a_value_that_is_no_longer_written_goes_back_to_its_default() {
    let mut world = running();
    for component in world.components_mut().filter(|c| c.instance == "Filter0") {
        component
            .defaults
            .insert("gain".to_owned(), "1.0".to_owned());
        let sets = &mut component.configuration.sets;
        let own = sets.entry("default".to_owned()).or_default();
        own.insert("gain".to_owned(), "7".to_owned());
        own.insert("unknown".to_owned(), "7".to_owned());
        component.configuration.active = Some("fast".to_owned());
    }
    let mut silent = hello();
    for component in &mut silent.spec.components {
        component.configuration = Default::default();
    }
    world.apply(silent);
    let plan = turn(&mut world, &Blocked::new());
    insta::assert_snapshot!(render(&plan), @r"
    ~ component/Filter0  set in place; what is no longer in the profile goes back to its default
        active set  fast -> default
        gain        7 -> 1.0
    Plan: 0 to add, 1 to change, 0 to remove
    ");
    assert!(plan_of(&world).in_step(), "{}", render(&plan_of(&world)));
}
