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
