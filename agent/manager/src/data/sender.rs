//! The out-port end of a connector over a socket: the writer sends what the socket takes at once; a thread sends the
//! rest, answers a reader that fetches, and sees the end of the connection.

use std::io;
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::sync::{Mutex, TryLockError};
use std::time::{Duration, Instant};

use rts_manager_api::data::{EMPTY, FETCH_FIRST, FETCH_MORE, GOOD_BYE};
use rts_schemas::connector::{ConnectorSettings, Dataflow, Subscription};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::net::{RecvFlags, recv};

use super::outbox::{Fetched, Outbox};
use super::sample::Sample;
use super::wire::Wire;
use super::{Ended, Parting, SILENT_END};
use crate::sync::lock;

/// A connection that is closed has this long to take what is half sent, and the good-bye.
const PARTING: Duration = Duration::from_millis(500);

/// What both ends of a connection have agreed on.
#[derive(Debug, Clone, Copy, Default)]
pub struct Agreed {
    /// The other end understands a good-bye.
    pub good_bye: bool,
    /// The time of writing goes with each sample.
    pub stamped: bool,
}

/// An outbox and the socket that it is emptied into.
#[derive(Debug)]
pub struct Sender {
    /// What waits.
    pub outbox: Outbox,
    wire: Mutex<Wire>,
    stream: UnixStream,
    good_bye: bool,
    /// The reader fetches.
    pulled: bool,
    /// The writer sends in its own call.
    at_once: bool,
}

/// A reader that waits for a sample until then.
type Asked = Option<Instant>;

impl Sender {
    /// For a connection whose other end has agreed.
    pub fn new(
        stream: UnixStream,
        agreed: Agreed,
        settings: &ConnectorSettings,
    ) -> io::Result<Self> {
        Ok(Self {
            outbox: Outbox::new(settings)?,
            wire: Mutex::new(Wire::new(agreed.stamped)),
            stream,
            good_bye: agreed.good_bye,
            pulled: settings.dataflow == Dataflow::Pull,
            at_once: settings.dataflow == Dataflow::Push
                && settings.subscription == Subscription::Flush,
        })
    }

    /// Takes a sample, or gives it back when there is no room; says how many older ones went for it. Never blocks.
    pub fn offer(&self, sample: Sample) -> (Result<(), Sample>, u64) {
        match self.send_now(sample) {
            None => (Ok(()), 0),
            Some(sample) => self.outbox.offer(sample),
        }
    }

    /// Sends a sample in the caller's thread when nothing is before it; gives it back otherwise.
    fn send_now(&self, sample: Sample) -> Option<Sample> {
        if !self.at_once {
            return Some(sample);
        }
        let mut wire = match self.wire.try_lock() {
            Ok(wire) => wire,
            Err(TryLockError::Poisoned(wire)) => wire.into_inner(),
            // The thread is sending.
            Err(TryLockError::WouldBlock) => return Some(sample),
        };
        if !wire.is_empty() || !self.outbox.is_empty() || self.outbox.closed().is_some() {
            return Some(sample);
        }
        wire.put(&sample);
        // The thread sends the rest, and meets the same error.
        if !wire.flush(&self.stream).unwrap_or(false) {
            self.outbox.wake();
        }
        None
    }

    /// Ends the connection and its thread. Never blocks: that thread says the good-bye.
    pub fn close(&self, parting: Parting) {
        self.outbox.close(parting);
        if parting == Parting::Loss || !self.good_bye {
            let _ = self.stream.shutdown(Shutdown::Both);
        }
    }

    /// Sends until the connection ends; says why it did. For a thread of its own.
    pub fn send(&self) -> Ended {
        let ended = self.send_all().unwrap_or_else(|error| {
            if self.outbox.closed().is_some() {
                Ended::Here
            } else {
                self.judge(&error.to_string())
            }
        });
        let _ = self.stream.shutdown(Shutdown::Both);
        ended
    }

    fn send_all(&self) -> io::Result<Ended> {
        let mut tick = self.outbox.period().map(|period| Instant::now() + period);
        let mut asked = Asked::None;
        let mut parted = false;
        loop {
            let sent = self.pump()?;
            if self.outbox.closed().is_some() && sent {
                if parted || !self.good_bye {
                    return Ok(Ended::Here);
                }
                lock(&self.wire).mark(GOOD_BYE);
                parted = true;
                continue;
            }
            // One answer at a time, whatever the other end asks for.
            let readable = self.poll(!sent, sent || !self.pulled, tick, asked)?;
            if readable && let Some(ended) = self.hear(&mut asked)? {
                return Ok(ended);
            }
            self.answer(&mut asked);
            if let (Some(at), Some(period)) = (tick, self.outbox.period())
                && Instant::now() >= at
            {
                self.outbox.tick();
                // A tick that was missed is not made up for.
                tick = Some((at + period).max(Instant::now()));
            }
        }
    }

