//! The sending half of a connector over a socket: a bounded queue and a thread that empties it.

use std::io::{self, Write};
use std::net::Shutdown;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use rustix::event::{EventfdFlags, PollFd, PollFlags, eventfd, poll};

use super::budget;
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
            queue: Mutex::new(Queue::new(QUEUE_LENGTH, QUEUE_BYTES, &budget::PROCESS)),
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::thread;

    use super::*;
    use crate::data::in_port::InPort;
    use crate::data::receive::receive;
    use crate::data::source::Source;

    #[test]
    fn samples_of_all_sizes_pass_and_both_ends_notice_the_end() {
        let (left, right) = UnixStream::pair().unwrap();
        let outbox = Arc::new(Outbox::new(left).unwrap());
        let sender = thread::spawn({
            let outbox = Arc::clone(&outbox);
            move || outbox.send()
        });
        let port = Arc::new(InPort::new("in", "T"));
        let source = Arc::new(Source::new(None));
        let receiver = thread::spawn({
            let (port, source) = (Arc::clone(&port), Arc::clone(&source));
            move || receive(&right, &port, &source)
        });
        let sizes = [0, 10, 40_000, 1 << 20, 1, 32_767, 32_768, 65_536];
        for (sequence, size) in (1..).zip(sizes) {
            let payload = vec![size as u8; size];
            assert_eq!(outbox.push(sequence, payload.into(), || ()), 0);
        }
        for size in sizes {
            let payload = loop {
                port.begin();
                match port.read() {
                    Some(payload) => break payload,
                    None => thread::yield_now(),
                }
            };
            assert_eq!(payload.len(), size);
            assert!(payload.iter().all(|byte| *byte == size as u8));
        }
        assert_eq!(source.counts().gaps, 0);
        outbox.close();
        receiver.join().unwrap().unwrap();
        sender.join().unwrap();
    }

    #[test]
    fn a_stalled_receiver_costs_the_oldest_samples_and_blocks_nobody() {
        let (left, right) = UnixStream::pair().unwrap();
        let outbox = Arc::new(Outbox::new(left).unwrap());
        let sender = thread::spawn({
            let outbox = Arc::clone(&outbox);
            move || outbox.send()
        });
        let payload = Payload::from(vec![0; 1 << 20]);
        let drops: u64 = (1..200)
            .map(|sequence| outbox.push(sequence, payload.clone(), || ()))
            .sum();
        assert!(drops > 100, "{drops}");
        drop(right);
        assert!(!sender.join().unwrap().is_empty());
    }
}
