//! Programs: started, and started again after each crash.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use rts_agent::Config;
use rts_controller::simulator::NoSimulator;
use rts_controller::{Core, Reconciler, expire_sessions};
use tokio::task::JoinSet;

use super::world::World;
use crate::fleet::{SimFleet, SimSession};
use crate::life::Life;
use crate::truth::Happened;
use crate::workload::NODES;

/// Time from the start of a program that did not come up to its next one.
const AGAIN: Duration = Duration::from_secs(1);

/// Runs the controller for ever, or until it is no longer the one that is started again.
pub(super) async fn controller(world: Arc<World>) {
    loop {
        let life = world.new_life("controller").await;
        live(&world, &life, start_controller(&world, &life)).await;
        if world.is_retired(&life) {
            return;
        }
    }
}

/// Runs the agent of a node for ever.
pub(super) async fn agent(world: Arc<World>, node: String) {
    loop {
        let life = world.new_life(&node).await;
        // A machine that was without power has it again.
        world.net.dark(&node, false);
        live(&world, &life, start_agent(&world, &life)).await;
    }
}

/// One life, to its end. What was started with it goes then: it can do nothing any more.
async fn live<T>(world: &World, life: &Life, start: impl Future<Output = Result<T, String>>) {
    world.truth.tell(&Happened::Started {
        host: life.host().to_owned(),
        life: life.number(),
    });
    let started = tokio::select! {
        biased;
        () = life.over() => None,
        started = start => Some(started),
    };
    let _program = match started {
        Some(Ok(program)) => Some(program),
        Some(Err(why)) => {
            world.note(format!("{} does not come up: {why}", life.host()));
            world.coverage.count("programs that did not come up");
            world.keep_down(life.host(), AGAIN);
            life.end();
            None
        }
        None => None,
    };
    life.over().await;
    world.crashed(life);
}

/// Starts a controller with the store of now.
async fn start_controller(world: &Arc<World>, life: &Life) -> Result<JoinSet<()>, String> {
    let store = world.store();
    let state = store.state();
    let systems = state.systems.values();
    world.truth.tell(&Happened::StoreRead {
        epoch: state.epoch,
        systems: systems
            .map(|r| {
                (
                    r.name().to_owned(),
                    r.deleted.is_none().then_some(r.generation),
                )
            })
            .collect(),
    });
    let chance = format!("controller/{}", life.number());
    let inputs = rts_controller::Inputs {
        local_node: NODES[0].to_owned(),
        clock: Arc::new(world.clock.clone()),
        rng: Arc::new(world.seed.stream(&chance)),
        fleet: Arc::new(SimFleet::new(&world.hosts, life)),
        store: Arc::new(store.grip(life)),
        simulator: Arc::new(NoSimulator),
    };
    let core = Core::load(inputs).await.map_err(|e| e.to_string())?;
    world.hosts.controller_serves(life, &core);
    let mut tasks = JoinSet::new();
    tasks.spawn(Reconciler::new(Arc::clone(&core)).run());
    tasks.spawn(expire_sessions(core));
    Ok(tasks)
}

async fn start_agent(world: &Arc<World>, life: &Life) -> Result<rts_agent::Running, String> {
    let name = life.host().to_owned();
    let node = world.nodes.get(&name).ok_or("there is no such node")?;
    world.truth.tell(&Happened::LedgerRead {
        node: name.clone(),
        fence: world.ledger(&name),
    });
    let config = Config {
        home: PathBuf::from("/sim"),
        node: name.clone(),
        aliases: Vec::new(),
        module_path: Vec::new(),
        manager_program: PathBuf::from("/sim/rts-manager"),
        controller_socket: None,
        heal_after: Some(Config::HEAL_AFTER),
    };
    let inputs = rts_agent::Inputs {
        clock: Arc::new(node.clock.clone()),
        chance: Arc::new(
            world
                .seed
                .stream(&format!("agent/{name}/{}", life.number())),
        ),
        disk: node.disk.grip(life.clone()),
        machine: node.machine.grip(life.clone()),
        controller: Some(Arc::new(SimSession::new(&world.hosts, life))),
    };
    let running = rts_agent::start(config, inputs)
        .await
        .map_err(|e| e.to_string())?;
    world.hosts.agent_serves(life, running.api());
    Ok(running)
}
