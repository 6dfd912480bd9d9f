//! A blocking client of one manager, for tools that need no runtime: `rtsctl down`, tests, benchmarks.

use std::io::BufReader;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

use crate::PROTOCOL_VERSION;
use crate::control::{Failure, FromManager, Greeting, Hello, Request, RequestBody, ResponseBody};
use crate::frame::{self, FrameError};

/// A call that failed.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    /// The connection failed or carried nonsense.
    #[error("manager connection: {0}")]
    Frame(#[from] FrameError),
    /// The manager refused.
    #[error(transparent)]
    Refused(#[from] Failure),
}

/// A control connection.
#[derive(Debug)]
pub struct Client {
    stream: BufReader<UnixStream>,
    hello: Hello,
    next_id: u64,
}

impl Client {
    /// Connects and greets. `timeout` bounds the greeting.
    pub fn connect(socket: &Path, timeout: Duration) -> Result<Self, CallError> {
        Self::greet(
            UnixStream::connect(socket).map_err(FrameError::from)?,
            timeout,
        )
    }

    /// Greets over a connection that is already open (a manager's standard input).
    pub fn greet(mut stream: UnixStream, timeout: Duration) -> Result<Self, CallError> {
        set_timeout(&stream, timeout)?;
        frame::write(
            &mut stream,
            &Greeting::Control {
                version: PROTOCOL_VERSION,
            },
        )?;
        let mut stream = BufReader::new(stream);
        let hello = frame::read(&mut stream)?;
        Ok(Self {
            stream,
            hello,
            next_id: 1,
        })
    }

    /// What the manager said first.
    pub fn hello(&self) -> &Hello {
        &self.hello
    }

    /// Sends a request and waits for its response; pushed events in between are dropped.
    pub fn call(
        &mut self,
        body: RequestBody,
        deadline: Duration,
    ) -> Result<ResponseBody, CallError> {
        let id = self.next_id;
        self.next_id += 1;
        set_timeout(self.stream.get_ref(), deadline + Duration::from_secs(1))?;
        let deadline_ms = deadline.as_millis().try_into().unwrap_or(u64::MAX);
        frame::write(
            self.stream.get_mut(),
            &Request {
                id,
                deadline_ms,
                body,
            },
        )?;
        loop {
            if let FromManager::Response(response) = frame::read(&mut self.stream)?
                && response.id == id
            {
                return Ok(response.result?);
            }
        }
    }
}

fn set_timeout(stream: &UnixStream, timeout: Duration) -> Result<(), FrameError> {
    let timeout = Some(timeout.max(Duration::from_millis(1)));
    stream.set_read_timeout(timeout)?;
    stream.set_write_timeout(timeout)?;
    Ok(())
}
