//! A world with a random history, in which plans are made and carried out.

// Each test program uses a part of it.
#![allow(dead_code)]

pub mod shape;
pub mod trouble;

use std::collections::BTreeSet;

use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use rts_plan::desired::Desired;
use rts_plan::observed::{ComponentObserved, ConnectorState, LifeCycleState, Observed};
use rts_plan::plan::{Blocked, Drift, Plan, Step, StepId, Work};
use rts_plan::target::{component, connector, on};
use rts_plan::{StoredSystem, check_orders, plan};
use rts_schemas::system::{ComponentSpec, DriftPolicy, ExecutionKind};

use crate::world::World;
use crate::world::by_hand::Hand;
use crate::world::execute::{Chance, Run};
use crate::world::specs::{NODES, drift_policy, on_disconnect, set, system};

/// Something that happens to the world.
#[derive(Debug, Clone)]
pub enum Event {
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
    /// An in-port end is found without a source.
    LeftEnd(usize, bool),
    ByHand(usize, &'static str, bool),
    SilentNode(usize),
    SilentManager(usize),
    /// A manager hangs while its agent starts anew.
    UnseenManager(usize),
    Expire(usize),
    Hold(usize),
    /// A person does something.
    Hand(Hand),
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
        1 => {
            component.execution_context.rate = Some(20.0);
            component.execution_context.order += 5;
        }
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
        6..=8 => component.policy.on_disconnect = on_disconnect(what - 6),
        9..=11 => component.policy.drift = drift_policy(what - 8),
        _ => drop(spec.connectors.pop()),
    }
}

fn event() -> impl Strategy<Value = Event> {
    let state = prop_oneof![
        Just(ConnectorState::Disconnected),
        Just(ConnectorState::Connecting)
    ];
    prop_oneof![
        4 => (0..9usize, 0..13u8).prop_map(|(nth, what)| Event::Tweak(nth, what)),
        3 => system("a", "C", 8).prop_map(apply),
        1 => system("b", "D", 3).prop_map(apply),
        1 => prop_oneof![Just("a"), Just("b")].prop_map(Event::Delete),
        6 => (1..12usize, any::<bool>()).prop_map(|(fail, block)| Event::Roll { fail, block }),
        2 => (0..9usize).prop_map(Event::Kill),
        1 => (0..9usize).prop_map(Event::Error),
        1 => (0..9usize).prop_map(Event::Inactive),
        1 => (0..9usize, state).prop_map(|(nth, state)| Event::Connector(nth, state)),
        2 => (0..9usize, any::<bool>()).prop_map(|(nth, other)| Event::LeftEnd(nth, other)),
        1 => (0..9usize, prop_oneof![Just("C0"), Just("H0")], any::<bool>())
            .prop_map(|(nth, name, own)| Event::ByHand(nth, name, own)),
        1 => (0..3usize).prop_map(Event::SilentNode),
        1 => (0..9usize).prop_map(Event::SilentManager),
        1 => (0..9usize).prop_map(Event::UnseenManager),
        1 => (0..9usize).prop_map(Event::Expire),
        1 => (0..9usize).prop_map(Event::Hold),
        4 => hand().prop_map(Event::Hand),
        1 => Just(Event::Calm),
    ]
}

/// Events without those that `drop` names.
pub fn without(events: &[Event], drop: impl Fn(&Event) -> bool) -> Vec<Event> {
    events
        .iter()
        .filter(|event| !drop(event))
        .cloned()
        .collect()
}

/// The same, with every component as `change` makes it, and no change of policies on the way.
pub fn with_components(events: &[Event], change: impl Fn(&mut ComponentSpec)) -> Vec<Event> {
    let mut events = without(events, |event| matches!(event, Event::Tweak(_, 6..=11)));
    for event in &mut events {
        if let Event::Apply(system) = event {
            system.spec.components.iter_mut().for_each(&change);
        }
    }
    events
}

