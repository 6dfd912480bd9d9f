//! The rules of order as stories in text: one for each.

// A failure here is a failed test.
#![allow(clippy::unwrap_used)]

mod world;

use rts_plan::StoredSystem;
use rts_plan::observed::LifeCycleState;
use rts_plan::plan::{Because, OnTimeout, OrderName, Plan, Rule, Step, Work};
use rts_schemas::system::{Condition, Orders, PortKind, SendingTiming, SystemSpec, WaitFor};

use world::specs::{after, component, connector, stored};
use world::story::Story;

use SendingTiming::{Async, Sync};

/// Components of these names, which run in one process and are not connected.
fn named(names: &[&str], orders: Orders) -> StoredSystem {
    stored(SystemSpec {
        name: "s".to_owned(),
        full_id: String::new(),
        components: names.iter().map(|name| component(name, "T")).collect(),
        connectors: Vec::new(),
        orders,
    })
}

fn optional(mut system: StoredSystem, names: &[&str]) -> StoredSystem {
    for component in &mut system.spec.components {
        component.required = !names.contains(&component.instance.as_str());
    }
    system
}

fn activation(conditions: Vec<Condition>) -> Orders {
    Orders {
        activation: conditions,
        ..Orders::default()
    }
}

fn within(mut condition: Condition, milliseconds: u32) -> Condition {
    if let Some(WaitFor::Preceding { timeout_ms, .. }) = &mut condition.wait {
        *timeout_ms = milliseconds;
    }
    condition
}

/// RT System Editor's form: numbers alone.
fn number(target: &str, sequence: u32) -> Condition {
    after(target, sequence, Sync, &[])
}

fn sleep(target: &str, sequence: u32, milliseconds: u32) -> Condition {
    Condition {
        wait: Some(WaitFor::Time { milliseconds }),
        ..number(target, sequence)
    }
}

/// Steps of one kind, and what stands before each because of an order or preference.
fn told(plan: &Plan, kind: &str) -> String {
    let name = |id: &u32| {
        let step = &plan.steps[*id as usize - 1];
        let (_, name) = step.target.split_once('/').unwrap();
        match step.work.kind() == kind {
            true => name.to_owned(),
            false => format!("{} {name}", step.work.kind()),
        }
    };
    let ordered = |step: &Step, ids: &[u32]| {
        let ids = ids
            .iter()
            .filter(|id| step.because.iter().any(|b| b.step == **id));
        ids.map(name).collect::<Vec<_>>().join(", ")
    };
    let mut text = String::new();
    for step in plan.steps.iter().filter(|step| step.work.kind() == kind) {
        let mut parts = Vec::new();
        let lists = [
            ("after", &step.needs),
            ("after start of", &step.after_start_of),
            ("after end of", &step.after_end_of),
        ];
        for (how, ids) in lists {
            match ordered(step, ids) {
                names if names.is_empty() => {}
                names => parts.push(format!("{how} {names}")),
            }
        }
        if step.wait_ms > 0 {
            parts.push(format!("sleeps {} ms", step.wait_ms));
        }
        for limit in &step.limits {
            let names: Vec<String> = limit.steps.iter().map(name).collect();
            let then = match limit.then {
                OnTimeout::Fail => "fails",
                OnTimeout::GoOn => "goes on",
            };
            parts.push(format!(
                "{then} after {} ms without {}",
                limit.ms,
                names.join(", ")
            ));
        }
        let rules = step.because.iter();
        let mut rules: Vec<String> = rules
            .map(|b| format!("{} {}", name(&b.step), why(b)))
            .collect();
        rules.dedup();
        let rules = match rules.is_empty() {
            true => String::new(),
            false => format!("  [{}]", rules.join("; ")),
        };
        let colon = if parts.is_empty() { "" } else { ": " };
        let line = [
            kind,
            " ",
            &name(&step.id),
            colon,
            &parts.join("; "),
            &rules,
            "\n",
        ];
        text.push_str(&line.concat());
    }
    for note in &plan.notes {
        text.push_str(&format!("note: {note}\n"));
    }
    for waiting in &plan.waiting_on {
        text.push_str(&format!(
            "waiting: {}: {}\n",
            waiting.target, waiting.reason
        ));
    }
    text
}

