//! Who is there and not initialised yet: an older plan is at it.

use rts_plan::observed::LifeCycleState;
use rts_plan::plan::Plan;
use rts_schemas::system::{Condition, Orders, SendingTiming};

use super::tell::*;
use crate::world::specs::{after, component};
use crate::world::story::Story;
use SendingTiming::{Async, Sync};

/// A is being initialised, and B, C and D are new.
fn while_a_is_initialised(orders: Orders, required: bool) -> Story {
    let mut story = running(named(&["A"], Orders::default()));
    let mut system = named(&["A", "B", "C", "D"], orders);
    system.spec.components[0].required = required;
    story.world.apply(system);
    set_state(&mut story, LifeCycleState::Created);
    story
}

fn set_state(story: &mut Story, state: LifeCycleState) {
    let mut all = story.world.components_mut();
    all.find(|c| c.instance == "A").unwrap().state = state;
}

fn start_up() -> Vec<Condition> {
    vec![
        number("A", 1),
        number("B", 2),
        after("C", 0, Sync, &["A"]),
        after("D", 0, Async, &["A"]),
    ]
}

fn creates(plan: &Plan) -> String {
    told(plan, "Create")
}

#[test]
fn who_comes_after_it_is_not_created() {
    let orders = Orders {
        start_up: start_up(),
        ..Orders::default()
    };
    let mut story = while_a_is_initialised(orders, true);
    let mut text = creates(&story.plan());
    set_state(&mut story, LifeCycleState::Inactive);
    text.push_str(&format!("-- it is initialised\n{}", creates(&story.plan())));
    insta::assert_snapshot!(text, @r"
    Create D
    waiting: component/B: waits for A, which is being initialised (StartUp order)
    waiting: component/C: waits for A, which is being initialised (StartUp order)
    -- it is initialised
    Create B
    Create C
    Create D
    ");
}

/// Its try has not ended.
#[test]
fn an_optional_one_is_waited_for_too() {
    let orders = Orders {
        initializing: start_up(),
        ..Orders::default()
    };
    let story = while_a_is_initialised(orders, false);
    insta::assert_snapshot!(creates(&story.plan()), @r"
    Create D
    waiting: component/B: waits for A, which is being initialised (Initializing order)
    waiting: component/C: waits for A, which is being initialised (Initializing order)
    ");
}

/// What is replaced is created by the same plan, and that is waited for.
#[test]
fn its_expired_process_is_replaced_at_once() {
    let orders = Orders {
        start_up: start_up(),
        ..Orders::default()
    };
    let mut story = while_a_is_initialised(orders, true);
    let mut managers = story.world.managers_mut();
    managers.next().unwrap().expired = Some("A has been in on_initialize for 40 s".to_owned());
    drop(managers);
    let mut text = creates(&story.plan());
    story.blocked.insert(
        "local|manager/s.main".to_owned(),
        "died a second ago".to_owned(),
    );
    text.push_str(&format!("-- in its back-off\n{}", creates(&story.plan())));
    insta::assert_snapshot!(text, @r"
    Create A
    Create B: after A  [A by number in StartUp]
    Create C: after A  [A SYNC in StartUp]
    Create D: after start of A  [A ASYNC in StartUp]
    -- in its back-off
    Create D
    waiting: component/B: waits for A, which is being initialised (StartUp order)
    waiting: component/C: waits for A, which is being initialised (StartUp order)
    waiting: manager/s.main: is to be replaced: A has been in on_initialize for 40 s; blocked: died a second ago
    ");
}

/// Whoever waits for nobody does not wait.
#[test]
fn others_are_created() {
    let mut story = while_a_is_initialised(Orders::default(), true);
    story.world.systems[0]
        .spec
        .components
        .push(component("E", "T"));
    insta::assert_snapshot!(creates(&story.plan()), @r"
    Create B
    Create C
    Create D
    Create E
    ");
}
