//! Samples on their way: out-port → connector → (socket) → in-port.
//!
//! A component's thread only takes locks that are held for a push or a pop, so no component can stop another here. It
//! waits for another one only where the connector's properties say so, for as long as they say, and holds no lock then.

pub mod accept;
pub mod binding;
mod budget;
mod buffer;
#[cfg(test)]
mod conformance;
pub mod connector;
pub mod dial;
pub mod direct;
pub mod in_port;
mod lane;
mod latency;
pub mod out_port;
pub mod outbox;
pub mod publisher;
mod rate;
pub mod receive;
pub mod sample;
pub mod sender;
pub mod source;
pub mod tap;
mod wire;

use std::collections::BTreeMap;

use rts_manager_api::control::Failure;
use rts_schemas::connector::{ConnectorSettings, read};

use crate::failure::invalid;

/// How a connection ends at this side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parting {
    /// By an order: the other end is told, and nothing is lost to it.
    GoodBye,
    /// By itself: to the other end it is a loss.
    Loss,
}

/// Why a connection came to its end.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// This side closed it.
    Here,
    /// The other side said good-bye.
    GoodBye,
    /// The other side is lost: what was seen of it.
    Lost(String),
}

impl Ended {
    /// How this side closes it for that.
    pub fn parting(&self) -> Parting {
        match self {
            Self::Here | Self::GoodBye => Parting::GoodBye,
            Self::Lost(_) => Parting::Loss,
        }
    }
}

/// Seen of the end of a connection whose other side does not know good-byes.
const SILENT_END: &str = "the other end closed the connection, and speaks version 1 of the protocol: it cannot say \
                          whether that was ordered";

/// The payload of a sample, shared by all connectors that it goes to.
pub type Payload = bytes::Bytes;

/// Name of the only encoding of this version, as the protocol shows it.
pub const ENCODING: &str = "cdr-le";

/// Bytes that a buffer keeps, whatever the number of its samples; one sample always fits.
pub const QUEUE_BYTES: usize = 256 * 1024 * 1024;

/// What a connector's properties say; refused when some cannot be used.
pub fn settings(properties: &BTreeMap<String, String>) -> Result<ConnectorSettings, Failure> {
    read(properties).map_err(|faults| {
        let faults: Vec<_> = faults
            .iter()
            .map(|fault| format!("{fault}; {}", fault.help))
            .collect();
        invalid(faults.join("; "))
    })
}
