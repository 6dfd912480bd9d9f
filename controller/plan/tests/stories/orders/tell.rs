//! Systems with orders, and plans told by their order alone.

use rts_plan::StoredSystem;
use rts_plan::plan::{Because, OnTimeout, Plan, Rule, Step};
use rts_schemas::system::{Condition, Orders, SendingTiming, SystemSpec, WaitFor};

use crate::world::specs::{after, component, stored};
use crate::world::story::Story;
use SendingTiming::Sync;

/// Components of these names, which run in one process and are not connected.
pub fn named(names: &[&str], orders: Orders) -> StoredSystem {
    stored(SystemSpec {
        composites: Vec::new(),
        name: "s".to_owned(),
        full_id: String::new(),
        components: names.iter().map(|name| component(name, "T")).collect(),
        connectors: Vec::new(),
        orders,
    })
}

pub fn optional(mut system: StoredSystem, names: &[&str]) -> StoredSystem {
    for component in &mut system.spec.components {
        component.required = !names.contains(&component.instance.as_str());
    }
    system
}

pub fn activation(conditions: Vec<Condition>) -> Orders {
    Orders {
        activation: conditions,
        ..Orders::default()
    }
}

pub fn within(mut condition: Condition, milliseconds: u32) -> Condition {
    if let Some(WaitFor::Preceding { timeout_ms, .. }) = &mut condition.wait {
        *timeout_ms = milliseconds;
    }
    condition
}

/// RT System Editor's form: numbers alone.
pub fn number(target: &str, sequence: u32) -> Condition {
    after(target, sequence, Sync, &[])
}

pub fn sleep(target: &str, sequence: u32, milliseconds: u32) -> Condition {
    Condition {
        wait: Some(WaitFor::Time { milliseconds }),
        ..number(target, sequence)
    }
}

/// Steps of one kind, and what stands before each because of an order or preference.
pub fn told(plan: &Plan, kind: &str) -> String {
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

pub fn why(because: &Because) -> String {
    match because.rule {
        Rule::Sequence { order } => format!("by number in {}", order.element()),
        Rule::Sync { order } => format!("SYNC in {}", order.element()),
        Rule::Async { order } => format!("ASYNC in {}", order.element()),
        Rule::ProviderFirst => "provider first".to_owned(),
        Rule::DownStreamFirst => "down-stream first".to_owned(),
        Rule::UpStreamFirst => "up-stream first".to_owned(),
    }
}

pub fn activates(system: StoredSystem) -> String {
    told(&Story::of(system).plan(), "Activate")
}

/// The plan, which is then carried out.
pub fn running_activates(system: StoredSystem) -> String {
    let text = activates(system.clone());
    running(system);
    text
}

pub fn running(system: StoredSystem) -> Story {
    let mut story = Story::of(system);
    story.turn();
    assert!(story.plan().is_empty(), "{}", story.plan());
    story
}

pub fn block(story: &mut Story, instance: &str) {
    let target = format!("local|component/{instance}");
    let why = "on_activated returned RTC_ERROR".to_owned();
    story.blocked.insert(target, why);
}