    /// Sends what may leave now; true when the socket took it all.
    fn pump(&self) -> io::Result<bool> {
        let mut wire = lock(&self.wire);
        loop {
            while !wire.is_full() && !self.pulled && self.outbox.closed().is_none() {
                match self.outbox.next() {
                    Some(sample) => wire.put(&sample),
                    None => break,
                }
            }
            if wire.is_empty() {
                return Ok(true);
            }
            if !wire.flush(&self.stream)? {
                return Ok(false);
            }
        }
    }

    /// Waits until there is something to do; true when the other end has sent something, or has gone.
    fn poll(
        &self,
        full: bool,
        listens: bool,
        tick: Option<Instant>,
        asked: Asked,
    ) -> io::Result<bool> {
        let left = match self.outbox.closed() {
            None => {
                let next = tick.into_iter().chain(asked).min();
                next.map(|at| at.saturating_duration_since(Instant::now()))
            }
            Some(since) => {
                let left = PARTING.checked_sub(since.elapsed());
                Some(left.ok_or(io::ErrorKind::TimedOut)?)
            }
        };
        let timeout = left.map(|left| Timespec {
            tv_sec: left.as_secs().try_into().unwrap_or(i64::MAX),
            tv_nsec: left.subsec_nanos().into(),
        });
        let filled = self.outbox.filled();
        let mut wanted = PollFlags::empty();
        wanted.set(PollFlags::OUT, full);
        wanted.set(PollFlags::IN, listens);
        let mut fds = [
            PollFd::new(&self.stream, wanted),
            PollFd::new(&filled, PollFlags::IN),
        ];
        match poll(&mut fds, timeout.as_ref()) {
            Ok(_) | Err(Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        let [stream, filled] = fds.map(|fd| fd.revents());
        if !filled.is_empty() {
            self.outbox.awake();
        }
        Ok(stream.intersects(!PollFlags::OUT))
    }

    /// What the other end says: its end, or that it wants a sample.
    fn hear(&self, asked: &mut Asked) -> io::Result<Option<Ended>> {
        let mut byte = [0];
        let ended = match recv(&self.stream, &mut byte, RecvFlags::DONTWAIT) {
            Err(Errno::AGAIN | Errno::INTR) => return Ok(None),
            Ok((1.., _)) if self.pulled && matches!(byte[0], FETCH_FIRST | FETCH_MORE) => {
                self.fetch(byte[0] == FETCH_FIRST, asked);
                return Ok(None);
            }
            Ok((1.., _)) => Ended::GoodBye,
            _ if !self.good_bye => Ended::Lost(SILENT_END.to_owned()),
            Ok(_) => Ended::Lost("the other end closed the connection".to_owned()),
            Err(error) => Ended::Lost(io::Error::from(error).to_string()),
        };
        let here = self.outbox.closed().is_some();
        Ok(Some(if here { Ended::Here } else { ended }))
    }

    fn fetch(&self, first: bool, asked: &mut Asked) {
        match self.outbox.fetch(first) {
            Fetched::Sample(sample) => lock(&self.wire).put(&sample),
            Fetched::Wait(time) => *asked = Some(Instant::now() + time),
            Fetched::Nothing => lock(&self.wire).mark(EMPTY),
        }
    }

    /// Answers a reader that waits, once there is a sample or its time is over.
    fn answer(&self, asked: &mut Asked) {
        let Some(until) = *asked else {
            return;
        };
        if lock(&self.wire).is_full() {
            return;
        }
        match self.outbox.fetch(true) {
            Fetched::Sample(sample) => lock(&self.wire).put(&sample),
            Fetched::Wait(_) if Instant::now() < until => return,
            Fetched::Wait(_) | Fetched::Nothing => lock(&self.wire).mark(EMPTY),
        }
        *asked = None;
    }

    /// Why the other end has gone, after an error.
    fn judge(&self, otherwise: &str) -> Ended {
        match recv(&self.stream, &mut [0], RecvFlags::DONTWAIT) {
            Ok((1.., _)) if !self.pulled => Ended::GoodBye,
            _ if !self.good_bye => Ended::Lost(SILENT_END.to_owned()),
            _ => Ended::Lost(otherwise.to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::thread;

    use super::*;
    use crate::data::Payload;
    use crate::data::in_port::InPort;
    use crate::data::receive::receive;
    use crate::data::source::Source;
    use rts_schemas::connector::PushPolicy;

    const AGREED: Agreed = Agreed {
        good_bye: true,
        stamped: true,
    };

    /// One whose writer sends, and one whose thread does.
    fn both() -> [ConnectorSettings; 2] {
        let published = ConnectorSettings {
            subscription: Subscription::New(PushPolicy::All),
            ..ConnectorSettings::default()
        };
        [ConnectorSettings::default(), published]
    }

    fn sender(stream: UnixStream) -> Arc<Sender> {
        Arc::new(Sender::new(stream, AGREED, &both()[0]).unwrap())
    }

    fn push(sender: &Sender, sequence: u64, payload: Payload) -> u64 {
        let (offered, drops) = sender.offer(Sample {
            sequence,
            written: 1,
            payload,
        });
        offered.unwrap();
        drops
    }

    fn open(port: &InPort) -> Arc<Source> {
        let source = Arc::new(Source::new(None, ConnectorSettings::default(), None));
        port.open(&source);
        source
    }

    #[test]
    fn samples_of_all_sizes_pass_and_both_ends_notice_the_end() {
        for settings in both() {
            let (left, right) = UnixStream::pair().unwrap();
            let sender = Arc::new(Sender::new(left, AGREED, &settings).unwrap());
            let thread = thread::spawn({
                let sender = Arc::clone(&sender);
                move || sender.send()
            });
            let port = Arc::new(InPort::new("in", "T"));
            let source = open(&port);
            let receiver = thread::spawn({
                let (port, source) = (Arc::clone(&port), Arc::clone(&source));
                move || receive(&right, &port, &source, AGREED)
            });
            let sizes = [0, 10, 40_000, 1 << 20, 1, 32_767, 32_768, 65_536];
            for (sequence, size) in (1..).zip(sizes) {
                let payload = vec![size as u8; size];
                assert_eq!(push(&sender, sequence, payload.into()), 0);
            }
            for size in sizes {
                let payload = loop {
                    port.begin();
                    match port.read().sample() {
                        Some(payload) => break payload,
                        None => thread::yield_now(),
                    }
                };
                assert_eq!(payload.len(), size);
                assert!(payload.iter().all(|byte| *byte == size as u8));
            }
            assert_eq!(source.counts().gaps, 0);
            sender.close(Parting::GoodBye);
            assert_eq!(receiver.join().unwrap(), Ended::GoodBye);
            assert_eq!(thread.join().unwrap(), Ended::Here);
        }
    }

    /// A sender whose receiver ended by `end`, with samples under way that it never read.
    fn ended(end: impl FnOnce(&Source)) -> Ended {
        let (left, right) = UnixStream::pair().unwrap();
        let sender = sender(left);
        let source = Source::new(Some(right), ConnectorSettings::default(), None);
        for sequence in 1..10 {
            push(&sender, sequence, vec![0; 1 << 20].into());
        }
        let thread = thread::spawn(move || sender.send());
        thread::sleep(Duration::from_millis(20));
        end(&source);
        drop(source);
        thread.join().unwrap()
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
        let agreed = Agreed::default();
        let sender = Sender::new(left, agreed, &both()[0]).unwrap();
        drop(right);
        assert_eq!(sender.send(), Ended::Lost(SILENT_END.to_owned()));
    }

    #[test]
    fn one_that_is_closed_does_not_wait_for_a_receiver_that_stalls() {
        let (left, _right) = UnixStream::pair().unwrap();
        let sender = sender(left);
        push(&sender, 1, vec![0; 1 << 24].into());
        let thread = thread::spawn({
            let sender = Arc::clone(&sender);
            move || sender.send()
        });
        thread::sleep(Duration::from_millis(20));
        let begin = Instant::now();
        sender.close(Parting::GoodBye);
        assert_eq!(thread.join().unwrap(), Ended::Here);
        assert!(begin.elapsed() < Duration::from_secs(10));
    }

    #[test]
    fn what_is_queued_while_the_last_write_waits_for_room_is_sent() {
        let (left, right) = UnixStream::pair().unwrap();
        let sender = Arc::new(Sender::new(left, AGREED, &both()[1]).unwrap());
        let thread = thread::spawn({
            let sender = Arc::clone(&sender);
            move || sender.send()
        });
        // Nobody reads: each is taken from the queue before the next comes, until one finds no room, as the last of its
        // write. Then one more comes.
        let mut sent = 0;
        let taken = |sender: &Sender| {
            let begin = Instant::now();
            while begin.elapsed() < Duration::from_millis(100) {
                if sender.outbox.is_empty() {
                    return true;
                }
                thread::sleep(Duration::from_millis(1));
            }
            false
        };
        while taken(&sender) {
            sent += 1;
            assert_eq!(push(&sender, sent, vec![0; 30_000].into()), 0);
        }
        let port = Arc::new(InPort::new("in", "T"));
        let source = open(&port);
        let receiver = thread::spawn({
            let (port, source) = (Arc::clone(&port), Arc::clone(&source));
            move || receive(&right, &port, &source, AGREED)
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
        sender.close(Parting::GoodBye);
        assert_eq!(receiver.join().unwrap(), Ended::GoodBye);
        assert_eq!(thread.join().unwrap(), Ended::Here);
    }

    #[test]
    fn a_stalled_receiver_costs_the_oldest_samples_and_blocks_nobody() {
        let (left, right) = UnixStream::pair().unwrap();
        let sender = sender(left);
        let thread = thread::spawn({
            let sender = Arc::clone(&sender);
            move || sender.send()
        });
        let payload = Payload::from(vec![0; 1 << 20]);
        let drops: u64 = (1..200)
            .map(|sequence| push(&sender, sequence, payload.clone()))
            .sum();
        assert!(drops > 100, "{drops}");
        drop(right);
        assert!(matches!(thread.join().unwrap(), Ended::Lost(_)));
    }
}
