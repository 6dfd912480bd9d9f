//! Messages of a data connection: the out-port end dials the control socket of the in-port's manager.
//!
//! After [`DataHello`] and [`DataReply`] (JSON frames), samples follow: u32 length in network order, counting what
//! follows; u64 sequence number in network order, from 1 with each connection; the payload in the agreed encoding. The
//! in-port end sends nothing more: what was read is in its manager's inventory.

use serde::{Deserialize, Serialize};

/// Largest payload of a sample in bytes.
pub const MAX_SAMPLE: usize = 64 * 1024 * 1024;

/// First frame of a data connection.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct DataHello {
    /// Protocol version of the sender.
    pub version: u32,
    /// Connector name.
    pub connector: String,
    /// Source as `Instance.port`.
    pub source: String,
    /// Instance with the in-port.
    pub instance: String,
    /// In-port.
    pub port: String,
    /// Incarnation that the instance must have.
    pub incarnation: String,
    /// IDL repository id of the samples.
    pub data_type: String,
    /// Encoding of the payload (`cdr-le`).
    pub encoding: String,
}

/// Answer to [`DataHello`]. After an error the connection is closed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct DataReply {
    /// Outcome.
    pub result: Result<(), crate::control::Failure>,
}
