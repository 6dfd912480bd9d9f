//! The out-port end of a connector to another process: the writer sends what the transport takes at once; a thread sends
//! the rest, answers a reader that fetches, and sees the end of the connection.

use std::io;
use std::sync::{Mutex, TryLockError};
use std::time::{Duration, Instant};

use rts_schemas::cdr::Endian;
use rts_schemas::connector::{ConnectorSettings, Dataflow, Subscription};
use rts_transport::{Handle, Kind, Question, Refused};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use super::budget::Share;
use super::order::Turn;
use super::outbox::{Fetched, Outbox};
use super::sample::Sample;
use super::{Ended, Parting, Payload, of_version_1};
use crate::sync::lock;

/// No wait for room is longer without a look at what else has happened.
const LOOK: Duration = Duration::from_millis(50);

/// A connection that is closed in order has this long to take a sample that waits for room.
const PARTING: Duration = Duration::from_millis(250);

/// The sending end of a transport, whose other end has agreed.
#[derive(Debug)]
pub struct Agreed {
    /// What samples are pushed into.
    pub transport: Box<dyn rts_transport::Sender>,
    /// What it is.
    pub kind: Kind,
    /// The other end speaks version 1 of the protocol.
    pub is_version_1: bool,
    /// Memory that it takes here.
    pub ring: Option<Share>,
    /// The other end takes the most significant byte first.
    pub turn: Option<Turn>,
}

/// An outbox and the transport that it is emptied into.
#[derive(Debug)]
pub struct Sender {
    /// What waits.
    pub outbox: Outbox,
    /// The transport in use.
    pub kind: Kind,
    wire: Mutex<Wire>,
    handle: Handle,
    is_version_1: bool,
    /// The reader fetches.
    pulled: bool,
    /// The writer sends in its own call.
    at_once: bool,
    _ring: Option<Share>,
    turn: Option<Turn>,
}

#[derive(Debug)]
struct Wire {
    transport: Box<dyn rts_transport::Sender>,
    /// Taken from the outbox, and waits for room.
    held: Option<Sample>,
}

/// A reader that waits for a sample until then.
type Asked = Option<Instant>;

/// The answer to a reader that fetches, when there is no sample: no sample has this number.
fn nothing() -> Sample {
    Sample {
        sequence: 0,
        time: 0,
        payload: Payload::new(),
    }
}

impl Sender {
    /// For a transport whose other end has agreed.
    pub fn new(agreed: Agreed, settings: &ConnectorSettings) -> io::Result<Self> {
        Ok(Self {
            outbox: Outbox::new(settings)?,
            kind: agreed.kind,
            handle: agreed.transport.handle(),
            wire: Mutex::new(Wire {
                transport: agreed.transport,
                held: None,
            }),
            is_version_1: agreed.is_version_1,
            pulled: settings.dataflow == Dataflow::Pull,
            at_once: settings.dataflow == Dataflow::Push
                && settings.subscription == Subscription::Flush,
            _ring: agreed.ring,
            turn: agreed.turn,
        })
    }

    /// Takes a sample, or gives it back when there is no room; says how many older ones went for it. Never blocks.
    pub fn offer(&self, sample: Sample) -> (Result<(), Sample>, u64) {
        let sample = match &self.turn {
            None => Some(sample),
            Some(turn) => turn.turned(sample, Endian::Little),
        };
        // What is no value of its type has no other order; its writer has made a mistake.
        let Some(sample) = sample else {
            return (Ok(()), 1);
        };
        match self.send_now(sample) {
            None => (Ok(()), 0),
            Some(sample) => self.outbox.offer(sample),
        }
    }

    /// Sends a sample in the caller's thread when nothing is before it; gives it back otherwise.
    fn send_now(&self, sample: Sample) -> Option<Sample> {
        if !self.at_once {
            return Some(sample);
        }
        let mut wire = match self.wire.try_lock() {
            Ok(wire) => wire,
            Err(TryLockError::Poisoned(wire)) => wire.into_inner(),
            // The thread is sending.
            Err(TryLockError::WouldBlock) => return Some(sample),
        };
        if wire.held.is_some() || !self.outbox.is_empty() || self.outbox.closed().is_some() {
            return Some(sample);
        }
        match wire.transport.push(sample) {
            Ok(()) | Err(Refused::TooLarge(_)) => None,
            Err(Refused::Full(sample)) => Some(sample),
            Err(Refused::Ended(_)) => {
                // The thread meets the same end, and tells it.
                self.outbox.wake();
                None
            }
        }
    }

