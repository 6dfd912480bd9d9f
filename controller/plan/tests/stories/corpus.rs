//! Real systems: every profile that can be read gets a plan, and its export is what runs.
//!
//! The corpus lies beside the checkout where `RTSCTL_CORPUS` points to; elsewhere these tests say that they were skipped.

use std::collections::BTreeSet;
use std::path::PathBuf;

use rts_plan::plan::{Blocked, OnTimeout, Plan, Step, Work};
use rts_plan::{check_orders, with_drift};
use rts_schemas::check;
use rts_schemas::diagnostic::Report;
use rts_schemas::names;
use rts_schemas::rts_profile::{LowerOptions, WriteOptions, load, lower, read, sayable, write};
use rts_schemas::system::SystemSpec;

use crate::world::World;
use crate::world::by_hand::Hand;
use crate::world::execute::{Chance, Run};
use crate::world::specs::stored;
use crate::world::story::Story;

fn corpus() -> Option<PathBuf> {
    let found = std::env::var_os("RTSCTL_CORPUS").map(PathBuf::from);
    if found.is_none() {
        println!("skipped: RTSCTL_CORPUS is not set");
    }
    found
}

/// Every profile, lowered; those without a name for their system are left out.
fn systems() -> Option<Vec<(String, SystemSpec)>> {
    let corpus = corpus()?;
    let mut systems = Vec::new();
    for folder in ["rts", "derived"] {
        let entries = std::fs::read_dir(corpus.join(folder)).unwrap();
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        paths.retain(|path| path.extension().is_some_and(|e| e != "tsv"));
        paths.sort();
        for path in paths {
            let file = path.file_name().unwrap().to_str().unwrap().to_owned();
            systems.extend(lowered(&path).map(|spec| (file, spec)));
        }
    }
    Some(systems)
}

fn lowered(path: &std::path::Path) -> Option<SystemSpec> {
    let file = path.file_name().unwrap().to_str().unwrap();
    let profile = read(file, &std::fs::read(path).unwrap()).unwrap();
    let options = LowerOptions {
        name: None,
        file_stem: names::file_stem(file),
    };
    lower(&profile, &options).0
}

fn derived(file: &str) -> Option<SystemSpec> {
    lowered(&corpus()?.join("derived").join(file))
}

/// A world with a node for each host that the profile hints at, and one for all others.
fn story(spec: &SystemSpec) -> Story {
    let hosts = spec.components.iter();
    let hosts = hosts.filter_map(|c| c.placement.host.as_deref());
    let nodes: BTreeSet<&str> = hosts.chain(["0"]).collect();
    let nodes: Vec<&str> = nodes.into_iter().collect();
    let mut world = World::new(&nodes);
    world.apply(stored(spec.clone()));
    Story {
        world,
        blocked: Blocked::new(),
    }
}

/// Carries out a plan; of several steps that may start, `pick` says which is first.
fn carry_out(world: &mut World, plan: &Plan, mut pick: impl FnMut(usize) -> usize) -> Run {
    let chance = Chance {
        pick: &mut pick,
        fails: &mut |_| false,
    };
    let run = world.execute(plan, chance);
    let run = run.unwrap_or_else(|broken| panic!("{broken}\n{plan}"));
    assert!(run.failed.is_empty(), "{:?}", run.failed);
    run
}

/// Ways to choose among steps that may start: the first, the last, one in the middle.
const PICKS: [fn(usize) -> usize; 3] = [|_| 0, |count| count - 1, |count| count / 2];

/// The running system as a profile, read again.
fn exported(spec: &SystemSpec, plan: &Plan, file: &str) -> SystemSpec {
    let (found, notes) = with_drift(spec, &plan.drift, |_| true);
    assert_eq!(notes, Vec::<String>::new(), "{file}");
    let options = WriteOptions {
        created: "2026-01-15T10:00:00",
        updated: "2026-01-15T10:00:00",
        abstract_text: "",
    };
    let text = write(&found, &options);
    let (again, _) = load("export.xml", text.as_bytes(), None, &[])
        .unwrap_or_else(|report| panic!("{file}: {report:?}\n{text}"));
    assert_eq!(again, sayable(&found), "{file}");
    again
}

/// What the checks refuse cannot be applied: its connectors end nowhere.
fn is_sound(spec: &SystemSpec) -> bool {
    check::spec(spec) == Report::default() && check_orders(spec).is_empty()
}

#[test]
fn every_system_is_planned_carried_out_and_settled() {
    let Some(systems) = systems() else { return };
    let mut planned = 0;
    let mut refused = Vec::new();
    for (file, spec) in systems {
        if !is_sound(&spec) {
            refused.push(file);
            continue;
        }
        let mut story = story(&spec);
        let first = story.plan();
        assert_eq!(first.waiting_on, [], "{file}");
        assert_eq!(first.is_empty(), spec.components.is_empty(), "{file}");
        for pick in PICKS {
            let mut world = story.world.clone();
            carry_out(&mut world, &first, pick);
            let desired = world.desired();
            let next = rts_plan::plan(&desired, &world.observed(), &Blocked::new());
            assert!(next.in_step(), "{file}: {next}");
        }
        carry_out(&mut story.world, &first, |_| 0);
        let again = exported(&spec, &story.plan(), &file);
        assert_eq!(again.name, spec.name, "{file}");
        story.world.apply(stored(again));
        let next = story.plan();
        assert!(next.in_step(), "{file}: {next}");
        // Nothing of it is left over in the end.
        story.world.delete(&spec.name);
        story.ends_well();
        assert_eq!(story.world.managers().count(), 0, "{file}");
        planned += 1;
    }
    println!("{planned} systems were planned, {refused:?} were refused");
    assert!(planned >= 87 && refused.len() <= 2, "{planned} {refused:?}");
}