fn why(because: &Because) -> String {
    match because.rule {
        Rule::Sequence { order } => format!("by number in {}", order.element()),
        Rule::Sync { order } => format!("SYNC in {}", order.element()),
        Rule::Async { order } => format!("ASYNC in {}", order.element()),
        Rule::ProviderFirst => "provider first".to_owned(),
        Rule::DownStreamFirst => "down-stream first".to_owned(),
        Rule::UpStreamFirst => "up-stream first".to_owned(),
    }
}

fn activates(system: StoredSystem) -> String {
    told(&Story::of(system).plan(), "Activate")
}

/// The plan, which is then carried out.
fn running_activates(system: StoredSystem) -> String {
    let text = activates(system.clone());
    running(system);
    text
}

fn running(system: StoredSystem) -> Story {
    let mut story = Story::of(system);
    story.turn();
    assert!(story.plan().is_empty(), "{}", story.plan());
    story
}

fn block(story: &mut Story, instance: &str) {
    let target = format!("local|component/{instance}");
    let why = "on_activated returned RTC_ERROR".to_owned();
    story.blocked.insert(target, why);
}

#[test]
fn numbers_alone_are_a_sequence() {
    let orders = activation(vec![
        number("A", 1),
        number("B", 2),
        number("C", 2),
        number("D", 5),
    ]);
    insta::assert_snapshot!(activates(named(&["D", "C", "B", "A", "Free"], orders)), @r"
    Activate A
    Activate B: after A  [A by number in Activation]
    Activate C: after A  [A by number in Activation]
    Activate D: after B, C  [B by number in Activation; C by number in Activation]
    Activate Free
    ");
}

/// Who is Active already is no gap in the sequence.
#[test]
fn a_number_waits_past_who_is_there() {
    let numbers = ["A", "B", "C"].into_iter().zip(1..);
    let orders = activation(numbers.map(|(name, n)| number(name, n)).collect());
    let mut story = running(named(&["A", "B", "C"], orders));
    let all = story.world.components_mut();
    let all = all.filter(|c| c.instance != "B");
    all.for_each(|c| c.state = LifeCycleState::Inactive);
    insta::assert_snapshot!(told(&story.plan(), "Activate"), @r"
    Activate A
    Activate C: after A  [A by number in Activation]
    ");
}

#[test]
fn wait_time_sleeps() {
    let orders = activation(vec![number("A", 1), sleep("B", 2, 500)]);
    insta::assert_snapshot!(activates(named(&["A", "B"], orders)), @r"
    Activate A
    Activate B: after A; sleeps 500 ms  [A by number in Activation]
    ");
}

#[test]
fn sync_waits_for_the_state_and_async_for_the_request() {
    let orders = activation(vec![
        after("B", 1, Sync, &["A"]),
        after("C", 1, Async, &["A"]),
    ]);
    insta::assert_snapshot!(activates(named(&["A", "B", "C"], orders)), @r"
    Activate A
    Activate B: after A  [A SYNC in Activation]
    Activate C: after start of A  [A ASYNC in Activation]
    ");
}

#[test]
fn conditions_of_one_component_are_anded() {
    let orders = activation(vec![
        number("A", 1),
        after("E", 2, Sync, &["B"]),
        after("E", 2, Async, &["C"]),
        within(after("E", 2, Sync, &["D"]), 200),
        sleep("E", 2, 10),
        sleep("E", 2, 20),
    ]);
    insta::assert_snapshot!(activates(named(&["A", "B", "C", "D", "E"], orders)), @r"
    Activate A
    Activate B
    Activate C
    Activate D
    Activate E: after A, B, D; after start of C; sleeps 20 ms; fails after 200 ms without D  [A by number in Activation; B SYNC in Activation; C ASYNC in Activation; D SYNC in Activation]
    ");
}

#[test]
fn each_time_out_is_a_limit_of_its_own() {
    let orders = activation(vec![
        within(after("D", 1, Sync, &["A", "B"]), 500),
        within(after("D", 1, Async, &["C"]), 100),
    ]);
    insta::assert_snapshot!(activates(named(&["A", "B", "C", "D"], orders)), @r"
    Activate A
    Activate B
    Activate C
    Activate D: after A, B; after start of C; fails after 500 ms without A, B; fails after 100 ms without C  [A SYNC in Activation; B SYNC in Activation; C ASYNC in Activation]
    ");
}

/// Nobody waits for a request of what must be Active anyway.
#[test]
fn a_limit_for_a_request_gives_way_to_the_number() {
    let orders = activation(vec![
        number("A", 1),
        within(after("B", 2, Async, &["A"]), 100),
    ]);
    insta::assert_snapshot!(activates(named(&["A", "B"], orders)), @r"
    Activate A
    Activate B: after A  [A by number in Activation; A ASYNC in Activation]
    ");
}

/// Who is there already is not waited for.
#[test]
fn a_limit_ends_with_its_steps() {
    let orders = activation(vec![within(after("B", 1, Sync, &["A"]), 500)]);
    let mut story = running(named(&["A", "B"], orders));
    let mut all = story.world.components_mut();
    all.find(|c| c.instance == "B").unwrap().state = LifeCycleState::Inactive;
    drop(all);
    insta::assert_snapshot!(told(&story.plan(), "Activate"), @"Activate B");
}

#[test]
fn taking_down_goes_on_when_time_is_out() {
    let orders = Orders {
        deactivation: vec![within(after("B", 1, Sync, &["A"]), 500)],
        shut_down: vec![within(after("A", 1, Sync, &["B"]), 300)],
        ..Orders::default()
    };
    let mut story = running(named(&["A", "B"], orders));
    story.world.delete("s");
    let plan = story.plan();
    let text = [told(&plan, "Deactivate"), told(&plan, "Delete")].concat();
    insta::assert_snapshot!(text, @r"
    Deactivate A
    Deactivate B: after end of A; goes on after 500 ms without A  [A SYNC in Deactivation]
    Delete B
    Delete A: after end of B; goes on after 300 ms without B  [B SYNC in ShutDown]
    ");
}

/// A Deactivate that fails keeps nobody else alive, numbered or named, in whatever list.
#[test]
fn what_fails_to_go_keeps_nobody_alive() {
    let numbers = || vec![number("A", 1), number("B", 2), number("C", 3)];
    let orders = Orders {
        deactivation: numbers(),
        shut_down: numbers(),
        finalizing: vec![after("C", 1, Sync, &["A"])],
        ..Orders::default()
    };
    let mut story = running(named(&["A", "B", "C"], orders));
    story.world.delete("s");
    let plan = story.plan();
    let text = [told(&plan, "Deactivate"), told(&plan, "Delete")].concat();
    let chance = world::execute::Chance {
        pick: &mut |_| 0,
        fails: &mut |step| step.work.kind() == "Deactivate" && step.target == "component/B",
    };
    story.world.execute(&plan, chance).unwrap();
    let left: Vec<&String> = story
        .world
        .components()
        .map(|(_, _, c)| &c.instance)
        .collect();
    assert_eq!(left, ["B"]);
    insta::assert_snapshot!(text, @r"
    Deactivate A
    Deactivate B: after end of A  [A by number in Deactivation]
    Deactivate C: after end of B  [B by number in Deactivation]
    Delete A
    Delete B: after end of A  [A by number in ShutDown]
    Delete C: after end of A, B  [A by number in ShutDown; A SYNC in Finalizing; B by number in ShutDown]
    ");
}

/// C is numbered after B, which goes on without A. Nobody says that C comes after A.
#[test]
fn who_is_gone_on_without_is_awaited_by_nobody_else() {
    let orders = Orders {
        deactivation: vec![within(after("B", 2, Sync, &["A"]), 500), number("C", 3)],
        ..Orders::default()
    };
    let mut story = running(named(&["A", "B", "C"], orders));
    story.world.delete("s");
    insta::assert_snapshot!(told(&story.plan(), "Deactivate"), @r"
    Deactivate A
    Deactivate B: after end of A; goes on after 500 ms without A  [A SYNC in Deactivation]
    Deactivate C: after end of B  [B by number in Deactivation]
    ");
}

/// A higher number is not let go with it: C still waits for A.
#[test]
fn who_goes_on_does_not_speak_for_a_lower_number() {
    let orders = Orders {
        deactivation: vec![
            number("A", 1),
            within(after("B", 2, Sync, &["A"]), 500),
            number("C", 3),
        ],
        ..Orders::default()
    };
    let mut story = running(named(&["A", "B", "C"], orders));
    story.world.delete("s");
    insta::assert_snapshot!(told(&story.plan(), "Deactivate"), @r"
    Deactivate A
    Deactivate B: after end of A; goes on after 500 ms without A  [A by number in Deactivation; A SYNC in Deactivation]
    Deactivate C: after end of A, B  [A by number in Deactivation; B by number in Deactivation]
    ");
}

/// Without a limit somewhere there is none.
#[test]
fn of_several_time_outs_the_longest_counts_when_taking_down() {
    let orders = Orders {
        deactivation: vec![
            within(after("D", 1, Sync, &["A", "B", "C"]), 500),
            within(after("D", 1, Sync, &["B"]), 900),
            after("D", 1, Sync, &["C"]),
        ],
        ..Orders::default()
    };
    let mut story = running(named(&["A", "B", "C", "D"], orders));
    story.world.delete("s");
    insta::assert_snapshot!(told(&story.plan(), "Deactivate"), @r"
    Deactivate A
    Deactivate B
    Deactivate C
    Deactivate D: after end of A, B, C; goes on after 500 ms without A; goes on after 900 ms without B  [A SYNC in Deactivation; B SYNC in Deactivation; C SYNC in Deactivation]
    ");
}

/// An order for each kind of step: C before B before A, in each of the forms.
fn seven() -> Orders {
    let list = || vec![after("A", 1, Sync, &["B"]), after("B", 1, Async, &["C"])];
    Orders {
        start_up: list(),
        shut_down: vec![number("C", 1), number("B", 2), number("A", 3)],
        activation: list(),
        deactivation: list(),
        resetting: list(),
        initializing: vec![number("C", 1), number("A", 2)],
        finalizing: vec![within(after("A", 1, Sync, &["C"]), 700)],
    }
}

#[test]
fn all_seven_orders_order_their_steps() {
    let mut system = named(&["A", "B", "C"], seven());
    for component in &mut system.spec.components {
        component.policy.reset_on_error = true;
    }
    let mut story = Story::of(system);
    let plan = story.plan();
    let mut text = [told(&plan, "Create"), told(&plan, "Activate")].concat();
    story.turn();
    let all = story.world.components_mut();
    all.for_each(|c| c.state = LifeCycleState::Error);
    let plan = story.plan();
    text.push_str(&[told(&plan, "Reset"), told(&plan, "Activate")].concat());
    story.turn();
    story.world.delete("s");
    let plan = story.plan();
    text.push_str(&[told(&plan, "Deactivate"), told(&plan, "Delete")].concat());
    story.turn();
    assert!(story.plan().is_empty());
    insta::assert_snapshot!(text, @r"
    Create C
    Create B: after start of C  [C ASYNC in StartUp]
    Create A: after C, B  [C by number in Initializing; B SYNC in StartUp]
    Activate C
    Activate B: after start of C  [C ASYNC in Activation]
    Activate A: after B  [B SYNC in Activation]
    Reset C
    Reset B: after start of C  [C ASYNC in Resetting]
    Reset A: after B  [B SYNC in Resetting]
    Activate C
    Activate B: after start of C  [C ASYNC in Activation]
    Activate A: after B  [B SYNC in Activation]
    Deactivate C
    Deactivate B: after start of C  [C ASYNC in Deactivation]
    Deactivate A: after end of B  [B SYNC in Deactivation]
    Delete C
    Delete B: after end of C  [C by number in ShutDown]
    Delete A: after end of C, B  [C by number in ShutDown; C SYNC in Finalizing; B by number in ShutDown]
    ");
}

#[test]
fn an_optional_component_holds_nobody_up_for_longer_than_its_try() {
    let orders = activation(vec![
        number("A", 1),
        number("B", 2),
        number("C", 3),
        after("D", 1, Sync, &["B"]),
        after("E", 1, Async, &["B"]),
    ]);
    let system = named(&["A", "B", "C", "D", "E"], orders);
    insta::assert_snapshot!(activates(optional(system, &["B"])), @r"
    Activate A
    Activate B: after A  [A by number in Activation]
    Activate C: after A; after end of B  [A by number in Activation; B by number in Activation]
    Activate D: after A; after end of B  [A SYNC in Activation; B SYNC in Activation]
    Activate E: after start of B; after end of A  [A ASYNC in Activation; B ASYNC in Activation]
    ");
}

#[test]
fn an_optional_component_that_cannot_be_brought_up_makes_nobody_wait() {
    let orders = activation(vec![
        number("A", 1),
        number("B", 2),
        number("C", 3),
        after("D", 3, Async, &["B"]),
    ]);
    let system = optional(named(&["A", "B", "C", "D"], orders), &["B"]);
    let mut story = Story::of(system.clone());
    block(&mut story, "B");
    let mut text = told(&story.plan(), "Activate");
    // Once all the others run, nothing is to be said.
    story.turn();
    text.push_str(&format!("--\n{}", told(&story.plan(), "Activate")));
    // What it waits for itself makes others wait all the same.
    let mut story = Story::of(system.clone());
    block(&mut story, "A");
    text.push_str(&format!("--\n{}", told(&story.plan(), "Activate")));
    // A required one makes others wait.
    let mut story = Story::of(optional(system, &[]));
    block(&mut story, "B");
    text.push_str(&format!("--\n{}", told(&story.plan(), "Activate")));
    insta::assert_snapshot!(text, @r"
    Activate A
    Activate C: after A  [A by number in Activation]
    Activate D: after A  [A by number in Activation; A ASYNC in Activation]
    note: C, D do not wait for B (Activation order): it is optional and cannot be brought up now
    waiting: component/B: on_activated returned RTC_ERROR
    --
    waiting: component/B: on_activated returned RTC_ERROR
    --
    waiting: component/A: on_activated returned RTC_ERROR
    waiting: component/B: waits for A (Activation order)
    waiting: component/C: waits for A (Activation order)
    waiting: component/D: waits for A (Activation order)
    --
    Activate A
    waiting: component/B: on_activated returned RTC_ERROR
    waiting: component/C: waits for B (Activation order)
    waiting: component/D: waits for B (Activation order)
    ");
}

#[test]
fn start_up_orders_do_not_wait_for_an_optional_component_either() {
    let orders = Orders {
        start_up: vec![after("A", 1, Sync, &["B"]), after("B", 1, Sync, &["C"])],
        ..Orders::default()
    };
    let system = optional(named(&["A", "B", "C"], orders), &["B"]);
    let mut text = told(&Story::of(system.clone()).plan(), "Create");
    for blocked in ["B", "C"] {
        let mut story = Story::of(system.clone());
        block(&mut story, blocked);
        text.push_str(&format!(
            "-- {blocked} is blocked\n{}",
            told(&story.plan(), "Create")
        ));
    }
    insta::assert_snapshot!(text, @r"
    Create C
    Create B: after C  [C SYNC in StartUp]
    Create A: after C; after end of B  [C SYNC in StartUp; B SYNC in StartUp]
    -- B is blocked
    Create C
    Create A: after C  [C SYNC in StartUp]
    note: A does not wait for B (StartUp order): it is optional and cannot be brought up now
    waiting: component/B: on_activated returned RTC_ERROR
    -- C is blocked
    waiting: component/A: waits for C (StartUp order)
    waiting: component/B: waits for C (StartUp order)
    waiting: component/C: on_activated returned RTC_ERROR
    ");
}

#[test]
fn who_is_reset_first_and_cannot_be_makes_the_next_wait() {
    let orders = Orders {
        resetting: vec![after("A", 1, Sync, &["B"])],
        ..Orders::default()
    };
    let mut system = named(&["A", "B"], orders);
    system.spec.components[0].policy.reset_on_error = true;
    let mut text = String::new();
    for names in [&[][..], &["B"][..]] {
        let mut story = running(optional(system.clone(), names));
        let all = story.world.components_mut();
        all.for_each(|c| c.state = LifeCycleState::Error);
        text.push_str(&format!(
            "-- optional: {names:?}\n{}",
            told(&story.plan(), "Reset")
        ));
    }
    insta::assert_snapshot!(text, @r#"
    -- optional: []
    waiting: component/A: waits for B (Resetting order)
    waiting: component/B: in Error: no reason was given (rtsctl.resetOnError is off)
    -- optional: ["B"]
    Reset A
    note: A does not wait for B (Resetting order): it is optional and cannot be brought up now
    waiting: component/B: in Error: no reason was given (rtsctl.resetOnError is off)
    "#);
}

/// Two components of one system on two nodes, connected.
fn apart(orders: Orders) -> Story {
    let mut system = named(&["A", "B"], orders);
    for (component, node) in system.spec.components.iter_mut().zip(["one", "two"]) {
        component.placement.node = Some(node.to_owned());
        component.policy.reset_on_error = true;
    }
    system.spec.connectors = vec![connector(("B", "out"), ("A", "in"))];
    let mut story = Story::of(system.clone());
    story.world = world::World::new(&["one", "two"]);
    story.world.apply(system);
    story.turn();
    assert!(story.plan().is_empty(), "{}", story.plan());
    story
}

/// Who cannot be seen may be in Error.
#[test]
fn who_is_reset_first_and_cannot_be_seen_makes_the_next_wait() {
    let mut story = apart(Orders {
        resetting: vec![after("A", 1, Sync, &["B"])],
        ..Orders::default()
    });
    let all = story.world.components_mut();
    all.for_each(|c| c.state = LifeCycleState::Error);
    story.world.silent.insert("two".to_owned());
    insta::assert_snapshot!(told(&story.plan(), "Reset"), @r"
    waiting: component/A: waits for B (Resetting order)
    waiting: component/B: node two is unknown: no heartbeat for 3 s
    waiting: connector/B.out-A.in: B cannot be seen: node two is unknown: no heartbeat for 3 s
    waiting: node/two: is unknown: no heartbeat for 3 s
    ");
}

/// It would feed somebody who is gone.
#[test]
fn a_source_that_cannot_go_is_disconnected_from_what_goes() {
    let mut story = apart(Orders::default());
    story.world.delete("s");
    let target = "two|component/B".to_owned();
    story
        .blocked
        .insert(target, "on_finalize failed".to_owned());
    // Its process, with something else in it, stays.
    story
        .blocked
        .insert("two|manager/s.main".to_owned(), "it hangs".to_owned());
    insta::assert_snapshot!(world::story::tell(&story.plan()), @r"
    - component/A           one  its system is torn down (was T in s.main)
    - component/B                its system is torn down; waits, see below (was T in s.main)
    - connector/B.out-A.in  two  is not in the system any more
    - manager/s.main        one  nothing is wanted in it any more
    - manager/s.main        one  nothing is wanted in it any more; waits, see below
    waiting: component/B: on_finalize failed
    waiting: manager/s.main: it hangs
    Plan: 0 to add, 0 to change, 5 to remove
      1 Deactivate   component/A  (is not wanted any more)
      2 Disconnect   connector/B.out-A.in  after 1  (is not in the system any more)
      3 Delete       component/A  after 1,2  (is not wanted any more)
      4 StopManager  manager/s.main  after 3  (nothing is wanted in it any more)
    critical path: 1 → 2 → 3 → 4 (4 steps)
    ");
}

fn service(consumer: &str, provider: &str) -> rts_schemas::system::ConnectorSpec {
    let mut spec = connector((consumer, "svc"), (provider, "svc"));
    spec.kind = PortKind::Service;
    let required = format!("{consumer}.port.svc.required.IDL.I");
    let provided = format!("{provider}.port.svc.provided.IDL.I");
    spec.properties.insert(required, provided);
    spec
}

#[test]
fn providers_come_up_before_consumers_and_go_down_after_them() {
    let mut system = named(&["Consumer", "Provider"], Orders::default());
    system.spec.connectors = vec![service("Consumer", "Provider")];
    let mut text = activates(system.clone());
    let mut story = Story::of(system.clone());
    story.turn();
    // Both are made again, in a new process.
    system
        .module_digests
        .insert("T".to_owned(), "another".to_owned());
    story.world.apply(system);
    text.push_str(&told(&story.plan(), "Deactivate"));
    insta::assert_snapshot!(text, @r"
    Activate Provider
    Activate Consumer: after start of Provider  [Provider provider first]
    note: service connector Consumer.svc-Provider.svc of system s: is declared, service ports are connected by a later version
    Deactivate Consumer
    Deactivate Provider: after start of Consumer  [Consumer provider first]
    note: service connector Consumer.svc-Provider.svc of system s: is declared, service ports are connected by a later version
    ");
}

#[test]
fn down_stream_comes_up_first_and_goes_down_last() {
    let mut system = named(&["Sink", "Source"], Orders::default());
    system.spec.connectors = vec![connector(("Source", "out"), ("Sink", "in"))];
    let mut text = activates(system.clone());
    let mut story = running(system);
    story.world.delete("s");
    text.push_str(&told(&story.plan(), "Deactivate"));
    insta::assert_snapshot!(text, @r"
    Activate Sink
    Activate Source: after start of Sink  [Sink down-stream first]
    Deactivate Source
    Deactivate Sink: after start of Source  [Source up-stream first]
    ");
}

/// A system that goes is still known by its services.
#[test]
fn consumers_go_down_before_providers_with_their_system() {
    let mut system = named(&["Consumer", "Provider"], Orders::default());
    system.spec.connectors = vec![service("Consumer", "Provider")];
    let mut story = Story::of(system);
    story.turn();
    story.world.delete("s");
    insta::assert_snapshot!(told(&story.plan(), "Deactivate"), @r"
    Deactivate Consumer
    Deactivate Provider: after start of Consumer  [Consumer provider first]
    ");
}

/// Data flows from the provider to its consumer: the service says who is first.
#[test]
fn in_a_cycle_services_outweigh_data_flow() {
    let mut system = named(&["A", "B", "X", "Y"], Orders::default());
    system.spec.connectors = vec![
        connector(("A", "out"), ("B", "in")),
        service("B", "A"),
        connector(("X", "out"), ("Y", "in")),
    ];
    insta::assert_snapshot!(activates(system), @r"
    Activate A
    Activate B: after start of A  [A provider first]
    Activate Y
    Activate X: after start of Y  [Y down-stream first]
    note: service connector B.svc-A.svc of system s: is declared, service ports are connected by a later version
    note: data flow gives no start or stop order among component/A, component/B: it runs in a circle, or against a written order or a service
    ");
}

#[test]
fn services_in_a_circle_give_no_order() {
    let mut system = named(&["A", "B", "C"], Orders::default());
    system.spec.connectors = vec![
        service("A", "B"),
        service("B", "C"),
        service("C", "A"),
        connector(("A", "out"), ("B", "in")),
    ];
    insta::assert_snapshot!(activates(system), @r"
    Activate A
    Activate B
    Activate C
    note: service connector A.svc-B.svc of system s: is declared, service ports are connected by a later version
    note: service connector B.svc-C.svc of system s: is declared, service ports are connected by a later version
    note: service connector C.svc-A.svc of system s: is declared, service ports are connected by a later version
    note: data flow gives no start or stop order among component/A, component/B, component/C: it runs in a circle, or against a written order or a service
    note: services give no start or stop order among component/A, component/B, component/C: they are provided in a circle, or against a written order
    ");
}

/// Real profiles number components in the order of a list.
#[test]
fn preceding_outweighs_a_number() {
    let orders = activation(vec![
        after("A", 1, Sync, &["B"]),
        number("B", 2),
        number("C", 3),
    ]);
    insta::assert_snapshot!(running_activates(named(&["A", "B", "C"], orders)), @r"
    Activate B
    Activate A: after B  [B SYNC in Activation]
    Activate C: after B  [B by number in Activation]
    ");
}

#[test]
fn a_written_order_outweighs_a_preference() {
    let mut system = named(&["A", "B"], activation(vec![after("B", 1, Async, &["A"])]));
    system.spec.connectors = vec![connector(("A", "out"), ("B", "in"))];
    insta::assert_snapshot!(activates(system), @r"
    Activate A
    Activate B: after start of A  [A ASYNC in Activation]
    note: data flow gives no start or stop order among component/A, component/B: it runs in a circle, or against a written order or a service
    ");
}

/// The lists that order one kind of step are named as they stand in the profile.
#[test]
fn a_rule_names_its_list() {
    let plan = Story::of(named(&["A", "B", "C"], seven())).plan();
    let creates = plan
        .steps
        .iter()
        .filter(|s| matches!(s.work, Work::Create { .. }));
    let rules = creates.flat_map(|step| &step.because).map(|b| b.rule);
    let orders: std::collections::BTreeSet<OrderName> = rules
        .filter_map(|rule| match rule {
            Rule::Sequence { order } | Rule::Sync { order } | Rule::Async { order } => Some(order),
            _ => None,
        })
        .collect();
    let expected = [OrderName::StartUp, OrderName::Initializing];
    assert!(orders.into_iter().eq(expected));
}