/// What a person does to what is there.
pub fn hand() -> impl Strategy<Value = Hand> {
    let value = || prop_oneof![Just("3"), Just("1.0")];
    let how = || prop_oneof![Just("flush"), Just("new"), Just("nonblock")];
    prop_oneof![
        2 => (0..9usize, value()).prop_map(|(nth, value)| Hand::Set(nth, value)),
        1 => (0..9usize).prop_map(Hand::Switch),
        2 => (0..9usize).prop_map(Hand::Deactivate),
        1 => (0..9usize).prop_map(Hand::Activate),
        2 => (0..9usize, 0..9usize, how()).prop_map(|(nth, to, how)| Hand::Connect(nth, to, how)),
        2 => (0..9usize, 0..4usize).prop_map(|(nth, at)| Hand::Disconnect(nth, at)),
        1 => (0..9usize, 0..4usize, how()).prop_map(|(nth, at, how)| Hand::Reconnect(nth, at, how)),
    ]
}

pub fn events() -> impl Strategy<Value = Vec<Event>> {
    let first = system("a", "C", 8).prop_map(apply);
    (first, prop::collection::vec(event(), 0..14)).prop_map(|(first, rest)| {
        let mut events = vec![first];
        events.extend(rest);
        events
    })
}

/// A world with a history, and a source of choices.
pub struct Lab {
    pub world: World,
    seed: u64,
    pub blocked: Blocked,
}

impl Lab {
    fn new(seed: u64) -> Self {
        Self {
            world: World::new(&NODES),
            seed,
            blocked: Blocked::new(),
        }
    }

