//! Deciding on a data connection at its in-port end, and serving it.

use std::io;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rts_host::identity::boot_id;
use rts_manager_api::control::Failure;
use rts_manager_api::data::{DataHello, DataReply};
use rts_manager_api::frame::{self, FrameError};
use rts_manager_api::net::Timed;
use rts_schemas::cdr::Endian;
use rts_transport::{Kind, Receiver, unix};

use super::binding::{Bindings, End};
use super::meet::Place;
use super::order::turn;
use super::receive::{Agreed, receive};
use super::settings;
use super::source::Source;
use super::{BIG_ENDIAN, Ended, LITTLE_ENDIAN, of_version_1};
use crate::failure::{conflict, internal, invalid, not_found};
use crate::log;
use crate::manager::Manager;

/// Time for the replies to leave, and for the other end to make its part of a transport.
const PATIENCE: Duration = Duration::from_secs(2);

/// An end that a source has come to.
struct Opened {
    end: Arc<End>,
    source: Arc<Source>,
    receiver: Box<dyn Receiver>,
    agreed: Agreed,
}

/// Serves a data connection until it ends.
pub fn serve(stream: UnixStream, hello: &DataHello, manager: &Manager) {
    let Some((mut opened, told)) = open(stream, hello, manager) else {
        return;
    };
    let (end, source) = (&opened.end, &opened.source);
    let ended = match &told {
        Ok(()) => receive(&mut *opened.receiver, &end.port, source, &opened.agreed),
        Err(error) => Ended::Lost(error.to_string()),
    };
    let ended = match hello.transport {
        Some(_) => ended,
        None => of_version_1(ended),
    };
    if !end.port.close(source, ended.parting()) {
        return;
    }
    if let Ended::Lost(reason) = &ended {
        log::warn(format_args!(
            "connector {}: its source is lost: {reason}",
            hello.connector
        ));
    }
    manager.events.changed(
        format!("connector/{}", hello.connector),
        format!("its source {} has gone", hello.source),
    );
    // One that never was agreed on is lost to nobody.
    if told.is_ok() && matches!(ended, Ended::Lost(_)) {
        manager.lose(&hello.instance, &hello.connector);
    }
}

/// Agrees with the other end, or refuses it; what became of the last word to it.
fn open(
    stream: UnixStream,
    hello: &DataHello,
    manager: &Manager,
) -> Option<(Opened, Result<(), FrameError>)> {
    let until = Instant::now() + PATIENCE;
    let answer = match stream.try_clone() {
        Ok(answer) => answer,
        Err(error) => {
            log::warn(format_args!("a data connection cannot be kept: {error}"));
            return None;
        }
    };
    let opened = agree(stream, hello, manager, |reply| {
        frame::write_answer(&mut Timed::new(&answer, until), reply)
    });
    let reply = DataReply {
        result: opened.as_ref().map(|_| ()).map_err(Failure::clone),
        ..DataReply::default()
    };
    let told = frame::write_answer(&mut Timed::new(&answer, until), &reply);
    Some((opened.ok()?, told))
}

/// Checks, says what comes, and makes this end of the transport. An end of version 1 has its transport already.
fn agree(
    stream: UnixStream,
    hello: &DataHello,
    manager: &Manager,
    tell: impl Fn(&DataReply) -> Result<(), FrameError>,
) -> Result<Opened, Failure> {
    let end = check(hello, &manager.bindings)?;
    let settings = settings(&hello.properties)?;
    let target = format!("{}.{}", hello.instance, hello.port);
    let component = manager.component(&hello.instance)?;
    let agreed = Agreed {
        has_common_clock: hello.clock.is_some() && hello.clock == boot_id(),
        turn: turn(
            order(hello)?,
            &target,
            &hello.data_type,
            component.module.idl(),
        )?,
    };
    let receiver: Box<dyn Receiver> = match &hello.transport {
        None => Box::new(unix::plain_receiver(stream).map_err(|e| cannot_be_kept(&e))?),
        Some(name) => {
            let kind: Kind = name
                .parse()
                .map_err(|e| invalid(format!("{}.{}: {e}", hello.instance, hello.port)))?;
            let place = (kind == Kind::Tcp).then(Place::new).transpose();
            let place = place.map_err(|e| cannot_be_kept(&e))?;
            let reply = DataReply {
                transport: hello.transport.clone(),
                meeting: place.as_ref().map(|place| place.meeting.clone()),
                ..DataReply::default()
            };
            tell(&reply).map_err(|e| cannot_be_kept(&e))?;
            let made = make(stream, kind, place);
            made.map_err(|e| internal(format!("no end of the transport {kind}: {e}")))?
        }
    };
    let handle = Some(receiver.handle());
    let source = end.open(handle, settings, None, &manager.events)?;
    Ok(Opened {
        end,
        source,
        receiver,
        agreed,
    })
}

fn cannot_be_kept(error: &dyn std::error::Error) -> Failure {
    internal(format!("the connection cannot be kept: {error}"))
}

/// This end of a transport that both have agreed on.
fn make(stream: UnixStream, kind: Kind, place: Option<Place>) -> io::Result<Box<dyn Receiver>> {
    let socket = match place {
        Some(place) => place.wait(Instant::now() + PATIENCE)?.into(),
        None => stream.into(),
    };
    kind.receiver(socket)
}

/// The end that the greeting means, when it may connect to it.
fn check(hello: &DataHello, bindings: &Bindings) -> Result<Arc<End>, Failure> {
    let target = format!("{}.{}", hello.instance, hello.port);
    rts_manager_api::speaks(hello.version)
        .map_err(|e| invalid(format!("the manager of {target}: {e}")))?;
    let end = bindings.find(&hello.connector).ok_or_else(|| {
        not_found(format!(
            "{target} does not expect the connector {}: it must be bound first",
            hello.connector
        ))
    })?;
    let binding = &end.binding;
    if (&binding.instance, &binding.port, &binding.source)
        != (&hello.instance, &hello.port, &hello.source)
    {
        return Err(conflict(format!(
            "the connector {} is bound from {} to {}.{}, not from {} to {target}",
            hello.connector, binding.source, binding.instance, binding.port, hello.source
        )));
    }
    if end.incarnation != hello.incarnation {
        return Err(conflict(format!(
            "{} is incarnation {}, not {}: it was started again; ask for its inventory",
            hello.instance, end.incarnation, hello.incarnation
        )));
    }
    check_types(
        &hello.source,
        &hello.data_type,
        &target,
        &end.port.data_type,
    )?;
    Ok(end)
}

/// The order of the bytes that come.
fn order(hello: &DataHello) -> Result<Endian, Failure> {
    match hello.encoding.as_str() {
        LITTLE_ENDIAN => Ok(Endian::Little),
        BIG_ENDIAN => Ok(Endian::Big),
        other => Err(invalid(format!(
            "{} sends the encoding {other}, of which {}.{} knows only {LITTLE_ENDIAN} and {BIG_ENDIAN}",
            hello.source, hello.instance, hello.port
        ))),
    }
}

/// Refuses ports of different types.
pub fn check_types(source: &str, sent: &str, target: &str, taken: &str) -> Result<(), Failure> {
    if sent == taken {
        return Ok(());
    }
    Err(invalid(format!(
        "{source} sends {sent}, but {target} takes {taken}"
    )))
}
