//! A blocking client of one manager, for tools that need no runtime: `rtsctl down`, tests, benchmarks.

use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::control::{Failure, FromManager, Greeting, Hello, Request, RequestBody, ResponseBody};
use crate::frame::{self, FrameError};
use crate::net::{self, Timed};
use crate::{PROTOCOL_VERSION, VersionMismatch, speaks};

/// A manager answers by the deadline of a request; its answer has this much longer to arrive.
const GRACE: Duration = Duration::from_secs(1);

/// A call that failed.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    /// The connection failed or carried nonsense.
    #[error("manager connection: {0}")]
    Frame(#[from] FrameError),
    /// The manager speaks no version of ours.
    #[error("cannot use this manager: {0}")]
    Version(#[from] VersionMismatch),
    /// The manager refused.
    #[error(transparent)]
    Refused(#[from] Failure),
}

/// A control connection.
#[derive(Debug)]
pub struct Client {
    stream: UnixStream,
    hello: Hello,
    next_id: u64,
}

impl Client {
    /// Connects and greets. `timeout` bounds both together.
    pub fn connect(socket: &Path, timeout: Duration) -> Result<Self, CallError> {
        let until = Instant::now() + timeout;
        let stream = net::connect(socket, until).map_err(FrameError::from)?;
        Self::greet_until(stream, until)
    }

    /// Greets over a connection that is already open (a manager's standard input).
    pub fn greet(stream: UnixStream, timeout: Duration) -> Result<Self, CallError> {
        Self::greet_until(stream, Instant::now() + timeout)
    }

    fn greet_until(stream: UnixStream, until: Instant) -> Result<Self, CallError> {
        let mut timed = Timed::new(&stream, until);
        let greeting = Greeting::Control {
            version: PROTOCOL_VERSION,
        };
        frame::write(&mut timed, &greeting)?;
        let hello: Hello = frame::read_answer(&mut timed)?;
        speaks(hello.version)?;
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

    /// Sends a request and waits for its response until a second after its deadline; pushed events in between are
    /// dropped, and give no more time.
    pub fn call(
        &mut self,
        body: RequestBody,
        deadline: Duration,
    ) -> Result<ResponseBody, CallError> {
        let id = self.next_id;
        self.next_id += 1;
        let mut timed = Timed::new(&self.stream, Instant::now() + deadline + GRACE);
        let deadline_ms = deadline.as_millis().try_into().unwrap_or(u64::MAX);
        let request = Request {
            id,
            deadline_ms,
            body: body.for_version(self.hello.version),
        };
        frame::write(&mut timed, &request)?;
        loop {
            if let FromManager::Response(response) = frame::read_answer(&mut timed)?
                && response.id == id
            {
                return Ok(response.result?);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::net::UnixListener;
    use std::thread;

    use super::*;
    use crate::control::Changed;

    fn is_timeout(error: &CallError) -> bool {
        matches!(error, CallError::Frame(FrameError::Io(e)) if e.kind() == std::io::ErrorKind::TimedOut)
    }

    #[test]
    fn a_manager_that_accepts_nobody_does_not_hold_a_client_back() {
        let folder = tempfile::tempdir_in("/tmp").unwrap();
        let path = folder.path().join("s");
        let listener = UnixListener::bind(&path).unwrap();
        rustix::net::listen(&listener, 0).unwrap();
        // One more than the backlog takes; all but the last wait for a greeting.
        let timeout = Duration::from_millis(50);
        let begin = Instant::now();
        for _ in 0..3 {
            assert!(is_timeout(&Client::connect(&path, timeout).unwrap_err()));
        }
        let waiting = [(); 3].map(|()| net::connect(&path, Instant::now() + timeout));
        assert!(waiting.iter().any(Result::is_err), "the backlog is full");
        assert!(begin.elapsed() < Duration::from_secs(5));
    }

    #[test]
    fn a_manager_of_another_age_is_refused_with_the_side_to_upgrade() {
        let (ours, theirs) = UnixStream::pair().unwrap();
        let hello = Hello {
            version: 9,
            system: None,
            name: "m".to_owned(),
            incarnation: "i".to_owned(),
            pid: 1,
            started: String::new(),
        };
        frame::write_answer(&mut &theirs, &hello).unwrap();
        let error = Client::greet(ours, Duration::from_secs(10)).unwrap_err();
        assert!(matches!(error, CallError::Version(_)), "{error}");
        assert!(error.to_string().ends_with("upgrade this side"), "{error}");
    }

    #[test]
    fn events_give_a_call_no_more_time() {
        let (ours, theirs) = UnixStream::pair().unwrap();
        let manager = thread::spawn(move || {
            let mut theirs = &theirs;
            let _: Greeting = frame::read(&mut theirs).unwrap();
            let hello = Hello {
                version: PROTOCOL_VERSION,
                system: None,
                name: "m".to_owned(),
                incarnation: "i".to_owned(),
                pid: 1,
                started: String::new(),
            };
            frame::write_answer(&mut theirs, &hello).unwrap();
            let event = FromManager::Changed(Changed {
                reason: None,
                target: "component/A".to_owned(),
                message: String::new(),
            });
            while frame::write_answer(&mut theirs, &event).is_ok() {
                thread::sleep(Duration::from_millis(10));
            }
        });
        let mut client = Client::greet(ours, Duration::from_secs(10)).unwrap();
        let begin = Instant::now();
        let error = client
            .call(RequestBody::Inventory, Duration::ZERO)
            .unwrap_err();
        assert!(is_timeout(&error), "{error}");
        assert!(begin.elapsed() < Duration::from_secs(10));
        drop(client);
        manager.join().unwrap();
    }
}
