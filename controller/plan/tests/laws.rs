//! Laws that hold for every plan, attacked with random systems, random starting states and random failures.

// A failure here is a failed test.
#![allow(clippy::unwrap_used)]

mod world;

use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use rts_plan::desired::Desired;
use rts_plan::observed::{ComponentObserved, ConnectorState, LifeCycleState, Observed};
use rts_plan::place::recreate_hash;
use rts_plan::plan::{Blocked, Plan, Work};
use rts_plan::target::on;
use rts_plan::{StoredSystem, check_orders, plan};
use rts_schemas::system::{ComponentSpec, ExecutionKind};

use world::World;
use world::execute::{Chance, Run};
use world::specs::{NODES, set, system};

/// Something that happens to the world.
#[derive(Debug, Clone)]
enum Event {
    /// Another version of a system is applied.
    Apply(Box<StoredSystem>),
    /// A small change of a system that is there.
    Tweak(usize, u8),
    Delete(&'static str),
    /// Plan and execute; one step in `fail` fails, and blocks its target if `block`.
    Roll {
        fail: usize,
        block: bool,
    },
    Kill(usize),
    Error(usize),
    Inactive(usize),
    Connector(usize, ConnectorState),
    ByHand(usize, &'static str, bool),
    SilentNode(usize),
    SilentManager(usize),
    Calm,
}

fn apply(system: StoredSystem) -> Event {
    Event::Apply(Box::new(system))
}

/// Changes one thing of the system that was applied first.
fn tweak(world: &mut World, nth: usize, what: u8) {
    let Some(system) = world.systems.first_mut() else {
        return;
    };
    let spec = &mut system.spec;
    let count = spec.components.len();
    let component = &mut spec.components[nth % count];
    let other = spec.connectors.len().max(1);
    let connector = spec.connectors.get_mut(nth % other);
    match what {
        0 => set(component, "gain", "7"),
        1 => component.execution_context.rate = Some(20.0),
        2 => component.execution_context.kind = ExecutionKind::EventDriven,
        3 => component.placement.isolated = !component.placement.isolated,
        4 => {
            let digest = system.module_digests.get_mut(&component.type_name);
            digest.unwrap().push('x');
        }
        5 => {
            if let Some(connector) = connector {
                let policy = "dataport.subscription_type".to_owned();
                connector.properties.insert(policy, "periodic".to_owned());
            }
        }
        _ => drop(spec.connectors.pop()),
    }
}

fn event() -> impl Strategy<Value = Event> {
    let state = prop_oneof![
        Just(ConnectorState::Disconnected),
        Just(ConnectorState::Connecting)
    ];
    prop_oneof![
        4 => (0..9usize, 0..7u8).prop_map(|(nth, what)| Event::Tweak(nth, what)),
        3 => system("a", "C", 8).prop_map(apply),
        1 => system("b", "D", 3).prop_map(apply),
        1 => prop_oneof![Just("a"), Just("b")].prop_map(Event::Delete),
        6 => (1..12usize, any::<bool>()).prop_map(|(fail, block)| Event::Roll { fail, block }),
        1 => (0..9usize).prop_map(Event::Kill),
        1 => (0..9usize).prop_map(Event::Error),
        1 => (0..9usize).prop_map(Event::Inactive),
        1 => (0..9usize, state).prop_map(|(nth, state)| Event::Connector(nth, state)),
        1 => (0..9usize, prop_oneof![Just("C0"), Just("H0")], any::<bool>())
            .prop_map(|(nth, name, own)| Event::ByHand(nth, name, own)),
        1 => (0..3usize).prop_map(Event::SilentNode),
        1 => (0..9usize).prop_map(Event::SilentManager),
        1 => Just(Event::Calm),
    ]
}

fn events() -> impl Strategy<Value = Vec<Event>> {
    let first = system("a", "C", 8).prop_map(apply);
    (first, prop::collection::vec(event(), 0..14)).prop_map(|(first, rest)| {
        let mut events = vec![first];
        events.extend(rest);
        events
    })
}

/// A world with a history, and a source of choices.
struct Lab {
    world: World,
    seed: u64,
    blocked: Blocked,
}

impl Lab {
    fn new(seed: u64) -> Self {
        Self {
            world: World::new(&NODES),
            seed,
            blocked: Blocked::new(),
        }
    }

    fn after(seed: u64, events: &[Event]) -> Result<Self, TestCaseError> {
        let mut lab = Self::new(seed);
        for event in events {
            lab.happen(event)?;
        }
        Ok(lab)
    }

    fn happen(&mut self, event: &Event) -> TestCaseResult {
        let world = &mut self.world;
        match event {
            Event::Apply(system) => {
                prop_assert_eq!(check_orders(&system.spec), []);
                world.apply(StoredSystem::clone(system));
            }
            Event::Tweak(nth, what) => tweak(world, *nth, *what),
            Event::Delete(name) => world.delete(name),
            Event::Roll { fail, block } => {
                let plan = plan(&world.desired(), &world.observed(), &self.blocked);
                let run = self.run(&plan, Some(*fail))?;
                self.blocked = if *block { run.failed } else { Blocked::new() };
            }
            Event::Kill(nth) => world.kill(*nth),
            Event::Error(nth) => {
                if let Some(component) = world.components_mut().nth(*nth) {
                    component.state = LifeCycleState::Error;
                    component.message = Some("on_execute returned BAD_PARAMETER".to_owned());
                }
            }
            Event::Inactive(nth) => {
                if let Some(component) = world.components_mut().nth(*nth) {
                    component.state = LifeCycleState::Inactive;
                }
            }
            Event::Connector(nth, state) => {
                let mut connectors = world.components_mut().flat_map(|c| &mut c.connectors);
                if let Some(connector) = connectors.nth(*nth) {
                    connector.state = *state;
                }
            }
            Event::ByHand(nth, name, own) => world.create_by_hand(*nth, name, *own),
            Event::SilentNode(nth) => drop(world.silent.insert(NODES[*nth].to_owned())),
            Event::SilentManager(nth) => {
                if let Some(manager) = world.managers_mut().nth(*nth) {
                    manager.responsive = false;
                }
            }
            Event::Calm => world.calm(),
        }
        Ok(())
    }

    fn random(seed: &mut u64) -> usize {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (*seed >> 33) as usize
    }

    fn run(&mut self, plan: &Plan, fail: Option<usize>) -> Result<Run, TestCaseError> {
        well_formed(plan, &self.blocked)?;
        let mut seed = self.seed;
        let mut nth = 0;
        let mut fails = |_: &_| {
            nth += 1;
            fail.is_some_and(|every| nth % every == 0)
        };
        let chance = Chance {
            pick: &mut |_| Self::random(&mut seed),
            fails: &mut fails,
        };
        let run = self.world.execute(plan, chance);
        self.seed = seed;
        run.map_err(|broken| TestCaseError::fail(format!("{broken}\n{plan}\n{:#?}", plan.steps)))
    }

    fn plan(&self) -> Plan {
        plan(
            &self.world.desired(),
            &self.world.observed(),
            &Blocked::new(),
        )
    }

    /// Plans and executes until there is nothing to do.
    fn converge(&mut self) -> TestCaseResult {
        self.blocked.clear();
        for _ in 0..8 {
            let plan = self.plan();
            if plan.steps.is_empty() {
                return Ok(());
            }
            self.run(&plan, None)?;
        }
        Err(TestCaseError::fail(format!("no end: {}", self.plan())))
    }

    /// An agent, which sees its own node alone, finds nothing to do either.
    fn agents_agree(&self) -> TestCaseResult {
        let (mut desired, observed) = (self.world.desired(), self.world.observed());
        for (node, answer) in observed.nodes {
            let mut own = Desired::default();
            own.nodes.extend(desired.nodes.remove_entry(&node));
            let mut seen = Observed::default();
            seen.nodes.insert(node, answer);
            let plan = plan(&own, &seen, &Blocked::new());
            prop_assert!(plan.is_empty() && plan.waiting_on.is_empty(), "{}", plan);
        }
        Ok(())
    }

    /// Everything desired is there and Active; `Err` names what is not.
    fn difference(&self) -> Vec<String> {
        let mut missing = Vec::new();
        for (node, spec) in &self.world.desired().nodes {
            for part in &spec.systems {
                for placed in &part.components {
                    let there = self.world.components().any(|(n, key, c)| {
                        n == node
                            && key.name == placed.manager
                            && key.system.as_ref() == Some(&part.system)
                            && c.instance == placed.spec.instance
                            && c.system.as_ref() == Some(&part.system)
                            && c.recreate_hash == placed.recreate_hash
                            && c.type_name == placed.spec.type_name
                            && c.state == LifeCycleState::Active
                            && configured(&placed.spec, c)
                    });
                    if !there {
                        missing.push(placed.spec.instance.clone());
                    }
                }
                for placed in &part.connectors {
                    let there = self.world.components().any(|(_, _, c)| {
                        c.connectors.iter().any(|o| {
                            o.name == placed.spec.name
                                && o.properties == placed.spec.properties
                                && o.state == ConnectorState::Connected
                        })
                    });
                    if !there {
                        missing.push(placed.spec.name.clone());
                    }
                }
            }
        }
        missing
    }
}

/// Every value that the spec names is set. Random values are numbers.
fn configured(spec: &ComponentSpec, live: &ComponentObserved) -> bool {
    let number = |text: &String| text.parse::<f64>().unwrap();
    let values = spec.configuration.sets.iter().all(|(set, values)| {
        let own = live.configuration.sets.get(set);
        values.iter().all(|(name, value)| {
            let there = own.and_then(|own| own.get(name));
            there.is_some_and(|there| number(there) == number(value))
        })
    });
    let rate = spec.execution_context.rate;
    values && rate.is_none_or(|rate| rate == live.rate)
}

/// Ids count from 1 and every edge leads backwards; blocked targets get no step.
fn well_formed(plan: &Plan, blocked: &Blocked) -> TestCaseResult {
    for (step, number) in plan.steps.iter().zip(1..) {
        prop_assert_eq!(step.id, number);
        let before = step.needs.iter().chain(&step.after_start_of);
        prop_assert!(before.copied().all(|id| id > 0 && id < number), "{}", plan);
        let brings_up = matches!(
            step.work.kind(),
            "Install"
                | "StartManager"
                | "LoadModule"
                | "Create"
                | "Configure"
                | "Reset"
                | "Connect"
                | "Activate"
        );
        let takes_down = matches!(step.work.kind(), "Deactivate" | "Delete" | "StopManager");
        prop_assert!(
            !((brings_up || takes_down) && blocked.contains_key(&on(&step.node, &step.target))),
            "{:?}",
            step
        );
    }
    prop_assert!(
        plan.steps.is_empty() || !plan.changes.is_empty(),
        "{}",
        plan
    );
    prop_assert!(plan.changes.is_sorted_by_key(|c| &c.target));
    Ok(())
}

fn incarnations(world: &World) -> BTreeMap<String, String> {
    let all = world.components();
    all.map(|(_, _, c)| {
        (
            c.incarnation.clone(),
            format!("{:?} {}", c.state, c.instance),
        )
    })
    .collect()
}

fn by_hand(world: &World) -> BTreeSet<String> {
    let own = world
        .components()
        .filter(|(_, key, _)| key.system.is_none());
    own.filter(|(_, _, c)| c.system.is_none())
        .map(|(_, _, c)| c.incarnation.clone())
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// From any state, repeated plans come to an end, and then all is as desired or said to wait.
    #[test]
    fn converges(seed: u64, events in events()) {
        let mut lab = Lab::after(seed, &events)?;
        lab.world.calm();
        lab.converge()?;
        let waiting: BTreeSet<String> =
            lab.plan().waiting_on.into_iter().map(|w| w.target).collect();
        for missing in lab.difference() {
            let said = [format!("component/{missing}"), format!("connector/{missing}")];
            prop_assert!(said.iter().any(|t| waiting.contains(t)), "{} is missing in silence", missing);
        }
    }

    /// Without something that only a person can mend, nothing waits in the end.
    #[test]
    fn nothing_waits_for_ever(seed: u64, events in events()) {
        let mend = |event: &Event| !matches!(event, Event::ByHand(..) | Event::Error(_));
        let events: Vec<Event> = events.into_iter().filter(mend).collect();
        let mut lab = Lab::after(seed, &events)?;
        lab.world.calm();
        lab.converge()?;
        prop_assert_eq!(lab.plan().waiting_on, []);
        prop_assert_eq!(lab.difference(), Vec::<String>::new());
        lab.agents_agree()?;
    }

    /// What is missing, and can be seen to be, is a change, whether something can be done about it now or not.
    #[test]
    fn what_is_missing_is_a_change(seed: u64, events in events()) {
        let mut lab = Lab::after(seed, &events)?;
        lab.world.calm();
        let plan = plan(&lab.world.desired(), &lab.world.observed(), &lab.blocked);
        let changed: BTreeSet<String> = plan.changes.iter().map(|c| c.target.clone()).collect();
        for missing in lab.difference() {
            let said = [format!("component/{missing}"), format!("connector/{missing}")];
            prop_assert!(said.iter().any(|t| changed.contains(t)), "{} is missing: {}", missing, plan);
        }
    }

    /// A converged world gets an empty plan, whoever asks how often.
    #[test]
    fn same_input_same_plan(seed: u64, events in events()) {
        let lab = Lab::after(seed, &events)?;
        let (desired, observed) = (lab.world.desired(), lab.world.observed());
        let once = plan(&desired, &observed, &lab.blocked);
        prop_assert_eq!(&once, &plan(&desired, &observed, &lab.blocked));
        prop_assert!(once.steps.is_empty() || !once.changes.is_empty());
    }

    /// Teardown leaves nothing but what a person made, and does not touch that.
    #[test]
    fn teardown_leaves_nothing(seed: u64, events in events(), silent in any::<u16>()) {
        let mut lab = Lab::after(seed, &events)?;
        lab.world.calm();
        // Managers that do not answer, whichever, do not matter.
        for (nth, manager) in lab.world.managers_mut().enumerate() {
            manager.responsive = silent >> (nth % 16) & 1 == 0;
        }
        let mine = by_hand(&lab.world);
        lab.world.delete("a");
        lab.world.delete("b");
        lab.converge()?;
        let left: Vec<_> = lab.world.managers().filter(|(_, m)| m.key.system.is_some()).collect();
        prop_assert!(left.is_empty(), "{:?}", left);
        prop_assert_eq!(mine, by_hand(&lab.world));
    }

    /// One system's end is not felt in another.
    #[test]
    fn systems_do_not_disturb_each_other(
        seed: u64,
        events in events(),
        other in system("b", "D", 3),
    ) {
        let mut lab = Lab::after(seed, &events)?;
        lab.world.calm();
        lab.world.apply(other);
        lab.converge()?;
        let of_b = |world: &World| -> BTreeMap<String, String> {
            let all = world.components().filter(|(_, _, c)| c.instance.starts_with('D'));
            all.map(|(_, _, c)| (c.incarnation.clone(), format!("{:?} {:?}", c.state, c.connectors))).collect()
        };
        let before = of_b(&lab.world);
        lab.world.delete("a");
        let teardown = lab.plan();
        let felt = teardown.steps.iter().find(|s| s.system.as_ref().is_some_and(|s| s.name == "b"));
        prop_assert!(felt.is_none(), "{:?}", felt);
        lab.converge()?;
        prop_assert_eq!(before, of_b(&lab.world));
    }

    /// What is as desired is not touched: whatever a plan does, a component whose place and hash are right, in a
    /// process in which no module changed, stays the same instance and is never deactivated.
    #[test]
    fn settled_is_not_touched(seed: u64, events in events(), fail in 1..9usize) {
        let mut lab = Lab::after(seed, &events)?;
        let desired = lab.world.desired();
        let mut settled = BTreeSet::new();
        for (node, manager) in lab.world.managers() {
            let parts = &desired.nodes[node].systems;
            let part = parts.iter().find(|p| Some(&p.system) == manager.key.system.as_ref());
            let Some(part) = part else { continue };
            let place = |instance: &str| part.components.iter().find(|p| p.spec.instance == instance && p.manager == manager.key.name);
            let changed = manager.components.iter().any(|c| place(&c.instance).is_some_and(|p| {
                let with_new_module = recreate_hash(&c.type_name, p.module_digest.as_deref(), &p.manager, c.execution_kind);
                p.spec.type_name == c.type_name && with_new_module != c.recreate_hash
            }));
            for component in &manager.components {
                let fits = component.system.as_ref() == Some(&part.system) && place(&component.instance).is_some_and(|p| p.recreate_hash == component.recreate_hash);
                if fits && !changed {
                    settled.insert((component.incarnation.clone(), component.instance.clone(), node.to_owned(), manager.key.clone()));
                }
            }
        }
        let plan = lab.plan();
        for (_, instance, node, key) in &settled {
            for step in &plan.steps {
                let hit = match &step.work {
                    Work::Deactivate { manager, instance: i } | Work::Delete { manager, instance: i } => i == instance && manager == key && step.node == *node,
                    Work::StopManager { manager, .. } => manager == key && step.node == *node,
                    _ => false,
                };
                prop_assert!(!hit, "{:?}", step);
            }
        }
        lab.blocked.clear();
        lab.run(&plan, Some(fail))?;
        let there = incarnations(&lab.world);
        for (incarnation, instance, ..) in &settled {
            prop_assert!(there.contains_key(incarnation), "{} was lost", instance);
        }
    }
}
