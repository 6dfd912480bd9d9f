//! Why something was refused.

use serde::{Deserialize, Serialize};

/// A refusal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "camelCase")]
#[error("{message}")]
pub struct Failure {
    /// What kind.
    pub code: FailureCode,
    /// For people: what, why, and how to mend it.
    pub message: String,
}

/// Kind of a refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum FailureCode {
    /// No such instance, module, port.
    NotFound,
    /// It is there already and differs, or is in use.
    Conflict,
    /// The request makes no sense (unknown parameter, type mismatch).
    Invalid,
    /// dlopen, the descriptor or the ABI version failed.
    LoadFailed,
    /// A callback returned an error or panicked.
    ComponentFailed,
    /// A callback did not return in time.
    Deadline,
    /// The other end of a connector refused or is gone.
    PeerFailed,
    /// The manager itself failed.
    Internal,
}
