//! The world of a schedule, and all that watches it.

use std::ops::Deref;
use std::sync::Arc;

use super::coverage::Coverage;
use super::ground::Ground;
use crate::check::{self, Desired, Verdicts};
use crate::modules::SimModule;
use crate::seed::Seed;
use crate::store::SimStore;
use crate::trace::Trace;
use crate::workload::{NODES, TYPES};
use crate::world::World;
use crate::world::setup::{NodeSetup, Setup};

/// The world of a schedule, and all that watches it.
pub(super) struct Stage {
    pub world: Arc<World>,
    pub trace: Trace,
    pub ground: Ground,
    pub coverage: Coverage,
    pub desired: Desired,
    pub verdicts: Verdicts,
}

impl Stage {
    /// Machines with the modules of the workload, and an empty store.
    pub fn new(seed: Seed, nodes: usize, trace: Trace) -> Arc<Self> {
        let node = |name: &&str| NodeSetup {
            name: (*name).to_owned(),
            aliases: Vec::new(),
            modules: TYPES.map(|type_name| module(type_name, 1)).into(),
            grandchildren: None,
        };
        let setup = Setup {
            nodes: NODES.iter().take(nodes).map(node).collect(),
            local_node: NODES[0].to_owned(),
            store: SimStore::new(seed, "simulated"),
            tries_again: true,
        };
        let world = World::new(seed, setup);
        let ground = Ground::default();
        let coverage = Coverage::default();
        let desired = Desired::default();
        world.truth.show(trace.clone());
        world.truth.show(ground.clone());
        world.truth.show(coverage.clone());
        let verdicts = check::watch(&world.truth, &desired);
        Arc::new(Self {
            world,
            trace,
            ground,
            coverage,
            desired,
            verdicts,
        })
    }
}

impl Deref for Stage {
    type Target = World;

    fn deref(&self) -> &World {
        &self.world
    }
}

/// The `version`th module of a type of the workload.
pub(super) fn module(type_name: &str, version: u32) -> SimModule {
    let mut module = SimModule::new(type_name)
        .port("in", "in", "TimedDouble")
        .port("out", "out", "TimedDouble")
        .parameter("gain", "1")
        .parameter("offset", "0");
    module.digest = module.version(version);
    module
}