    pub fn after(seed: u64, events: &[Event]) -> Result<Self, TestCaseError> {
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
            Event::LeftEnd(nth, of_another) => world.leave_end(*nth, *of_another),
            Event::ByHand(nth, name, own) => world.create_by_hand(*nth, name, *own),
            Event::SilentNode(nth) => drop(world.silent.insert(NODES[*nth].to_owned())),
            Event::SilentManager(nth) => {
                if let Some(manager) = world.managers_mut().nth(*nth) {
                    manager.responsive = false;
                }
            }
            Event::UnseenManager(nth) => world.lose_sight_of_manager(*nth),
            Event::Expire(nth) => {
                if let Some(manager) = world.managers_mut().nth(*nth) {
                    manager.expired = Some("C0 has been in on_execute for 9 s".to_owned());
                }
            }
            Event::Hold(nth) => world.hold(*nth),
            Event::Hand(hand) => world.by_hand(hand),
            Event::Calm => world.calm(),
        }
        Ok(())
    }

    fn random(seed: &mut u64) -> usize {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (*seed >> 33) as usize
    }

    pub fn run(&mut self, plan: &Plan, fail: Option<usize>) -> Result<Run, TestCaseError> {
        let mut nth = 0;
        let mut fails = |_: &Step| {
            nth += 1;
            fail.is_some_and(|every| nth % every == 0)
        };
        self.run_failing(plan, &mut fails, fail.is_some())
    }

    /// What the agent of a node plans and does alone. A connector to another node fails where its target is not there,
    /// as that one's agent says.
    pub fn run_alone(&mut self, node: &str) -> Result<Run, TestCaseError> {
        let plan = self.alone(node);
        let there: BTreeSet<(String, String, String)> = self
            .world
            .components()
            .map(|(n, key, c)| (n.to_owned(), key.name.clone(), c.instance.clone()))
            .collect();
        let mut fails = |step: &Step| match &step.work {
            Work::Connect { connector } if connector.target.node != node => {
                let place = &connector.target;
                let target = connector.spec.target.instance.clone();
                !there.contains(&(place.node.clone(), place.manager.clone(), target))
            }
            _ => false,
        };
        self.run_failing(&plan, &mut fails, false)
    }

    fn run_failing(
        &mut self,
        plan: &Plan,
        fails: &mut dyn FnMut(&Step) -> bool,
        hasty: bool,
    ) -> Result<Run, TestCaseError> {
        well_formed(plan, &self.blocked)?;
        let mut seed = self.seed;
        let chance = Chance {
            pick: &mut |_| Self::random(&mut seed),
            fails,
        };
        self.world.hasty = hasty;
        let run = self.world.execute(plan, chance);
        self.seed = seed;
        run.map_err(|broken| TestCaseError::fail(format!("{broken}\n{plan}\n{:#?}", plan.steps)))
    }

    pub fn plan(&self) -> Plan {
        plan(
            &self.world.desired(),
            &self.world.observed(),
            &Blocked::new(),
        )
    }

    /// Plans and executes until there is nothing to do.
    pub fn converge(&mut self) -> TestCaseResult {
        self.blocked.clear();
        for _ in 0..8 {
            let plan = self.plan();
            if plan.steps.is_empty() {
                prop_assert_eq!(self.world.left_ends(), []);
                return Ok(());
            }
            self.run(&plan, None)?;
        }
        Err(TestCaseError::fail(format!("no end: {}", self.plan())))
    }

    /// An agent, which sees its own node alone, finds nothing to do either.
    pub fn agents_agree(&self) -> TestCaseResult {
        for node in NODES {
            let plan = self.alone(node);
            prop_assert!(plan.is_empty() && plan.waiting_on.is_empty(), "{}", plan);
        }
        Ok(())
    }

    /// What the agent of a node plans, which sees its own node alone.
    pub fn alone(&self, node: &str) -> Plan {
        let (mut desired, mut observed) = (self.world.desired(), self.world.observed());
        let mut own = Desired::default();
        own.nodes.extend(desired.nodes.remove_entry(node));
        let mut seen = Observed::default();
        seen.nodes.extend(observed.nodes.remove_entry(node));
        plan(&own, &seen, &Blocked::new())
    }

    /// Some have been deactivated, and some have failed.
    pub fn set_states(&mut self, states: &[u8]) {
        for (component, state) in self.world.components_mut().zip(states) {
            component.state = match state {
                0 => LifeCycleState::Inactive,
                1 => LifeCycleState::Error,
                _ => continue,
            };
        }
    }

    /// What a person changed by hand, and what becomes of it.
    pub fn drift(&self) -> Vec<Drift> {
        plan(&self.world.desired(), &self.world.observed(), &self.blocked).drift
    }

    /// Names what is desired and not there, or not Active; but for what a person changed and is left.
    pub fn difference(&self) -> Vec<String> {
        let drift = self.drift();
        let left = |target: String, field: &str| {
            let mut all = drift.iter().filter(|d| d.policy != DriftPolicy::Repair);
            all.any(|d| d.target == target && (field.is_empty() || has(d, field)))
        };
        let mut missing = Vec::new();
        for (node, spec) in &self.world.desired().nodes {
            for part in &spec.systems {
                for placed in &part.components {
                    let own = |field| left(component(&placed.spec.instance), field);
                    let there = self.world.components().any(|(n, key, c)| {
                        n == node
                            && key.name == placed.manager
                            && key.system.as_ref() == Some(&part.system)
                            && c.instance == placed.spec.instance
                            && c.system.as_ref() == Some(&part.system)
                            && c.recreate_hash == placed.recreate_hash
                            && c.type_name == placed.spec.type_name
                            && (c.state == LifeCycleState::Active || own("state"))
                            && (configured(&placed.spec, c) || own("configuration"))
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
                    if !there && !left(connector(&placed.spec.name), "") {
                        missing.push(placed.spec.name.clone());
                    }
                }
            }
        }
        missing
    }
}

/// True when a field, or one below it, differs.
pub fn has(drift: &Drift, field: &str) -> bool {
    drift.fields.iter().any(|f| f.field.starts_with(field))
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
    let policy = spec.policy.on_disconnect == live.on_disconnect;
    let shared = spec.execution_context.shared() == live.execution_context;
    values && policy && shared && rate.is_none_or(|rate| rate == live.rate)
}

/// Ids count from 1 and every edge leads backwards; blocked targets get no step.
fn well_formed(plan: &Plan, blocked: &Blocked) -> TestCaseResult {
    for (step, number) in plan.steps.iter().zip(1..) {
        prop_assert_eq!(step.id, number);
        let before: BTreeSet<StepId> = step.before().collect();
        prop_assert!(before.iter().all(|id| *id > 0 && *id < number), "{}", plan);
        for limit in &step.limits {
            let known = limit.steps.iter().all(|id| before.contains(id));
            prop_assert!(
                known && limit.ms > 0 && !limit.steps.is_empty(),
                "{:?}",
                step
            );
        }
        let known = step.because.iter().all(|b| before.contains(&b.step));
        prop_assert!(known, "{:?}", step);
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
