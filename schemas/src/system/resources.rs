//! What a component may use of its node.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What a component may use of its node.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Resources {
    /// Processors that its execution context runs on, as cpuset(7) lists them: `2-3,5` (`rtsctl.resources.cpus`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpus: Option<String>,
    /// SCHED_FIFO priority of its execution context, 1 to 99 (`rtsctl.resources.realtimePriority`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub realtime_priority: Option<u8>,
    /// Whether the memory of its process is locked (`rtsctl.resources.lockMemory`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lock_memory: Option<bool>,
    /// Whether it is refused where its node does not permit these; true when nothing is said
    /// (`rtsctl.resources.required`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub required: Option<bool>,
    /// Bytes that its process may have (`rtsctl.resources.memoryLimit`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory_limit_bytes: Option<u64>,
}

impl Resources {
    /// Left out when written, so that a program from before this field was known can read the rest.
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// What of it its execution context is to have; none when nothing is asked for.
    pub fn realtime(&self) -> Option<Realtime> {
        let asked = Realtime {
            cpus: self.cpus.clone(),
            priority: self.realtime_priority,
            lock_memory: self.lock_memory.unwrap_or_default(),
            required: self.required.unwrap_or(true),
        };
        let any = asked.cpus.is_some() || asked.priority.is_some() || asked.lock_memory;
        any.then_some(asked)
    }
}

/// What an execution context is to have of its node so that it keeps its time.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Realtime {
    /// Processors that it runs on, as cpuset(7) lists them; none for all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpus: Option<String>,
    /// SCHED_FIFO priority, 1 to 99; none for the usual scheduling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub priority: Option<u8>,
    /// The memory of its process is locked.
    #[serde(default)]
    pub lock_memory: bool,
    /// Its component is not made where its node does not permit all of it.
    #[serde(default)]
    pub required: bool,
}
