//! The world of a scenario.

use std::sync::Arc;

use rts_controller::simulator::{Scenario, ScenarioNode};
use rts_controller::store::{Store, StoreError};

use super::modules::{before, modules};
use crate::life::Life;
use crate::modules::SimModule;
use crate::seed::Seed;
use crate::store::SimStore;
use crate::world::World;
use crate::world::setup::{NodeSetup, Setup};

/// The world of a scenario, in which nothing runs yet. The modules are those with which everything came up.
pub async fn world(scenario: &Scenario) -> Result<Arc<World>, StoreError> {
    let seed = Seed(scenario.seed);
    let store = SimStore::new(seed, &scenario.before.cluster_uid);
    let filler = store.grip(&Life::new("filler", 1));
    filler.write(scenario.before.writes()).await?;
    let node = |node: &ScenarioNode| {
        let now: Vec<SimModule> = modules(scenario, node);
        NodeSetup {
            name: node.name.clone(),
            aliases: node.aliases.clone(),
            modules: now.iter().map(|m| before(scenario, m)).collect(),
            // What components of the user start is not known.
            grandchildren: Some(0.0),
        }
    };
    let setup = Setup {
        nodes: scenario.nodes.iter().map(node).collect(),
        local_node: scenario.local_node.clone(),
        store,
        // Nobody starts it again, as in reality.
        tries_again: false,
    };
    Ok(World::new(seed, setup))
}

/// Puts the module files of today in their places.
pub fn update_modules(world: &World, scenario: &Scenario) {
    for node in &scenario.nodes {
        let Some(own) = world.nodes.get(&node.name) else {
            continue;
        };
        for module in modules(scenario, node) {
            own.machine
                .replace_module(&module.type_name, &module.digest);
        }
    }
}
