//! A connection: the greeting that decides what it is, and the life of a control connection.

mod asked;

use std::io::{BufReader, Write};
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rts_manager_api::control::{
    Failure, FromManager, Greeting, Hello, RequestBody, Response, ResponseBody,
};
use rts_manager_api::frame::{self, FrameError};
use rts_manager_api::net::Timed;
use rts_manager_api::{PROTOCOL_VERSION, speaks};
use serde::Deserialize;
use serde_json::Value;

use self::asked::Asked;
use crate::data::accept;
use crate::failure::{internal, invalid};
use crate::pool::Full;
use crate::server::Shared;
use crate::sync::lock;
use crate::{log, requests, tap};

/// Time for a greeting to arrive.
const GREETING: Duration = Duration::from_secs(2);
/// Time for a message to leave; a receiver that is slower is dropped.
const SENDING: Duration = Duration::from_secs(2);
/// Longest deadline that is kept.
const MAX_DEADLINE: Duration = Duration::from_secs(3600);
/// Most requests that one thread carries out together.
const MAX_TOGETHER: usize = 64;
/// Bytes of requests that are read at once.
const BUFFER: usize = 64 * 1024;

/// The sending half of a control connection.
pub struct Connection {
    writer: Mutex<UnixStream>,
}

/// A request whose body may be one that this version does not know.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Envelope {
    id: u64,
    deadline_ms: u64,
    body: Value,
}

/// Serves a connection until it ends.
pub fn serve(stream: UnixStream, shared: &Arc<Shared>) {
    let mut timed = Timed::new(&stream, Instant::now() + GREETING);
    let served = match frame::read(&mut timed) {
        Ok(Greeting::Control { version }) => control(stream, version, shared),
        Ok(Greeting::Data(hello)) => {
            if let Some(_slot) = shared.incoming.take() {
                accept::serve(stream, &hello, &shared.manager);
            } else {
                log::warn(format_args!(
                    "a data connection was closed: there are {} already",
                    shared.incoming.limit()
                ));
            }
            Ok(())
        }
        Ok(Greeting::Tap(hello)) => tap::serve(&stream, &hello, &shared.manager),
        Err(error) => Err(error),
    };
    match served {
        Ok(()) | Err(FrameError::Closed) => {}
        Err(error) => log::warn(format_args!("a connection was closed: {error}")),
    }
}

fn control(stream: UnixStream, version: u32, shared: &Arc<Shared>) -> Result<(), FrameError> {
    let Some(_slot) = shared.controls.take() else {
        log::warn(format_args!(
            "a control connection was closed: there are {} already",
            shared.controls.limit()
        ));
        return Ok(());
    };
    stream.set_read_timeout(None)?;
    let mut reader = BufReader::with_capacity(BUFFER, stream.try_clone()?);
    let connection = Arc::new(Connection {
        writer: Mutex::new(stream),
    });
    let spoken = speaks(version);
    let hello = Hello {
        version: spoken.map_or(PROTOCOL_VERSION, |()| version),
        ..shared.manager.hello.clone()
    };
    connection.transmit(&hello)?;
    if let Err(mismatch) = spoken {
        // The hello above tells the other side our version, so that it can say who is to be upgraded.
        log::warn(format_args!("a control connection was closed: {mismatch}"));
        return Ok(());
    }
    shared.manager.events.subscribe(&connection);
    let ended = read_requests(&mut reader, &connection, shared);
    connection.shut();
    ended
}

fn read_requests(
    reader: &mut BufReader<UnixStream>,
    connection: &Arc<Connection>,
    shared: &Arc<Shared>,
) -> Result<(), FrameError> {
    loop {
        let mut burst = Burst::default();
        let mut broken = None;
        let first = frame::read(reader)?;
        sort(first, connection, shared, &mut burst);
        // What is here already was asked at once. What came before a bad frame is carried out all the same.
        while broken.is_none() && burst.len() < MAX_TOGETHER && frame::is_whole(reader.buffer()) {
            match frame::read(reader) {
                Ok(next) => sort(next, connection, shared, &mut burst),
                Err(error) => broken = Some(error),
            }
        }
        hand_over(burst.short, connection, shared, asked::answer);
        hand_over(burst.loads, connection, shared, asked::answer_each);
        if let Some(error) = broken {
            return Err(error);
        }
    }
}

