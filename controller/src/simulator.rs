//! What can play a change through: a simulation of the whole cluster, which the controller is given and does not know.

mod program;

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rts_agent_api::messages::ModuleResolution;
use rts_controller_api::Problem;
use rts_controller_api::requests::ApplyRequest;
use rts_controller_api::simulate::Simulated;
use serde::{Deserialize, Serialize};

pub use self::program::{HURRY, MAX_SCENARIO, ProgramSimulator};
use crate::store::State;

/// Plays a scenario through.
pub trait Simulator: Send + Sync + 'static {
    /// Blocks until it is over, on a thread of its own. Fails with 422 `bad-fault` when a fault is not understood. Must come
    /// to its end soon once it is told to stop.
    fn simulate(&self, scenario: &Scenario) -> Result<Simulated, Problem>;
}

/// What is simulated.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Scenario {
    /// What is stored before the apply. Simulated from what it wants, as if all of that had come to be.
    pub before: State,
    /// What is applied then.
    pub request: ApplyRequest,
    /// Name of the local node.
    pub local_node: String,
    /// The nodes.
    pub nodes: Vec<ScenarioNode>,
    /// Faults in words.
    pub faults: Vec<String>,
    /// All chance follows from it.
    pub seed: u64,
    /// Most time that is simulated after the apply.
    pub limit: Duration,
    /// Where it begins otherwise than the cluster is now.
    pub notes: Vec<String>,
    /// Tells when nobody waits for the answer any more.
    #[serde(skip)]
    pub stop: Stop,
}

/// A node.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ScenarioNode {
    /// Its name.
    pub name: String,
    /// Names by which hosts in profiles may mean it.
    pub aliases: Vec<String>,
    /// What is to be there, before the apply or after it.
    pub parts: Parts,
    /// Modules of the types that are needed there, as its agent finds them now; none when it could not be asked.
    pub modules: Option<Vec<ModuleResolution>>,
}

/// What a node is to have.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Parts {
    /// Display names of managers (`hello.main`).
    pub managers: BTreeSet<String>,
    /// Instance names.
    pub instances: BTreeSet<String>,
    /// Type names.
    pub types: BTreeSet<String>,
}

/// Told when it takes too long, and when nobody waits any more. Clones are the same.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<Told>);

#[derive(Debug, Default)]
struct Told {
    late: AtomicBool,
    stopped: AtomicBool,
}

impl Stop {
    /// From now on nobody waits.
    pub fn stop(&self) {
        self.0.stopped.store(true, Ordering::Relaxed);
    }

    /// True when nobody waits.
    pub fn is_stopped(&self) -> bool {
        self.0.stopped.load(Ordering::Relaxed)
    }

    /// What there is by now is to be told.
    pub fn hurry(&self) {
        self.0.late.store(true, Ordering::Relaxed);
    }

    /// True when it has taken too long.
    pub fn is_late(&self) -> bool {
        self.0.late.load(Ordering::Relaxed)
    }
}

/// For controllers that are given none.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoSimulator;

impl Simulator for NoSimulator {
    fn simulate(&self, _: &Scenario) -> Result<Simulated, Problem> {
        Err(Problem::unavailable(
            "no-simulator",
            "this controller was built without a simulation",
        ))
    }
}
