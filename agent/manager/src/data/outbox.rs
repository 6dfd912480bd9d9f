//! The sending half of a connector over a socket: a bounded queue and a thread that empties it.

use std::io::{self, Write};
use std::net::Shutdown;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use rustix::event::{EventfdFlags, PollFd, PollFlags, eventfd, poll};

use super::queue::Queue;
use super::{Payload, QUEUE_BYTES, QUEUE_LENGTH};
use crate::sync::lock;

/// Small samples are gathered into writes of about this size.
const GATHER: usize = 64 * 1024;

/// Queue, socket and the signal between them.
#[derive(Debug)]
pub struct Outbox {
    queue: Mutex<Queue<(u64, Payload)>>,
    filled: OwnedFd,
    stream: UnixStream,
    closed: AtomicBool,
}

impl Outbox {
    /// An outbox for a connection whose other end has agreed.
    pub fn new(stream: UnixStream) -> io::Result<Self> {
        stream.set_write_timeout(None)?;
        Ok(Self {
            queue: Mutex::new(Queue::new(QUEUE_LENGTH, QUEUE_BYTES)),
            filled: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
            stream,
            closed: AtomicBool::new(false),
        })
    }

    /// Queues a sample; `queued` runs before it can be sent. Returns how many older ones were dropped.
    pub fn push(&self, sequence: u64, payload: Payload, queued: impl FnOnce()) -> u64 {
        let size = payload.len();
        let mut drops = 0;
        let mut queue = lock(&self.queue);
        let was_empty = queue.is_empty();
        queue.push((sequence, payload), size, |_| drops += 1);
        queued();
        drop(queue);
        if was_empty {
            self.wake();
        }
        drops
    }

    /// Ends the connection and its thread.
    pub fn close(&self) {
        self.closed.store(true, Ordering::Release);
        let _ = self.stream.shutdown(Shutdown::Both);
        self.wake();
    }

    /// Sends until the connection ends; says why it did. For a thread of its own.
    pub fn send(&self) -> String {
        let mut buffer = Vec::new();
        loop {
            if let Err(error) = self.send_queued(&mut buffer) {
                return error.to_string();
            }
            match self.wait() {
                Ok(true) => {}
                Ok(false) => return "the other end closed the connection".to_owned(),
                Err(error) => return error.to_string(),
            }
        }
    }

    fn send_queued(&self, buffer: &mut Vec<u8>) -> io::Result<()> {
        loop {
            let sample = lock(&self.queue).pop();
            let Some((sequence, payload)) = sample else {
                break;
            };
            buffer.extend((payload.len() as u32 + 8).to_be_bytes());
            buffer.extend(sequence.to_be_bytes());
            if payload.len() < GATHER / 2 {
                buffer.extend(&payload);
            }
            if payload.len() >= GATHER / 2 || buffer.len() >= GATHER {
                (&self.stream).write_all(buffer)?;
                buffer.clear();
            }
            if payload.len() >= GATHER / 2 {
                (&self.stream).write_all(&payload)?;
            }
        }
        (&self.stream).write_all(buffer)?;
        buffer.clear();
        Ok(())
    }

    /// Waits for a sample; false when the other end has gone. The other end never sends, so anything from it is an end.
    fn wait(&self) -> io::Result<bool> {
        let mut fds = [
            PollFd::new(&self.stream, PollFlags::IN),
            PollFd::new(&self.filled, PollFlags::IN),
        ];
        match poll(&mut fds, None) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        if !fds[0].revents().is_empty() || self.closed.load(Ordering::Acquire) {
            return Ok(false);
        }
        let mut count = [0; 8];
        let _ = rustix::io::read(&self.filled, &mut count);
        Ok(true)
    }

    fn wake(&self) {
        // Fails only when it is signalled already.
        let _ = rustix::io::write(&self.filled, &1_u64.to_ne_bytes());
    }
}
