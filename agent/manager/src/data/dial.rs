//! Opening a connection to the in-port end of a connector in another process.

use std::io::Write;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

use rts_manager_api::OLDEST_PROTOCOL_VERSION;
use rts_manager_api::control::{ConnectRequest, Failure, FailureCode, Greeting};
use rts_manager_api::data::{DataHello, DataReply, GOOD_BYE};
use rts_manager_api::frame::{self, FrameError};
use rts_manager_api::net::{self, Timed};

use super::ENCODING;
use super::sender::Agreed;
use crate::failure::failure;

/// Time for dialling and for the other end's answer.
const PATIENCE: Duration = Duration::from_secs(2);

/// A connection that both ends have agreed on.
pub struct Dialled {
    /// The connection.
    pub stream: UnixStream,
    /// What the other end understands.
    pub agreed: Agreed,
}

/// Dials and agrees with the other end.
pub fn dial(
    socket: &str,
    request: &ConnectRequest,
    data_type: &str,
    pulls: bool,
    deadline: Instant,
) -> Result<Dialled, Failure> {
    let until = deadline.min(Instant::now() + PATIENCE);
    let hello = DataHello {
        version: OLDEST_PROTOCOL_VERSION,
        connector: request.connector.clone(),
        source: format!("{}.{}", request.instance, request.port),
        instance: request.target_instance.clone(),
        port: request.target_port.clone(),
        incarnation: request.target_incarnation.clone(),
        data_type: data_type.to_owned(),
        encoding: ENCODING.to_owned(),
        good_bye: true,
        properties: request.properties.clone(),
        stamped: true,
    };
    let peer_failed = |what: &str, error: FrameError| {
        failure(
            FailureCode::PeerFailed,
            format!(
                "the manager of {} at {socket} {what}: {error}",
                request.target_instance
            ),
        )
    };
    let stream = net::connect(Path::new(socket), until)
        .map_err(|e| peer_failed("cannot be reached", e.into()))?;
    let mut timed = Timed::new(&stream, until);
    frame::write(&mut timed, &Greeting::Data(hello))
        .map_err(|e| peer_failed("takes no greeting", e))?;
    let reply: DataReply =
        frame::read_answer(&mut timed).map_err(|e| peer_failed("gave no answer", e))?;
    reply.result?;
    if pulls && !reply.pull {
        if reply.good_bye {
            // So that it is no loss to the other end. When it does not arrive, that one has gone.
            let _ = (&stream).write_all(&GOOD_BYE);
        }
        return Err(failure(
            FailureCode::PeerFailed,
            format!(
                "the manager of {} at {socket} cannot fetch samples (`dataport.dataflow_type` is `pull`): restart it \
                 with a newer version",
                request.target_instance
            ),
        ));
    }
    Ok(Dialled {
        stream,
        agreed: Agreed {
            good_bye: reply.good_bye,
            stamped: reply.stamped,
        },
    })
}
