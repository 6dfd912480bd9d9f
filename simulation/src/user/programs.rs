//! The controller and the agents: started, and started again when a fault says so.

use std::path::PathBuf;
use std::sync::Arc;

use rts_agent::Config;
use rts_controller::simulator::NoSimulator;
use rts_controller::{Core, Reconciler, expire_sessions};
use tokio::task::JoinSet;

use super::world::World;
use crate::fleet::{SimFleet, SimSession};
use crate::life::Life;
use crate::truth::Happened;
use crate::words::CONTROLLER;

/// Runs the program of a host for ever.
pub async fn run(world: Arc<World>, host: String) {
    loop {
        let life = world.new_life(&host).await;
        // A machine that was without power has it again.
        world.net.dark(&host, false);
        world.truth.tell(&Happened::Started {
            host: host.clone(),
            life: life.number(),
        });
        let _program = tokio::select! {
            biased;
            () = life.over() => None,
            program = start(&world, &life) => match program {
                Ok(program) => Some(program),
                Err(why) => {
                    world.truth.tell(&Happened::Note(format!("{host} does not come up: {why}")));
                    None
                }
            },
        };
        life.over().await;
        world.crashed(&host);
        world.truth.tell(&Happened::Crashed {
            host: host.clone(),
            life: life.number(),
        });
    }
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

async fn controller(world: &Arc<World>, life: &Life) -> Result<JoinSet<()>, String> {
    let chance = format!("controller/{}", life.number());
    let core = Core::load(rts_controller::Inputs {
        local_node: world.local_node.clone(),
        clock: Arc::new(world.clock.clone()),
        rng: Arc::new(world.seed.stream(&chance)),
        fleet: Arc::new(SimFleet::new(&world.hosts, life)),
        store: Arc::new(world.store.grip(life)),
        simulator: Arc::new(NoSimulator),
    });
    let core = core.await.map_err(|e| e.to_string())?;
    world.hosts.controller_serves(life, &core);
    let mut tasks = JoinSet::new();
    tasks.spawn(Reconciler::new(Arc::clone(&core)).run());
    tasks.spawn(expire_sessions(core));
    Ok(tasks)
}

async fn agent(world: &Arc<World>, life: &Life) -> Result<rts_agent::Running, String> {
    let name = life.host().to_owned();
    let node = world.nodes.get(&name).ok_or("there is no such node")?;
    let config = Config {
        home: PathBuf::from("/sim"),
        node: name.clone(),
        aliases: node.aliases.clone(),
        module_path: Vec::new(),
        manager_program: PathBuf::from("/sim/rts-manager"),
        controller_socket: None,
        heal_after: Some(Config::HEAL_AFTER),
    };
    let chance = format!("agent/{name}/{}", life.number());
    let inputs = rts_agent::Inputs {
        clock: Arc::new(node.clock.clone()),
        chance: Arc::new(world.seed.stream(&chance)),
        disk: node.disk.grip(life.clone()),
        machine: node.machine.grip(life.clone()),
        controller: Some(Arc::new(SimSession::new(&world.hosts, life))),
    };
    let running = rts_agent::start(config, inputs).await;
    let running = running.map_err(|e| e.to_string())?;
    world.hosts.agent_serves(life, running.api());
    Ok(running)
}