/// Answers what takes no time, gives a thread to what waits, and leaves the rest for one thread together.
fn sort(envelope: Envelope, connection: &Arc<Connection>, shared: &Arc<Shared>, burst: &mut Burst) {
    let id = envelope.id;
    let patience = Duration::from_millis(envelope.deadline_ms).min(MAX_DEADLINE);
    let deadline = Instant::now() + patience;
    let body = match serde_json::from_value(envelope.body) {
        Ok(body) => body,
        Err(error) => {
            let message = format!("this manager does not understand the request: {error}");
            return connection.respond(id, Err(invalid(message)));
        }
    };
    if matches!(body, RequestBody::Inventory | RequestBody::Factories) {
        // They wait for nothing, so they need no thread.
        return connection.respond(id, requests::handle(&shared.manager, body, deadline));
    }
    let is_short = requests::begins_at_once(&body);
    let asked = Asked { id, body, deadline };
    match asked.body {
        _ if is_short => burst.short.push(asked),
        RequestBody::LoadModule { .. } => burst.loads.push(asked),
        _ => hand_over(vec![asked], connection, shared, asked::answer),
    }
}

/// Requests that were asked at once and are carried out on one thread.
#[derive(Default)]
struct Burst {
    /// They are begun at once.
    short: Vec<Asked>,
    /// Modules are opened one after the other, whoever does it.
    loads: Vec<Asked>,
}

impl Burst {
    fn len(&self) -> usize {
        self.short.len() + self.loads.len()
    }
}

/// Gives requests to one thread.
fn hand_over(
    asked: Vec<Asked>,
    connection: &Arc<Connection>,
    shared: &Arc<Shared>,
    answer: impl FnOnce(Vec<Asked>, &Connection, &Shared) + Send + 'static,
) {
    if asked.is_empty() {
        return;
    }
    let ids: Vec<u64> = asked.iter().map(|asked| asked.id).collect();
    let ends = |asked: &Asked| {
        let body = &asked.body;
        matches!(
            body,
            RequestBody::Deactivate { .. } | RequestBody::Delete { .. } | RequestBody::Shutdown
        )
    };
    let reserved = usize::from(!asked.iter().all(ends));
    let job = {
        let (connection, shared) = (Arc::clone(connection), Arc::clone(shared));
        move || answer(asked, &connection, &shared)
    };
    let may_grow = shared.manager.may_start_threads();
    if let Err(Full) = shared.manager.pool.run(may_grow, reserved, job) {
        for id in ids {
            connection.respond(id, Err(internal("too many requests are under way")));
        }
    }
}

impl Connection {
    /// Answers several requests in one go.
    fn respond_all(&self, answers: Vec<(u64, Result<ResponseBody, Failure>)>) {
        let mut bytes = Vec::new();
        for (id, result) in answers {
            let response = FromManager::Response(Response { id, result });
            match frame::write_answer(&mut bytes, &response) {
                Ok(()) => {}
                // Alone, it is told why.
                Err(_) => match response {
                    FromManager::Response(Response { id, result }) => self.respond(id, result),
                    FromManager::Changed(_) => {}
                },
            }
        }
        let writer = lock(&self.writer);
        let mut timed = Timed::new(&writer, Instant::now() + SENDING);
        let sent = timed.write_all(&bytes).and_then(|()| timed.flush());
        drop(writer);
        self.judge(sent.map_err(FrameError::from));
    }

    fn respond(&self, id: u64, result: Result<ResponseBody, Failure>) {
        let response = FromManager::Response(Response { id, result });
        match self.transmit(&response) {
            // Nothing has left yet, so that the connection is still good.
            Err(FrameError::TooLong { length, .. }) => {
                let message = format!("the answer of {length} bytes is too long for one frame");
                let result = Err(internal(message));
                self.send(&FromManager::Response(Response { id, result }));
            }
            sent => self.judge(sent),
        }
    }

    /// Sends a message. A receiver that does not take it is dropped.
    pub fn send(&self, message: &FromManager) {
        self.judge(self.transmit(message));
    }

    fn judge(&self, sent: Result<(), FrameError>) {
        if let Err(error) = sent {
            if !matches!(&error, FrameError::Io(e) if e.kind() == std::io::ErrorKind::BrokenPipe) {
                log::warn(format_args!("a control connection was closed: {error}"));
            }
            self.shut();
        }
    }

    fn transmit<T: serde::Serialize>(&self, message: &T) -> Result<(), FrameError> {
        let writer = lock(&self.writer);
        frame::write_answer(&mut Timed::new(&writer, Instant::now() + SENDING), message)
    }

    /// Ends the connection, and with it the thread that reads it.
    fn shut(&self) {
        let _ = lock(&self.writer).shutdown(Shutdown::Both);
    }
}
