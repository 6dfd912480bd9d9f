//! Programs: started, and started again after each crash.

use std::path::PathBuf;
use std::sync::Arc;

use rts_agent::Config;
use rts_controller::simulator::NoSimulator;
use rts_controller::{Core, Reconciler, expire_sessions};
use tokio::task::JoinSet;

use super::World;
use crate::fleet::{SimFleet, SimPeers, SimSession};
use crate::life::Life;
use crate::truth::Happened;
use crate::words::CONTROLLER;

/// Starts the programs of all hosts.
pub fn start_all(world: &Arc<World>) {
    tokio::spawn(run(Arc::clone(world), CONTROLLER.to_owned()));
    for node in world.nodes.keys() {
        tokio::spawn(run(Arc::clone(world), node.clone()));
    }
}

/// Runs the program of a host for ever, or until it is no longer the one that is started again.
pub async fn run(world: Arc<World>, host: String) {
    loop {
        let life = world.lives.begin(&host).await;
        // A machine that was without power has it again.
        world.net.dark(&host, false);
        live(&world, &life).await;
        if world.lives.is_retired(&life) {
            return;
        }
    }
}

/// One life, to its end. What was started with it goes then: it can do nothing any more.
async fn live(world: &Arc<World>, life: &Life) {
    let (host, number) = (life.host().to_owned(), life.number());
    world.truth.tell(&Happened::Started { host, life: number });
    let started = tokio::select! {
        biased;
        () = life.over() => None,
        started = start(world, life) => Some(started),
    };
    let _program = match started {
        Some(Ok(program)) => Some(program),
        Some(Err(why)) => {
            world.truth.tell(&Happened::DidNotStart {
                host: life.host().to_owned(),
                why,
            });
            if world.lives.tries_again {
                life.end();
            }
            None
        }
        None => None,
    };
    life.over().await;
    world.crashed(life);
}

/// What must be kept for a program to go on.
#[expect(dead_code, reason = "it is only kept")]
enum Program {
    Controller(JoinSet<()>),
    Agent(rts_agent::Running),
}

async fn start(world: &Arc<World>, life: &Life) -> Result<Program, String> {
    match life.host() {
        CONTROLLER => controller(world, life).await.map(Program::Controller),
        _ => agent(world, life).await.map(Program::Agent),
    }
}

/// Starts a controller with the store of now.
async fn controller(world: &Arc<World>, life: &Life) -> Result<JoinSet<()>, String> {
    let (restores, store) = (world.restores(), world.store());
    let state = store.state();
    let systems = state.systems.values().map(|record| {
        let generation = record.deleted.is_none().then_some(record.generation);
        (record.name().to_owned(), generation)
    });
    world.truth.tell(&Happened::StoreRead {
        epoch: state.epoch,
        systems: systems.collect(),
    });
    let chance = format!("controller/{}", life.number());
    let inputs = rts_controller::Inputs {
        local_node: world.local_node.clone(),
        clock: Arc::new(world.clock.clone()),
        rng: Arc::new(world.seed.stream(&chance)),
        fleet: Arc::new(SimFleet::new(&world.hosts, life)),
        store: Arc::new(store.grip(life)),
        simulator: Arc::new(NoSimulator),
    };
    let core = Core::load(inputs).await.map_err(|e| e.to_string())?;
    world.hosts.controller_serves(life, &core);
    world.serves(restores);
    let mut tasks = JoinSet::new();
    tasks.spawn(Reconciler::new(Arc::clone(&core)).run());
    tasks.spawn(expire_sessions(core));
    Ok(tasks)
}

async fn agent(world: &Arc<World>, life: &Life) -> Result<rts_agent::Running, String> {
    let name = life.host().to_owned();
    let node = world.nodes.get(&name).ok_or("there is no such node")?;
    world.truth.tell(&Happened::LedgerRead {
        node: name.clone(),
        fence: world.ledger(&name),
    });
    let config = Config {
        home: PathBuf::from("/sim"),
        node: name.clone(),
        aliases: node.aliases.clone(),
        module_path: Vec::new(),
        manager_program: PathBuf::from("/sim/rts-manager"),
        controller_socket: None,
        heal_after: Some(Config::HEAL_AFTER),
        idle_managers: None,
    };
    let chance = format!("agent/{name}/{}", life.number());
    let inputs = rts_agent::Inputs {
        clock: Arc::new(node.clock.clone()),
        chance: Arc::new(world.seed.stream(&chance)),
        disk: node.disk.grip(life.clone()),
        machine: node.machine.grip(life.clone()),
        controller: Some(Arc::new(SimSession::new(&world.hosts, life))),
        peers: Arc::new(SimPeers::new(&world.hosts, life)),
    };
    let running = rts_agent::start(config, inputs).await;
    let running = running.map_err(|e| e.to_string())?;
    world.hosts.agent_serves(life, running.api());
    Ok(running)
}
