//! Messages of a data connection: the out-port end dials the control socket of the in-port's manager.
//!
//! [`DataHello`] and [`DataReply`] are JSON frames. The out-port end names the transport that it wants; the in-port end
//! says that it is taken, both make their end of it, over this connection or, with TCP, at the [`Meeting`]; and the in-port
//! end says with a second [`DataReply`] that it is ready. Then samples follow as the transport has them (`rts-transport`),
//! with numbers from 1 on in each connection, and the time of writing in nanoseconds of the monotonic clock. A good-bye
//! ends a connection that is ended in order (disconnected, unbound, deleted, shut down). An end without it is a loss.
//!
//! A connector whose `dataport.dataflow_type` is `pull` has a reader that fetches: it asks, and gets one sample for it, or
//! one with the number 0 and no payload when there is none.
//!
//! A manager of version 1 names no transport in its [`DataHello`] and none in its [`DataReply`], of which there is one only.
//! Then these frames follow on the Unix socket: u32 length in network order, counting what follows; u64 sequence number in
//! network order; the payload. Nothing is ever fetched.
//!
//! It says no good-bye either: when its connection ends, nothing tells an order from a process that was killed; both are
//! the end of the stream.
//! Its peer takes it for lost, since a motor must rather stop too often than too seldom. Whoever orders a disconnection,
//! deletion or shutdown at a manager of version 1 (its [`Hello::version`](crate::control::Hello::version)), and wants
//! its peers to go on, closes the connection from their side first, which is no loss to either: `Unbind` where the
//! peer has the in-port, `Disconnect` where it has the out-port.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

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
    /// Encoding of the payload: `cdr-le`, and `cdr-be` since version 2.
    pub encoding: String,
    /// Connector properties: the in-port end buffers by them. Since version 2.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub properties: BTreeMap<String, String>,
    /// The transport that it wants (`shm`, `uds`, `tcp`). Since version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transport: Option<String>,
    /// The boot id of the machine, whose processes share a clock. Since version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clock: Option<String>,
}

/// Answer to [`DataHello`]. After an error the connection is closed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct DataReply {
    /// Outcome.
    pub result: Result<(), crate::control::Failure>,
    /// The transport that is taken. Since version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transport: Option<String>,
    /// Where to connect, with TCP. Since version 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub meeting: Option<Meeting>,
}

impl Default for DataReply {
    /// A yes that says no more.
    fn default() -> Self {
        Self {
            result: Ok(()),
            transport: None,
            meeting: None,
        }
    }
}

/// Where an in-port end waits for one connection.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Meeting {
    /// IP address and port.
    pub address: String,
    /// What to say first, as bytes: nobody else knows it.
    pub word: String,
}
