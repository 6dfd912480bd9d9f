//! The in-port end of a connector from another process.

use std::sync::Arc;
use std::time::Instant;

use rts_schemas::connector::Dataflow;
use rts_transport::{Ended, Receiver};

use super::in_port::InPort;
use super::source::Source;

/// Moves samples into an in-port until the connection ends; says why it did. Without a common clock, the time of a
/// sample says nothing here.
pub fn receive(
    receiver: &mut dyn Receiver,
    port: &InPort,
    source: &Arc<Source>,
    has_common_clock: bool,
) -> Ended {
    let handle = receiver.handle();
    let fetches = source.settings().dataflow == Dataflow::Pull;
    receiver.hand_on(&mut |mut sample| {
        if fetches && sample.sequence == 0 {
            port.answered(source);
            return true;
        }
        if !has_common_clock {
            sample.time = 0;
        }
        if let Err(sample) = port.offer(source, sample) {
            port.wait(source, sample, Instant::now(), || !handle.has_gone());
        }
        source.is_open()
    })
}
