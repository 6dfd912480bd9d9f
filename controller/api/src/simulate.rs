//! What would happen to a system under faults: the request and the answer of `POST /v1/systems/{name}/simulate`.

use rts_plan::plan::{Plan, StepId};
use rts_schemas::system::SystemSpec;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::requests::{ApplyRequest, Expect};

/// Seed of a simulation when none is given.
pub const DEFAULT_SEED: u64 = 1;
/// Seconds of simulated time when nothing is said.
pub const DEFAULT_LIMIT: u64 = 300;
/// Most seconds of simulated time.
pub const MAX_LIMIT: u64 = 3600;

/// Applies a system in a simulation of the cluster, and lets faults come.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct SimulateRequest {
    /// What is wanted. Its name must be the one in the path.
    pub spec: SystemSpec,
    /// As [`ApplyRequest::replace`].
    #[serde(default)]
    pub replace: bool,
    /// As [`ApplyRequest::targets`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub targets: Vec<String>,
    /// Faults in words (`agent node2 crashes at step 5 for 3s`). What is said: `agent NODE drops|crashes`, `controller
    /// crashes`, `HOST cannot reach HOST`, `node NODE reboots`, `manager NAME dies|hangs [on NODE]`, `managers on NODE fail
    /// to start`, `module TYPE fails [on NODE]`, `component NAME misbehaves HOW`, `network loses P% doubles P% delays TIME`,
    /// `disk of HOST fails|is slow TIME`, `clock of HOST jumps TIME`; then `at step N` or `at TIME`, and `for TIME`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<String>,
    /// All chance follows from it: with the same one the same happens. [`DEFAULT_SEED`] when there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Seconds of simulated time after which it ends in any case; at most [`MAX_LIMIT`], [`DEFAULT_LIMIT`] when there are
    /// none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_seconds: Option<u64>,
}

impl SimulateRequest {
    /// A simulation of an apply without faults.
    pub fn of(apply: ApplyRequest) -> Self {
        Self {
            spec: apply.spec,
            replace: apply.replace,
            targets: apply.targets,
            faults: Vec::new(),
            seed: None,
            limit_seconds: None,
        }
    }

    /// What is applied.
    pub fn apply(&self) -> ApplyRequest {
        ApplyRequest {
            spec: self.spec.clone(),
            replace: self.replace,
            targets: self.targets.clone(),
            expect: Expect::default(),
        }
    }
}

/// What happened in a simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Simulated {
    /// The seed: with it, all of this happens again.
    pub seed: u64,
    /// The faults as they were understood, with their times.
    pub faults: Vec<String>,
    /// Where the simulation begins otherwise than the cluster is now, and what it does not show.
    pub notes: Vec<String>,
    /// The plan that the apply led to; step numbers are of it.
    pub plan: Plan,
    /// What happened, in order.
    pub events: Vec<SimulatedEvent>,
    /// Later events that were left out.
    #[serde(default)]
    pub omitted: u64,
    /// Faults that never struck: their step or their time did not come, or there was nothing for them to strike.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub never_came: Vec<String>,
    /// How it ended.
    pub end: SimulatedEnd,
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct SimulatedEvent {
    /// Milliseconds since the apply.
    pub at_ms: u64,
    /// `component/Sine0`, `manager/hello.main`, `node/local`, `controller`, `network`.
    pub object: String,
    /// One word: `Fault`, `StepStarted`, `StepSucceeded`, `StepFailed`, `ProcessStarted`, `ProcessEnded`, `State`, or the
    /// reason of an event of the controller (`NodeUnknown`).
    pub reason: String,
    /// In words.
    pub message: String,
    /// Number of the plan's step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<StepId>,
}

/// How a simulation ended.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct SimulatedEnd {
    /// Every system is as it is desired, and healthy.
    pub converged: bool,
    /// Milliseconds from the apply until it was so and stayed so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub converged_ms: Option<u64>,
    /// Milliseconds that were simulated after the apply.
    pub simulated_ms: u64,
    /// Each system.
    pub systems: Vec<SimulatedSystem>,
    /// Each component.
    pub components: Vec<SimulatedComponent>,
    /// What is left undone, and why.
    pub undone: Vec<Undone>,
}

/// A system at the end of a simulation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct SimulatedSystem {
    /// Name.
    pub name: String,
    /// Observed equals desired.
    pub synced: bool,
    /// Everything that must run runs.
    pub healthy: bool,
}

/// A component at the end of a simulation.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct SimulatedComponent {
    /// Instance name.
    pub name: String,
    /// System.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub system: Option<String>,
    /// Node.
    pub node: String,
    /// Manager.
    pub manager: String,
    /// `Created|Inactive|Active|Error|Unknown`.
    pub state: String,
    /// Times that it was made again since the apply.
    pub restarts: u32,
}

/// Something that is not as it should be.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Undone {
    /// Which (`component/Printer0`).
    pub object: String,
    /// Why.
    pub reason: String,
}
