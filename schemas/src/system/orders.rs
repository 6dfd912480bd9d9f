//! The orders that a profile writes down.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The seven orders of an RTS Profile; each is a list of conditions, empty when the profile is silent.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Orders {
    /// `rts:StartUp`.
    #[serde(default)]
    pub start_up: Vec<Condition>,
    /// `rts:ShutDown`.
    #[serde(default)]
    pub shut_down: Vec<Condition>,
    /// `rts:Activation`.
    #[serde(default)]
    pub activation: Vec<Condition>,
    /// `rts:Deactivation`.
    #[serde(default)]
    pub deactivation: Vec<Condition>,
    /// `rts:Resetting`.
    #[serde(default)]
    pub resetting: Vec<Condition>,
    /// `rts:Initializing`.
    #[serde(default)]
    pub initializing: Vec<Condition>,
    /// `rts:Finalizing`.
    #[serde(default)]
    pub finalizing: Vec<Condition>,
}

impl Orders {
    /// All of them with their names in JSON.
    pub fn by_name(&self) -> [(&'static str, &[Condition]); 7] {
        let Orders {
            start_up,
            shut_down,
            activation,
            deactivation,
            resetting,
            initializing,
            finalizing,
        } = self;
        [
            ("startUp", start_up),
            ("shutDown", shut_down),
            ("activation", activation),
            ("deactivation", deactivation),
            ("resetting", resetting),
            ("initializing", initializing),
            ("finalizing", finalizing),
        ]
    }
}

/// `sequence` of a condition that has no place in the sequence: it neither waits for lower numbers nor do higher ones wait
/// for it. A number that tools with 32 bits still read, as the last of all.
pub const NO_SEQUENCE: u32 = i32::MAX as u32;

/// One `rts:targets` entry. Several conditions of one component are ANDed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Condition {
    /// Instance name of the component that waits.
    pub target: String,
    /// `sequence`: lower numbers go first; gaps are allowed. [`NO_SEQUENCE`] for none.
    pub sequence: u32,
    /// What it waits for besides its place in the sequence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wait: Option<WaitFor>,
}

/// The choice inside `rts:targets`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(
    tag = "kind",
    rename_all = "camelCase",
    rename_all_fields = "camelCase",
    deny_unknown_fields
)]
pub enum WaitFor {
    /// Sleep, then act (`rts:WaitTime`).
    Time {
        /// Milliseconds.
        milliseconds: u32,
    },
    /// Wait for other components (`rts:Preceding`).
    Preceding {
        /// SYNC waits for the state, the others for the request.
        timing: SendingTiming,
        /// Milliseconds; 0 means "no time-out of its own".
        // Said here too: the schema of the API does not know `rename_all_fields`.
        #[serde(rename = "timeoutMs")]
        timeout_ms: u32,
        /// Instance names.
        components: Vec<String>,
    },
}

/// `rts:sendingTiming`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub enum SendingTiming {
    /// After the others have reached the state.
    Sync,
    /// After the others' request was sent (`ASYNC`, `NO_SYNC`).
    Async,
}
