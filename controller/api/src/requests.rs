//! Bodies of requests and their answers that are not objects.

use rts_agent_api::messages::LedgerFence;
use rts_plan::plan::Plan;
use rts_schemas::system::SystemSpec;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::objects::System;

/// Applies a system, or asks what an apply would do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ApplyRequest {
    /// What is wanted. Its name must be the one in the path.
    pub spec: SystemSpec,
    /// Take the place of a stored system of another identity.
    #[serde(default)]
    pub replace: bool,
    /// Only these of its components and connectors (`component/Sine0`, `connector/…`, or a bare name), and what they
    /// cannot be without; everything else stays as it is stored. Empty for all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub targets: Vec<String>,
    /// What must be true for it to be stored.
    #[serde(default, skip_serializing_if = "Expect::is_empty")]
    pub expect: Expect,
}

impl ApplyRequest {
    /// All of a system, unconditionally.
    pub fn of(spec: SystemSpec) -> Self {
        Self {
            spec,
            replace: false,
            targets: Vec::new(),
            expect: Expect::default(),
        }
    }
}

/// What the one who applies has seen before, and relies on. All of it is checked together with the change.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Expect {
    /// [`PlanResult::index`]: the stored system has not been changed since. Else 409 `stale-plan`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub index: Option<u64>,
    /// [`PlanResult::digest`]: the plan would be the very same now. Else 409 `stale-plan`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
    /// No process restarts and no component is made again. Else 409 `would-restart`.
    #[serde(default)]
    pub no_restart: bool,
    /// At most so many of its components are stand-ins. Else 422 `too-many-stand-ins`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_stand_ins: Option<u32>,
}

impl Expect {
    /// True when nothing is expected.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Answer to an apply.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct ApplyResult {
    /// The system as stored.
    pub system: System,
    /// False when the same spec was stored already.
    pub changed: bool,
    /// The plan that starts now; empty when nothing is to be done.
    pub plan: Plan,
    /// Number of the stored system's last change, as [`PlanResult::index`]: the next one may expect it.
    #[serde(default)]
    pub index: u64,
}

/// What an apply would do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct PlanResult {
    /// The plan.
    pub plan: Plan,
    /// Which host went to which node, and other remarks.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Number of the stored system's last change, durable; 0 while there is none. Another change gives another number,
    /// also after a teardown.
    #[serde(default)]
    pub index: u64,
    /// [`Plan::digest`](rts_plan::plan::Plan::digest) of what is done to this system.
    #[serde(default)]
    pub digest: String,
}

/// A running system, as what an apply would take.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Exported {
    /// The stored system with what was changed by hand.
    pub spec: SystemSpec,
    /// What could not be taken over, and why.
    #[serde(default)]
    pub notes: Vec<String>,
}

/// Replaces what a node runs for another controller by this controller's set.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct TakeOver {
    /// The ledger that may be replaced, as the node's status shows it: when it is another by now, nothing happens.
    pub confirm: LedgerFence,
}

/// A node is this controller's.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct NodeClaimed {
    /// Its name.
    pub node: String,
    /// False when it was this controller's already.
    pub changed: bool,
    /// The ledger that was replaced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ledger: Option<LedgerFence>,
    /// Systems that were adopted.
    #[serde(default)]
    pub systems: Vec<String>,
}
