//! The sending half of a connector over a socket: a bounded queue and a thread that empties it.

use std::io;
use std::net::Shutdown;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use rts_manager_api::data::GOOD_BYE;
use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec, eventfd, poll};
use rustix::io::Errno;
use rustix::net::{RecvFlags, SendFlags};

use super::budget;
use super::queue::Queue;
use super::{Ended, Parting, Payload, QUEUE_BYTES, QUEUE_LENGTH, SILENT_END};
use crate::sync::lock;

/// Small samples are gathered into writes of about this size.
const GATHER: usize = 64 * 1024;

/// A connection that is closed has this long to take what is half sent, and the good-bye.
const PARTING: Duration = Duration::from_millis(500);

/// Queue, socket and the signal between them.
#[derive(Debug)]
pub struct Outbox {
    queue: Mutex<Queue<(u64, Payload)>>,
    filled: OwnedFd,
    stream: UnixStream,
    /// The other end understands a good-bye.
    good_bye: bool,
    /// Since when it is to end.
    leaving: Mutex<Option<Instant>>,
}

impl Outbox {
    /// An outbox for a connection whose other end has agreed.
    pub fn new(stream: UnixStream, good_bye: bool) -> io::Result<Self> {
        Ok(Self {
            queue: Mutex::new(Queue::new(QUEUE_LENGTH, QUEUE_BYTES, &budget::PROCESS)),
            filled: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
            stream,
            good_bye,
            leaving: Mutex::default(),
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

    /// Ends the connection and its thread. Never blocks: that thread says the good-bye.
    pub fn close(&self, parting: Parting) {
        lock(&self.leaving).get_or_insert_with(Instant::now);
        if parting == Parting::Loss || !self.good_bye {
            let _ = self.stream.shutdown(Shutdown::Both);
        }
        self.wake();
    }

    /// Sends until the connection ends; says why it did. For a thread of its own.
    pub fn send(&self) -> Ended {
        let ended = self.send_all().unwrap_or_else(|error| {
            if self.leaves() {
                Ended::Here
            } else {
                self.judge(&error.to_string())
            }
        });
        let _ = self.stream.shutdown(Shutdown::Both);
        ended
    }

    fn send_all(&self) -> io::Result<Ended> {
        let mut buffer = Vec::new();
        loop {
            self.send_queued(&mut buffer)?;
            if self.leaves() {
                if self.good_bye {
                    self.write(&GOOD_BYE)?;
                }
                return Ok(Ended::Here);
            }
            // A write that waited for room has taken the wake-ups of meanwhile.
            if !lock(&self.queue).is_empty() {
                continue;
            }
            if !self.wait()? {
                return Ok(self.judge("the other end closed the connection"));
            }
        }
    }

    fn leaves(&self) -> bool {
        lock(&self.leaving).is_some()
    }

    /// Why the other end has gone. It sends nothing but its good-bye.
    fn judge(&self, otherwise: &str) -> Ended {
        let mut byte = [0];
        match rustix::net::recv(&self.stream, &mut byte, RecvFlags::DONTWAIT) {
            Ok((1.., _)) => Ended::GoodBye,
            _ if !self.good_bye => Ended::Lost(SILENT_END.to_owned()),
            _ => Ended::Lost(otherwise.to_owned()),
        }
    }

    fn send_queued(&self, buffer: &mut Vec<u8>) -> io::Result<()> {
        while !self.leaves() {
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
                self.write(buffer)?;
                buffer.clear();
            }
            if payload.len() >= GATHER / 2 {
                self.write(&payload)?;
            }
        }
        self.write(buffer)?;
        buffer.clear();
        Ok(())
    }

    /// Writes all, while the connection is not closed for too long.
    fn write(&self, mut bytes: &[u8]) -> io::Result<()> {
        let flags = SendFlags::DONTWAIT | SendFlags::NOSIGNAL;
        while !bytes.is_empty() {
            match rustix::net::send(&self.stream, bytes, flags) {
                Ok(sent) => bytes = &bytes[sent..],
                Err(Errno::AGAIN) => {
                    self.poll(PollFlags::OUT)?;
                }
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    /// Waits for a sample; false when the other end has gone. The other end never sends, so anything from it is an end.
    fn wait(&self) -> io::Result<bool> {
        Ok(self.poll(PollFlags::IN)?.is_empty())
    }

    /// Waits for the stream or for a wake-up; returns what the stream is ready for.
    fn poll(&self, flags: PollFlags) -> io::Result<PollFlags> {
        let left = match *lock(&self.leaving) {
            None => None,
            Some(since) => {
                let left = PARTING.checked_sub(since.elapsed());
                Some(left.ok_or(io::ErrorKind::TimedOut)?)
            }
        };
        let timeout = left.map(|left| Timespec {
            tv_sec: 0,
            tv_nsec: left.subsec_nanos().into(),
        });
        let mut fds = [
            PollFd::new(&self.stream, flags),
            PollFd::new(&self.filled, PollFlags::IN),
        ];
        match poll(&mut fds, timeout.as_ref()) {
            Ok(_) | Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        let [stream, filled] = fds.map(|fd| fd.revents());
        if !filled.is_empty() {
            let mut count = [0; 8];
            let _ = rustix::io::read(&self.filled, &mut count);
        }
        Ok(stream)
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
        let outbox = Arc::new(Outbox::new(left, true).unwrap());
        let sender = thread::spawn({
            let outbox = Arc::clone(&outbox);
            move || outbox.send()
        });
        let port = Arc::new(InPort::new("in", "T"));
        let source = Arc::new(Source::new(None));
        let receiver = thread::spawn({
            let (port, source) = (Arc::clone(&port), Arc::clone(&source));
            move || receive(&right, &port, &source, true)
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
        outbox.close(Parting::GoodBye);
        assert_eq!(receiver.join().unwrap(), Ended::GoodBye);
        assert_eq!(sender.join().unwrap(), Ended::Here);
    }

    /// A sender whose receiver ended by `end`, with samples under way that it never read.
    fn ended(end: impl FnOnce(&Source)) -> Ended {
        let (left, right) = UnixStream::pair().unwrap();
        let outbox = Arc::new(Outbox::new(left, true).unwrap());
        let source = Source::new(Some(right));
        for sequence in 1..10 {
            outbox.push(sequence, vec![0; 1 << 20].into(), || ());
        }
        let sender = thread::spawn(move || outbox.send());
        thread::sleep(Duration::from_millis(20));
        end(&source);
        drop(source);
        sender.join().unwrap()
    }

    #[test]
    fn a_good_bye_tells_an_end_from_a_loss_also_when_samples_are_under_way() {
        assert_eq!(
            ended(|source| {
                source.close(Parting::GoodBye);
            }),
            Ended::GoodBye
        );
        assert!(matches!(ended(|_| ()), Ended::Lost(_)));
    }

    #[test]
    fn the_end_of_one_that_says_no_good_bye_is_a_loss_that_says_so() {
        let (left, right) = UnixStream::pair().unwrap();
        let outbox = Outbox::new(left, false).unwrap();
        drop(right);
        assert_eq!(outbox.send(), Ended::Lost(SILENT_END.to_owned()));
    }

    #[test]
    fn one_that_is_closed_does_not_wait_for_a_receiver_that_stalls() {
        let (left, _right) = UnixStream::pair().unwrap();
        let outbox = Arc::new(Outbox::new(left, true).unwrap());
        outbox.push(1, vec![0; 1 << 24].into(), || ());
        let sender = thread::spawn({
            let outbox = Arc::clone(&outbox);
            move || outbox.send()
        });
        thread::sleep(Duration::from_millis(20));
        let begin = Instant::now();
        outbox.close(Parting::GoodBye);
        assert_eq!(sender.join().unwrap(), Ended::Here);
        assert!(begin.elapsed() < Duration::from_secs(10));
    }

    #[test]
    fn what_is_queued_while_the_last_write_waits_for_room_is_sent() {
        let (left, right) = UnixStream::pair().unwrap();
        let outbox = Arc::new(Outbox::new(left, true).unwrap());
        let sender = thread::spawn({
            let outbox = Arc::clone(&outbox);
            move || outbox.send()
        });
        // Nobody reads: each is taken from the queue before the next comes, until one finds no room, as the last of its
        // write. Then one more comes.
        let mut sent = 0;
        let taken = |outbox: &Outbox| {
            let begin = Instant::now();
            while begin.elapsed() < Duration::from_millis(100) {
                if lock(&outbox.queue).is_empty() {
                    return true;
                }
                thread::sleep(Duration::from_millis(1));
            }
            false
        };
        while taken(&outbox) {
            sent += 1;
            assert_eq!(outbox.push(sent, vec![0; 30_000].into(), || ()), 0);
        }
        let port = Arc::new(InPort::new("in", "T"));
        let source = Arc::new(Source::new(None));
        let receiver = thread::spawn({
            let (port, source) = (Arc::clone(&port), Arc::clone(&source));
            move || receive(&right, &port, &source, true)
        });
        let begin = Instant::now();
        while source.counts().received < sent {
            port.begin();
            port.read();
            let received = source.counts().received;
            assert!(
                begin.elapsed() < Duration::from_secs(10),
                "{received} of {sent}"
            );
            thread::yield_now();
        }
        outbox.close(Parting::GoodBye);
        assert_eq!(receiver.join().unwrap(), Ended::GoodBye);
        assert_eq!(sender.join().unwrap(), Ended::Here);
    }

    #[test]
    fn a_stalled_receiver_costs_the_oldest_samples_and_blocks_nobody() {
        let (left, right) = UnixStream::pair().unwrap();
        let outbox = Arc::new(Outbox::new(left, true).unwrap());
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
        assert!(matches!(sender.join().unwrap(), Ended::Lost(_)));
    }
}
