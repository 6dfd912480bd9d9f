//! Deciding on a data connection at its in-port end, and serving it.

use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rts_manager_api::control::Failure;
use rts_manager_api::data::{DataHello, DataReply};
use rts_manager_api::frame;
use rts_manager_api::net::Timed;

use super::binding::{Bindings, End};
use super::receive::receive;
use super::sender::Agreed;
use super::settings;
use super::{ENCODING, Ended};
use crate::failure::{conflict, internal, invalid, not_found};
use crate::log;
use crate::manager::Manager;

/// Time for the reply to leave.
const PATIENCE: Duration = Duration::from_secs(2);

/// Serves a data connection until it ends.
pub fn serve(stream: &UnixStream, hello: &DataHello, manager: &Manager) {
    let events = &manager.events;
    let opened = check(hello, &manager.bindings).and_then(|end| {
        let closer = stream
            .try_clone()
            .map_err(|e| internal(format!("the connection cannot be kept: {e}")))?;
        let settings = settings(&hello.properties)?;
        let source = end.open(Some(closer), settings, None, events)?;
        Ok((end, source))
    });
    let reply = DataReply {
        result: opened.as_ref().map(|_| ()).map_err(Failure::clone),
        good_bye: true,
        pull: true,
        stamped: hello.stamped,
    };
    let mut timed = Timed::new(stream, Instant::now() + PATIENCE);
    let sent = frame::write_answer(&mut timed, &reply);
    let Ok((end, source)) = opened else {
        return;
    };
    let agreed = sent
        .map_err(|e| e.to_string())
        .and_then(|()| stream.set_read_timeout(None).map_err(|e| e.to_string()));
    let ended = match &agreed {
        Ok(()) => {
            let agreed = Agreed {
                good_bye: hello.good_bye,
                stamped: hello.stamped,
            };
            receive(stream, &end.port, &source, agreed)
        }
        Err(reason) => Ended::Lost(reason.clone()),
    };
    if !end.port.close(&source, ended.parting()) {
        return;
    }
    if let Ended::Lost(reason) = &ended {
        log::warn(format_args!("connector {}: {reason}", hello.connector));
    }
    events.changed(
        format!("connector/{}", hello.connector),
        format!("its source {} has gone", hello.source),
    );
    // One that never was agreed on is lost to nobody.
    if agreed.is_ok() && matches!(ended, Ended::Lost(_)) {
        manager.lose(&hello.instance, &hello.connector);
    }
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
    if hello.encoding != ENCODING {
        return Err(invalid(format!(
            "{} sends the encoding {}, of which {target} knows only {ENCODING}",
            hello.source, hello.encoding
        )));
    }
    Ok(end)
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