/// With what a person changed by hand in it, the export is still what runs.
#[test]
fn the_export_of_a_system_that_was_changed_by_hand_changes_nothing() {
    let Some(systems) = systems() else { return };
    let hands = [
        vec![Hand::Set(0, "3"), Hand::Disconnect(0, 0)],
        vec![
            Hand::Disconnect(1, 0),
            Hand::Disconnect(1, 1),
            Hand::Switch(2),
        ],
        vec![Hand::Disconnect(0, 0), Hand::Reconnect(1, 0, "new")],
    ];
    let mut drifted = 0;
    for (file, spec) in systems.iter().filter(|(_, spec)| is_sound(spec)) {
        for hands in &hands {
            let mut story = story(spec);
            story.turn();
            hands.iter().for_each(|hand| story.world.by_hand(hand));
            let plan = story.plan();
            drifted += usize::from(!plan.drift.is_empty());
            let again = exported(spec, &plan, file);
            story.world.apply(stored(again));
            let next = story.plan();
            assert!(next.in_step() && next.drift.is_empty(), "{file}: {next}");
        }
    }
    println!("{drifted} systems were changed by hand");
    assert!(drifted >= 100, "{drifted}");
}

/// The instances of steps of a kind, in the order in which they were asked.
fn asked(run: &Run, plan: &Plan, kind: &str) -> Vec<String> {
    let steps = run.asked.iter();
    let steps = steps.filter_map(|id| plan.steps.iter().find(|s| s.id == *id));
    let steps = steps.filter(|step| step.work.kind() == kind);
    steps
        .map(|step| step.target.trim_start_matches("component/").to_owned())
        .collect()
}

/// Says that these are asked one after the other, whatever is picked first.
fn in_order(file: &str, kind: &str, expected: &[&str]) {
    let Some(spec) = derived(file) else { return };
    for pick in PICKS {
        let mut story = story(&spec);
        if matches!(kind, "Deactivate" | "Delete") {
            story.turn();
            story.world.delete(&spec.name);
        }
        let plan = story.plan();
        let run = carry_out(&mut story.world, &plan, pick);
        let all = asked(&run, &plan, kind);
        assert_eq!(all.len(), spec.components.len(), "{file}");
        let named: Vec<&String> = all
            .iter()
            .filter(|i| expected.contains(&i.as_str()))
            .collect();
        assert_eq!(named, expected, "{file}: {kind}");
    }
}

#[test]
fn sequence_numbers_order_activation() {
    in_order(
        "plan_seq.rtsys.xml",
        "Activate",
        &["Sensor0", "Motor0", "Controller0"],
    );
}

#[test]
fn all_forms_together_order_activation() {
    let sequence = [
        "Sensor0",
        "Motor0",
        "Controller0",
        "ConsoleOut0",
        "SeqIn0",
        "MyServiceConsumer0",
    ];
    in_order("plan_all.rtsys.xml", "Activate", &sequence);
    in_order("plan_all.rtsys.xml", "Activate", &["SeqOut0", "SeqIn0"]);
    in_order(
        "plan_all.rtsys.xml",
        "Activate",
        &["MyServiceProvider0", "MyServiceConsumer0"],
    );
}

#[test]
fn preceding_orders_activation() {
    in_order("plan_async.rtsys.xml", "Activate", &["SeqOut0", "SeqIn0"]);
    let service = ["MyServiceProvider0", "MyServiceConsumer0"];
    in_order("plan_sync.rtsys.xml", "Activate", &service);
    in_order("plan_sync0.rtsys.xml", "Activate", &service);
}

/// As RT System Editor writes them, without ids and waits.
#[test]
fn all_seven_orders_are_obeyed() {
    let sequence = ["Motor0", "Controller0", "Sensor0"];
    for kind in ["Create", "Activate", "Deactivate", "Delete"] {
        in_order("rts_rtse_ordering_v02.xml", kind, &sequence);
    }
}

/// The step that activates an instance, and the one that activates another.
fn activations(file: &str, instance: &str, other: &str) -> Option<(Step, Step)> {
    let plan = story(&derived(file)?).plan();
    let activate = |name: &str| {
        let own = |step: &&Step| matches!(&step.work, Work::Activate { instance, .. } if instance == name);
        plan.steps.iter().find(own).unwrap().clone()
    };
    Some((activate(instance), activate(other)))
}

#[test]
fn sync_waits_for_the_state_and_async_for_the_request() {
    let (consumer, provider) = ("MyServiceConsumer0", "MyServiceProvider0");
    let Some((step, before)) = activations("plan_sync.rtsys.xml", consumer, provider) else {
        return;
    };
    assert!(step.needs.contains(&before.id));
    let [limit] = &step.limits[..] else {
        panic!("one limit: {step:?}");
    };
    assert_eq!((limit.ms, limit.then), (3000, OnTimeout::Fail));
    assert_eq!(limit.steps, [before.id]);
    // Without a time-out, or with 0, only the operation's deadline ends the wait.
    let (step, before) = activations("plan_sync0.rtsys.xml", consumer, provider).unwrap();
    assert!(step.needs.contains(&before.id));
    assert_eq!(step.limits, []);
    let (step, before) = activations("plan_async.rtsys.xml", "SeqIn0", "SeqOut0").unwrap();
    assert!(step.after_start_of.contains(&before.id) && !step.needs.contains(&before.id));
    assert_eq!(step.limits[0].ms, 3000);
}

#[test]
fn a_waiting_time_is_slept() {
    let Some((step, other)) = activations("plan_wait.rtsys.xml", "ConsoleOut0", "ConsoleIn0")
    else {
        return;
    };
    assert_eq!((step.wait_ms, other.wait_ms), (500, 0));
}
