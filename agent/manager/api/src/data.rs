//! Messages of a data connection: the out-port end dials the control socket of the in-port's manager.
//!
//! After [`DataHello`] and [`DataReply`] (JSON frames), samples follow: u32 length in network order, counting what
//! follows; u64 sequence number in network order, from 1 with each connection; the payload in the agreed encoding. The
//! in-port end sends no more than its good-bye: what was read is in its manager's inventory.
//!
//! A connection that is ended in order (disconnected, unbound, deleted, shut down) ends with a good-bye, after which
//! its sender closes it: [`GOOD_BYE`] from the out-port end when [`DataReply::good_bye`] says that it is understood, one
//! byte from the in-port end. An end without it is a loss.
//!
//! A connector whose `dataport.dataflow_type` is `pull` has a reader that fetches: the in-port end sends [`FETCH_FIRST`] or
//! [`FETCH_MORE`], and gets one sample, or [`EMPTY`], for it. [`DataReply::pull`] says that it can; an out-port end does not
//! connect a puller to one that cannot. When both sides say `stamped`, the time of writing follows the sequence number: a
//! u64 in network order, nanoseconds of the monotonic clock that all processes of a machine share.
//!
//! A manager of version 1 says no good-bye. [`DataHello::good_bye`] and [`DataReply::good_bye`] tell the other end so,
//! but when its connection ends, nothing tells an order from a process that was killed: both are the end of the stream.
//! Its peer takes it for lost, since a motor must rather stop too often than too seldom. Whoever orders a disconnection,
//! deletion or shutdown at a manager of version 1 (its [`Hello::version`](crate::control::Hello::version)), and wants
//! its peers to go on, closes the connection from their side first, which is no loss to either: `Unbind` where the
//! peer has the in-port, `Disconnect` where it has the out-port.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Largest payload of a sample in bytes.
pub const MAX_SAMPLE: usize = 64 * 1024 * 1024;

/// What an out-port end sends last: a length that no sample has.
pub const GOOD_BYE: [u8; 4] = [0; 4];

/// Instead of a sample, to a reader that fetches: there is none. A length that no sample has.
pub const EMPTY: [u8; 4] = [0, 0, 0, 1];

/// Asks for a sample; the policies for an empty buffer hold, for it is the first read of a callback.
pub const FETCH_FIRST: u8 = 1;
/// Asks for a sample, if there is one.
pub const FETCH_MORE: u8 = 2;

/// First frame of a data connection.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct DataHello {
    /// Oldest protocol version in which this message can be understood.
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
    /// The out-port end says [`GOOD_BYE`] before an orderly end. Since version 2.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub good_bye: bool,
    /// Connector properties: the in-port end buffers by them. Since version 2.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub properties: BTreeMap<String, String>,
    /// The out-port end can send the time of writing. Since version 2.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stamped: bool,
}

/// Answer to [`DataHello`]. After an error the connection is closed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct DataReply {
    /// Outcome.
    pub result: Result<(), crate::control::Failure>,
    /// The in-port end understands [`GOOD_BYE`], and says its own. Since version 2.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub good_bye: bool,
    /// The in-port end can fetch. Since version 2.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub pull: bool,
    /// The in-port end expects the time of writing. Since version 2.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stamped: bool,
}
