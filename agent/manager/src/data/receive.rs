//! The in-port end of a connector from another process.

use std::sync::Arc;

use rts_schemas::cdr::Endian;
use rts_schemas::connector::Dataflow;
use rts_transport::{Ended, Receiver};

use super::in_port::InPort;
use super::order::Turn;
use super::source::Source;

/// What both ends have agreed on.
#[derive(Debug, Default)]
pub struct Agreed {
    /// Both are on one machine. Without a common clock, the time of a sample says nothing here.
    pub has_common_clock: bool,
    /// The most significant byte comes first.
    pub turn: Option<Turn>,
}

/// Moves samples into an in-port until the connection ends; says why it did.
pub fn receive(
    receiver: &mut dyn Receiver,
    port: &InPort,
    source: &Arc<Source>,
    agreed: &Agreed,
) -> Ended {
    let handle = receiver.handle();
    let fetches = source.settings().dataflow == Dataflow::Pull;
    receiver.hand_on(&mut |mut sample| {
        if fetches && sample.sequence == 0 {
            port.answered(source);
            return true;
        }
        if !agreed.has_common_clock {
            sample.time = 0;
        }
        if let Some(turn) = &agreed.turn {
            match turn.turned(sample, Endian::Big) {
                Some(turned) => sample = turned,
                None => {
                    source.count_drop();
                    return source.is_open();
                }
            }
        }
        port.take_in(source, sample, || !handle.has_gone());
        source.is_open()
    })
}
