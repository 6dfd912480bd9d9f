//! What goes over a port: looked at, or written by hand.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// One line of what an out-port writes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(
    tag = "type",
    rename_all = "camelCase",
    rename_all_fields = "camelCase"
)]
pub enum PortEvent {
    /// First line.
    Opened {
        /// Incarnation of the component.
        incarnation: String,
        /// IDL repository id of the samples.
        data_type: String,
    },
    /// A sample.
    Sample {
        /// Time of writing, RFC 3339.
        time: String,
        /// Samples that were missed since the first line, because they were not read fast enough.
        missed: u64,
        /// Bytes of the sample.
        size: u64,
        /// Its bytes (CDR, little endian) in base64; none for one that is too long for a line.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        data: Option<String>,
    },
    /// Last line: there will be no more.
    End {
        /// Why.
        reason: String,
    },
}

/// How samples are written to an in-port by hand.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct InjectQuery {
    /// IDL repository id of the samples, which must be that of the port.
    pub data_type: String,
    /// How long a sample waits for room in the port's buffer before it is dropped; with 0 the oldest goes for it.
    #[serde(default)]
    pub wait_ms: u64,
    /// How long the last samples may wait to be read.
    #[serde(default)]
    pub linger_ms: u64,
}

/// One sample that is written by hand.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct InjectLine {
    /// Its bytes (CDR, little endian) in base64.
    pub data: String,
}

/// What became of samples that were written by hand.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase")]
pub struct Injected {
    /// Samples that came.
    pub taken: u64,
    /// Those of them that the component has read.
    pub read: u64,
    /// Those of them that found no room.
    pub dropped: u64,
    /// Why it ended before all had come.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ended: Option<String>,
}