    /// Ends the connection and its thread. Never blocks: that thread says the good-bye.
    pub fn close(&self, parting: Parting) {
        self.outbox.close(parting);
        if parting == Parting::Loss {
            self.handle.close(parting);
        }
    }

    /// Sends until the connection ends; says why it did. For a thread of its own.
    pub fn send(&self) -> Ended {
        let ended = self.send_all();
        self.handle.close(ended.parting());
        match self.is_version_1 {
            true => of_version_1(ended),
            false => ended,
        }
    }

    fn send_all(&self) -> Ended {
        let mut tick = self.outbox.period().map(|period| Instant::now() + period);
        let mut asked = Asked::None;
        loop {
            if let Some(parting) = self.outbox.closed() {
                return self.part(parting);
            }
            let sent = match self.pump() {
                Ok(sent) => sent,
                Err(ended) => return ended,
            };
            match self.hear(&mut asked) {
                Ok(true) => continue,
                Ok(false) => {}
                Err(ended) => return ended,
            }
            if sent && let Err(error) = self.sleep(tick, asked) {
                return Ended::Lost(error.to_string());
            }
            if let (Some(at), Some(period)) = (tick, self.outbox.period())
                && Instant::now() >= at
            {
                self.outbox.tick();
                // A tick that was missed is not made up for.
                tick = Some((at + period).max(Instant::now()));
            }
        }
    }

    /// Ends the connection as it was ordered.
    fn part(&self, parting: Parting) -> Ended {
        let Wire { transport, held } = &mut *lock(&self.wire);
        if parting == Parting::GoodBye
            && let Some(sample) = held.take()
        {
            // What finds no room in time is lost with what waits behind it.
            let _ = transport.push_within(sample, PARTING);
        }
        transport.close(parting);
        transport.linger();
        Ended::Here
    }

    /// Sends what may leave; false when there was no room for all of it.
    fn pump(&self) -> Result<bool, Ended> {
        let mut wire = lock(&self.wire);
        let next = || match self.pulled || self.outbox.closed().is_some() {
            true => None,
            false => self.outbox.next(),
        };
        loop {
            let Some(sample) = wire.held.take().or_else(next) else {
                return Ok(true);
            };
            match wire.transport.push_within(sample, LOOK) {
                Ok(()) | Err(Refused::TooLarge(_)) => {}
                Err(Refused::Full(sample)) => {
                    wire.held = Some(sample);
                    return Ok(false);
                }
                Err(Refused::Ended(ended)) => return Err(ended),
            }
        }
    }

    /// Waits until there is something to do.
    fn sleep(&self, tick: Option<Instant>, asked: Asked) -> io::Result<()> {
        let next = tick.into_iter().chain(asked).min();
        let left = next.map(|at| at.saturating_duration_since(Instant::now()));
        let timeout = left.and_then(|left| Timespec::try_from(left).ok());
        let filled = self.outbox.filled();
        let watched = self.handle.watched().unwrap_or(filled);
        let mut fds = [
            PollFd::from_borrowed_fd(watched, PollFlags::IN),
            PollFd::from_borrowed_fd(filled, PollFlags::IN),
        ];
        match poll(&mut fds, timeout.as_ref()) {
            Ok(_) | Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        if !fds[1].revents().is_empty() {
            self.outbox.awake();
        }
        Ok(())
    }

    /// Looks for the end, and at what a reader wants that fetches; true when there is an answer to send.
    fn hear(&self, asked: &mut Asked) -> Result<bool, Ended> {
        let mut wire = lock(&self.wire);
        if let Some(ended) = wire.transport.ended() {
            return Err(ended);
        }
        // One answer at a time, whatever the other end asks for.
        if !self.pulled || wire.held.is_some() {
            return Ok(false);
        }
        let question = match asked {
            Some(_) => Some(Question::First),
            None => wire.transport.asked(),
        };
        let Some(question) = question else {
            return Ok(false);
        };
        wire.held = match self.outbox.fetch(question == Question::First) {
            Fetched::Sample(sample) => Some(sample),
            Fetched::Nothing => Some(nothing()),
            Fetched::Wait(time) => {
                let until = *asked.get_or_insert_with(|| Instant::now() + time);
                (Instant::now() >= until).then(nothing)
            }
        };
        if wire.held.is_some() {
            *asked = None;
        }
        Ok(wire.held.is_some())
    }
}

#[cfg(test)]
mod tests;
