//! Writing to an in-port.

use std::io::{self, Read};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rts_manager_api::frame::FrameError;
use rts_manager_api::net::Timed;
use rts_manager_api::tap::{TapEnd, TapSample};
use rts_schemas::connector::{BufferSettings, ConnectorSettings, EmptyPolicy, FullPolicy};
use rustix::event::PollFlags;

use super::{Client, LOOK};
use crate::data::in_port::InPort;
use crate::data::sample::{Sample, now};
use crate::data::source::Source;
use crate::data::{Parting, Payload};
use crate::failure::invalid;

/// Longest time for the rest of a sample that has begun to come.
const REST: Duration = Duration::from_secs(30);
/// Longest wait for room, and for the last samples to be read.
const LONGEST: Duration = Duration::from_secs(600);
/// Between two looks whether the last samples were read.
const READ: Duration = Duration::from_millis(5);

/// Writes what the client sends until it says that this was all, or goes.
pub(super) fn inject(
    mut client: Client<'_>,
    port: &Arc<InPort>,
    wait: Duration,
    linger: Duration,
) -> Result<(), FrameError> {
    let source = Arc::new(Source::new(None, settings(wait), None));
    port.open(&source);
    let written = client
        .accept(port.data_type.clone())
        .and_then(|()| Ok(write(&client, port, &source, linger)?));
    port.close(&source, Parting::GoodBye);
    match written? {
        Some(end) => client.end(&end),
        None => Ok(()),
    }
}

/// As a connector has them: the component neither waits for it nor reads anything of it twice.
fn settings(wait: Duration) -> ConnectorSettings {
    let full = match wait.is_zero() {
        true => FullPolicy::Overwrite,
        false => FullPolicy::Block(wait.min(LONGEST)),
    };
    ConnectorSettings {
        in_buffer: BufferSettings {
            full,
            empty: EmptyPolicy::DoNothing,
            ..BufferSettings::default()
        },
        ..ConnectorSettings::default()
    }
}

/// What became of it; none when the client has gone.
fn write(
    client: &Client<'_>,
    port: &InPort,
    source: &Arc<Source>,
    linger: Duration,
) -> io::Result<Option<TapEnd>> {
    let mut taken = 0;
    let end = |taken, failure| {
        let counts = source.counts();
        TapEnd {
            taken,
            read: counts.received,
            dropped: counts.drops,
            failure,
        }
    };
    loop {
        if let failure @ Some(_) = client.gone() {
            return Ok(Some(end(taken, failure)));
        }
        if client.wait(PollFlags::IN, None, LOOK)?.is_empty() {
            continue;
        }
        let payload = match next(client)? {
            Next::Sample(payload) => payload,
            Next::Gone => return Ok(None),
            Next::End => break,
            Next::Wrong(length) => {
                let failure = invalid(format!("no sample has a length of {length}"));
                return Ok(Some(end(taken, Some(failure))));
            }
        };
        taken += 1;
        let sample = Sample {
            sequence: taken,
            time: now(),
            payload,
        };
        let here = || client.wait(PollFlags::empty(), None, Duration::ZERO);
        let stays = || here().is_ok_and(|events| !events.contains(PollFlags::HUP));
        port.take_in(source, sample, stays);
    }
    let until = Instant::now() + linger.min(LONGEST);
    while Instant::now() < until && client.gone().is_none() {
        let counts = source.counts();
        if counts.received + counts.drops >= taken {
            break;
        }
        if !client.wait(PollFlags::IN, None, READ)?.is_empty() {
            return Ok(None);
        }
    }
    Ok(Some(end(taken, client.gone())))
}

enum Next {
    Sample(Payload),
    /// The client has no more.
    End,
    /// The client went away.
    Gone,
    /// Nonsense.
    Wrong(u32),
}

/// The sample that begins to come.
fn next(client: &Client<'_>) -> io::Result<Next> {
    let mut timed = Timed::new(client.stream, Instant::now() + REST);
    let mut length = [0; 4];
    match timed.read_exact(&mut length) {
        Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => return Ok(Next::Gone),
        read => read?,
    }
    let bytes = match TapSample::announced(length) {
        Ok(Some(bytes)) => bytes,
        Ok(None) => return Ok(Next::End),
        Err(length) => return Ok(Next::Wrong(length)),
    };
    let mut rest = vec![0; bytes];
    timed.read_exact(&mut rest)?;
    let payload = TapSample::split(&rest).map(|(_, payload)| payload.len());
    let head = rest.len() - payload.unwrap_or_default();
    Ok(Next::Sample(Payload::from(rest).slice(head..)))
}
