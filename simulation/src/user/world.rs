//! Everything that there is: hosts with their machines, disks and clocks, the store, and the network between them.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use rts_agent_api::messages::ModuleResolution;
use rts_controller::simulator::{Scenario, ScenarioNode};
use rts_controller::store::{Store, StoreError};
use rts_schemas::system::{ComponentSpec, Direction, PortKind};
use tokio::sync::watch;
use tokio::time::Instant;

use crate::clock::SimClock;
use crate::disk::SimDisk;
use crate::fleet::Hosts;
use crate::life::Life;
use crate::machine::SimMachine;
use crate::modules::SimModule;
use crate::net::Net;
use crate::seed::Seed;
use crate::store::SimStore;
use crate::truth::Truth;
use crate::words::CONTROLLER;

/// The world.
pub struct World {
    pub seed: Seed,
    pub net: Net,
    pub hosts: Hosts,
    pub truth: Truth,
    pub store: SimStore,
    pub clock: SimClock,
    pub local_node: String,
    pub nodes: BTreeMap<String, Node>,
    programs: Mutex<BTreeMap<String, Program>>,
    /// Raised when a program may start.
    pub changed: watch::Sender<u64>,
}

/// A node.
pub struct Node {
    pub machine: SimMachine,
    pub disk: SimDisk,
    pub clock: SimClock,
    pub aliases: Vec<String>,
    /// Modules as they are now, after the ones with which everything came up.
    now: Vec<SimModule>,
}

/// The program of a host.
#[derive(Default)]
struct Program {
    lives: u32,
    life: Option<Life>,
    /// After its next crash: how long it stays down; none for ever.
    down: Option<Option<Duration>>,
    keeps: Keeps,
}

/// What keeps a program from starting.
#[derive(Debug, Clone, Copy, Default)]
enum Keeps {
    #[default]
    Nothing,
    Until(Instant),
    Always,
}

impl World {
    /// The world of a scenario, in which nothing runs yet.
    pub async fn new(scenario: &Scenario) -> Result<Arc<Self>, StoreError> {
        let seed = Seed(scenario.seed);
        let (truth, begin, net) = (Truth::new(), Instant::now(), Net::new(seed));
        let store = SimStore::new(seed, &scenario.before.cluster_uid);
        let filler = store.grip(&Life::new("filler", 1));
        filler.write(scenario.before.writes()).await?;
        let node = |node: &ScenarioNode| {
            let clock = SimClock::new(begin);
            let name = node.name.as_str();
            let machine = SimMachine::new(name, seed, clock.clone(), truth.clone());
            // What components of the user start is not known.
            machine.grandchildren(0.0);
            let now = modules(scenario, node);
            for module in &now {
                machine.install(before(scenario, module));
            }
            let node = Node {
                machine,
                disk: SimDisk::new(name, seed),
                clock,
                aliases: node.aliases.clone(),
                now,
            };
            (name.to_owned(), node)
        };
        let nodes: BTreeMap<String, Node> = scenario.nodes.iter().map(node).collect();
        let hosts = nodes.keys().map(String::as_str).chain([CONTROLLER]);
        Ok(Arc::new(Self {
            hosts: Hosts::new(net.clone(), truth.clone()),
            programs: Mutex::new(hosts.map(|h| (h.to_owned(), Program::default())).collect()),
            clock: SimClock::new(begin),
            local_node: scenario.local_node.clone(),
            changed: watch::Sender::new(0),
            seed,
            net,
            truth,
            store,
            nodes,
        }))
    }

    /// Puts the module files of today in their places.
    pub fn update_modules(&self) {
        for node in self.nodes.values() {
            for module in &node.now {
                node.machine
                    .replace_module(&module.type_name, &module.digest);
            }
        }
    }

