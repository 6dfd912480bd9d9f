//! What an execution context has of its machine so that it keeps its time.

use serde::{Deserialize, Serialize};

/// What it is to have.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct RealtimeRequest {
    /// Processors that it runs on, as cpuset(7) lists them (`2-3,5`); none leaves them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpus: Option<String>,
    /// SCHED_FIFO priority, 1 to 99; none leaves the usual scheduling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub priority: Option<u8>,
    /// The memory of its process is locked.
    #[serde(default)]
    pub lock_memory: bool,
    /// The component is refused when not all of it is permitted. Otherwise it runs without, and an event says so.
    #[serde(default)]
    pub required: bool,
}

/// What it has.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct RealtimeInfo {
    /// As it was asked for.
    pub asked: RealtimeRequest,
    /// `SCHED_FIFO`, `SCHED_OTHER` or another policy of sched(7).
    pub scheduler: String,
    /// Its priority; 0 without SCHED_FIFO.
    pub priority: u8,
    /// Processors that it may run on, as cpuset(7) lists them.
    pub cpus: String,
    /// The memory of its process is locked.
    pub memory_locked: bool,
    /// What was asked for and is not permitted, and why.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub denied: Vec<String>,
}
