//! Opening a connection to the in-port end of a connector in another process.

use std::io;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

use rts_host::identity::boot_id;
use rts_manager_api::OLDEST_PROTOCOL_VERSION;
use rts_manager_api::control::{ConnectRequest, Failure, FailureCode, Greeting};
use rts_manager_api::data::{DataHello, DataReply, Meeting};
use rts_manager_api::frame::{self, FrameError};
use rts_manager_api::net::{self, Timed};
use rts_schemas::cdr::Endian;
use rts_transport::{Kind, shm, unix};

use super::order::{encoding, turn};
use super::sender::Agreed;
use super::{budget, meet};
use crate::failure::failure;
use crate::log;

/// Time for dialling and for the other end's answers.
const PATIENCE: Duration = Duration::from_secs(2);

/// What is to be reached, and how.
#[derive(Debug, Clone, Copy)]
pub struct Target<'a> {
    /// Control socket of its manager.
    pub socket: &'a Path,
    /// The connector.
    pub request: &'a ConnectRequest,
    /// IDL repository id of the samples.
    pub data_type: &'a str,
    /// Its reader fetches.
    pub pulls: bool,
    /// Order of the bytes of samples.
    pub endian: Endian,
    /// IDL source of the types of the out-port's module.
    pub idl: &'a str,
}

/// Why there is no connection.
enum Trouble {
    /// This transport cannot be had; another may.
    Transport(Failure),
    /// No other would do.
    Any(Failure),
}

/// Dials and agrees with the other end on the first of these transports that can be had.
pub fn dial(target: Target<'_>, kinds: &[Kind], deadline: Instant) -> Result<Agreed, Failure> {
    let turn = turn(
        target.endian,
        &target.source(),
        target.data_type,
        target.idl,
    )?;
    let agreed = dial_one(target, kinds, deadline)?;
    Ok(Agreed { turn, ..agreed })
}

fn dial_one(target: Target<'_>, kinds: &[Kind], deadline: Instant) -> Result<Agreed, Failure> {
    let until = deadline.min(Instant::now() + PATIENCE);
    let (last, others) = kinds.split_last().unwrap_or((&Kind::Unix, &[]));
    for kind in others {
        match target.try_one(*kind, kinds, until) {
            Ok(agreed) => return Ok(agreed),
            Err(Trouble::Any(failure)) => return Err(failure),
            Err(Trouble::Transport(failure)) => log::warn(format_args!(
                "connector {}: the transport {kind} cannot be had: {failure}",
                target.request.connector
            )),
        }
    }
    target
        .try_one(*last, kinds, until)
        .map_err(|trouble| match trouble {
            Trouble::Any(failure) | Trouble::Transport(failure) => failure,
        })
}

impl Target<'_> {
    fn try_one(self, kind: Kind, kinds: &[Kind], until: Instant) -> Result<Agreed, Trouble> {
        let stream = net::connect(self.socket, until)
            .map_err(|e| Trouble::Any(self.failed("cannot be reached", &e)))?;
        let reply = self.greet(&stream, kind, until).map_err(Trouble::Any)?;
        if reply.transport.is_none() {
            return self.version_1(stream, kinds).map_err(Trouble::Any);
        }
        let answer = stream.try_clone();
        let made = answer.and_then(|answer| {
            let made = make(stream, kind, reply.meeting.as_ref(), until)?;
            Ok((answer, made))
        });
        let (answer, agreed) = made.map_err(|e| {
            let text = format!("gets no connection by {kind}");
            Trouble::Transport(self.failed(&text, &e))
        })?;
        let ready: DataReply = frame::read_answer(&mut Timed::new(&answer, until))
            .map_err(|e| Trouble::Transport(self.no_answer(&e)))?;
        ready.result.map_err(Trouble::Transport)?;
        Ok(agreed)
    }

    fn greet(self, stream: &UnixStream, kind: Kind, until: Instant) -> Result<DataReply, Failure> {
        let request = self.request;
        let hello = DataHello {
            version: OLDEST_PROTOCOL_VERSION,
            connector: request.connector.clone(),
            source: self.source(),
            instance: request.target_instance.clone(),
            port: request.target_port.clone(),
            incarnation: request.target_incarnation.clone(),
            data_type: self.data_type.to_owned(),
            encoding: encoding(self.endian).to_owned(),
            properties: request.properties.clone(),
            transport: Some(kind.name().to_owned()),
            clock: boot_id(),
        };
        let mut timed = Timed::new(stream, until);
        frame::write(&mut timed, &Greeting::Data(Box::new(hello)))
            .map_err(|e| self.failed("takes no greeting", &e))?;
        let reply: DataReply = frame::read_answer(&mut timed).map_err(|e| self.no_answer(&e))?;
        reply.result.clone()?;
        Ok(reply)
    }

    /// The other end knows nothing but the frames of version 1.
    fn version_1(self, stream: UnixStream, kinds: &[Kind]) -> Result<Agreed, Failure> {
        let refuse = |what: &str| {
            Err(failure(
                FailureCode::PeerFailed,
                format!("{} {what}: restart it with a newer version", self.manager()),
            ))
        };
        if self.pulls {
            return refuse("cannot fetch samples (`dataport.dataflow_type` is `pull`)");
        }
        if !kinds.contains(&Kind::Unix) {
            let kinds: Vec<_> = kinds.iter().map(ToString::to_string).collect();
            let kinds = kinds.join(", ");
            return refuse(&format!(
                "knows no other transport than uds (`dataport.interface_type` asks for {kinds})"
            ));
        }
        let transport = unix::plain_sender(stream);
        Ok(Agreed {
            transport: Box::new(transport.map_err(|e| self.failed("gets no connection", &e))?),
            kind: Kind::Unix,
            is_version_1: true,
            ring: None,
            turn: None,
        })
    }

    fn source(self) -> String {
        format!("{}.{}", self.request.instance, self.request.port)
    }

    fn manager(self) -> String {
        let instance = &self.request.target_instance;
        format!("the manager of {instance} at {}", self.socket.display())
    }

    fn failed(self, what: &str, error: &dyn std::error::Error) -> Failure {
        failure(
            FailureCode::PeerFailed,
            format!("{} {what}: {error}", self.manager()),
        )
    }

    fn no_answer(self, error: &FrameError) -> Failure {
        self.failed("gave no answer", error)
    }
}

/// This end of a transport that both have agreed on.
fn make(
    stream: UnixStream,
    kind: Kind,
    meeting: Option<&Meeting>,
    until: Instant,
) -> io::Result<Agreed> {
    let ring = match kind {
        Kind::SharedMemory => {
            let text = "this process has made as much of it as it may";
            let share = budget::RINGS.share(shm::RING);
            Some(share.ok_or_else(|| io::Error::other(text))?)
        }
        _ => None,
    };
    let socket = match (kind, meeting) {
        (Kind::Tcp, Some(meeting)) => meet::go(meeting, until)?.into(),
        (Kind::Tcp, None) => return Err(io::Error::other("it did not say where")),
        _ => stream.into(),
    };
    Ok(Agreed {
        transport: kind.sender(socket)?,
        kind,
        is_version_1: false,
        ring,
        turn: None,
    })
}