    /// Waits until the program of a host may start, and begins a life of it.
    pub async fn new_life(&self, host: &str) -> Life {
        let mut changed = self.changed.subscribe();
        loop {
            let keeps = self.program(host, |program| program.keeps);
            let until = match keeps {
                Keeps::Nothing => break,
                Keeps::Until(until) if until <= Instant::now() => break,
                Keeps::Until(until) => Some(until),
                Keeps::Always => None,
            };
            let due = async {
                match until {
                    Some(until) => tokio::time::sleep_until(until).await,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                biased;
                _ = changed.changed() => {}
                () = due => {}
            }
        }
        self.program(host, |program| {
            program.keeps = Keeps::Nothing;
            program.lives += 1;
            let life = Life::new(host, program.lives);
            program.life = Some(life.clone());
            life
        })
    }

    /// A program has crashed: when it may start again.
    pub fn crashed(&self, host: &str) {
        self.program(host, |program| {
            program.keeps = match program.down.take() {
                Some(Some(down)) => Keeps::Until(Instant::now() + down),
                // Nobody starts it again, as in reality.
                _ => Keeps::Always,
            };
        });
    }

    /// Lets a program crash, at once or at its `calls`th passage, and stay down for a while. False when it is down.
    pub fn end(&self, host: &str, calls: u64, down: Option<Duration>) -> bool {
        let life = self.program(host, |program| {
            let life = program.life.clone().filter(|life| !life.is_over())?;
            program.down = Some(down);
            Some(life)
        });
        match life {
            None => false,
            Some(life) if calls == 0 => {
                life.end();
                true
            }
            Some(life) => {
                life.burn(calls);
                true
            }
        }
    }

    /// A program that is down must stay so for this long.
    pub fn keep_down(&self, host: &str, down: Duration) {
        let until = Instant::now() + down;
        self.program(host, |program| program.keeps = Keeps::Until(until));
        self.changed.send_modify(|n| *n = n.wrapping_add(1));
    }

    fn program<T>(&self, host: &str, of: impl FnOnce(&mut Program) -> T) -> T {
        let mut programs = self.programs.lock().unwrap_or_else(PoisonError::into_inner);
        of(programs.entry(host.to_owned()).or_default())
    }
}

/// The modules of a node: as its agent finds them, or as the components need them.
fn modules(scenario: &Scenario, node: &ScenarioNode) -> Vec<SimModule> {
    let types: &BTreeSet<String> = &node.parts.types;
    let found = |name: &String| {
        let known = node.modules.as_ref();
        known.map(|all| all.iter().find(|resolution| resolution.type_name == *name))
    };
    let modules = types.iter().filter_map(|name| match found(name) {
        Some(resolution) => described(scenario, name, resolution?),
        None => Some(guessed(scenario, name)),
    });
    modules.collect()
}

fn described(scenario: &Scenario, name: &str, found: &ModuleResolution) -> Option<SimModule> {
    let file = found.module.as_ref()?;
    let Some(description) = &file.description else {
        let mut module = guessed(scenario, name);
        module.digest.clone_from(&file.digest);
        return Some(module);
    };
    let mut module = SimModule::new(name);
    for port in description
        .ports
        .iter()
        .filter(|port| port.kind == PortKind::Data)
    {
        module = module.port(&port.name, word(port.direction), &port.data_type);
    }
    module.parameters.clone_from(&description.parameters);
    module.digest.clone_from(&file.digest);
    Some(module)
}

/// A module with all that components of its type use.
fn guessed(scenario: &Scenario, name: &str) -> SimModule {
    let mut module = SimModule::new(name);
    for component in components(scenario).filter(|c| c.type_name == name) {
        for port in component
            .ports
            .iter()
            .filter(|port| port.kind == PortKind::Data)
        {
            if !module.ports.iter().any(|known| known.name == port.name) {
                let data_type = port.data_type.as_deref().unwrap_or_default();
                module = module.port(&port.name, word(port.direction), data_type);
            }
        }
        for (parameter, value) in component.configuration.sets.values().flatten() {
            module = module.parameter(parameter, value);
        }
    }
    module
}

fn components(scenario: &Scenario) -> impl Iterator<Item = &ComponentSpec> {
    let stored = scenario.before.systems.values().map(|record| &record.spec);
    stored
        .chain([&scenario.request.spec])
        .flat_map(|spec| &spec.components)
}

fn word(direction: Option<Direction>) -> &'static str {
    match direction {
        Some(Direction::Out) => "out",
        _ => "in",
    }
}

/// The module with which everything came up.
fn before(scenario: &Scenario, module: &SimModule) -> SimModule {
    let records = scenario.before.systems.values();
    let mut pinned = records.filter_map(|record| record.digests.get(&module.type_name));
    let mut before = module.clone();
    if let Some(digest) = pinned.next() {
        before.digest.clone_from(digest);
    }
    before
}
