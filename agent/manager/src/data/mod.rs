//! Samples on their way: out-port → connector → (transport) → in-port.
//!
//! A component's thread only takes locks that are held for a push or a pop, so no component can stop another here. It
//! waits for another one only where the connector's properties say so, for as long as they say, and holds no lock then.

pub mod accept;
pub mod binding;
mod budget;
mod buffer;
pub mod choose;
#[cfg(test)]
mod conformance;
pub mod connector;
pub mod dial;
pub mod direct;
#[cfg(test)]
mod ends;
pub mod in_port;
mod lane;
mod latency;
mod meet;
mod monitor;
mod order;
pub mod out_port;
pub mod outbox;
pub mod publisher;
pub mod rate;
pub mod receive;
pub mod sample;
pub mod sender;
pub mod source;
pub mod tap;

use std::collections::BTreeMap;

use rts_manager_api::control::Failure;
use rts_schemas::connector::{ConnectorSettings, read};
use rts_transport::Sample;
pub use rts_transport::{Ended, Parting, Payload};

use crate::failure::invalid;

/// Names of the encodings, as the protocol shows them.
const LITTLE_ENDIAN: &str = "cdr-le";
const BIG_ENDIAN: &str = "cdr-be";

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

/// What an end means when the other side speaks version 1 of the protocol.
fn of_version_1(ended: Ended) -> Ended {
    match ended {
        Ended::Lost(reason) => Ended::Lost(format!(
            "{reason}; the other end speaks version 1 of the protocol: it cannot say whether that was ordered"
        )),
        ended => ended,
    }
}
