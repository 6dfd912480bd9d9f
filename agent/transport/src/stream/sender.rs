//! The sending end of frames.
//!
//! A sample is written by who pushes it, as far as there is room. When the rest of one has to wait, a thread of the
//! connection is started, which writes it; no other sample is taken until that is done.

use std::io;
use std::os::fd::BorrowedFd;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::pending::Pending;
use super::{LOOK, Sink};
use crate::ends::End;
use crate::frame::{Framing, Head};
use crate::socket::has_gone;
use crate::{Ended, Handle, MAX_SAMPLE, Parting, Question, Refused, Sample, Sender, lock};

/// A connection that is closed has this long to take what is half sent, and the good-bye.
const PARTING: Duration = Duration::from_millis(500);

/// Sends samples as frames.
#[derive(Debug)]
pub struct StreamSender<S: Sink>(Arc<Shared<S>>);

#[derive(Debug)]
struct Shared<S> {
    sink: S,
    framing: Framing,
    state: Mutex<State>,
    /// There is something for the thread, or it has ended.
    work: Condvar,
}

#[derive(Debug, Default)]
struct State {
    /// The frame that has begun.
    pending: Option<Pending>,
    /// Since when the connection is to end with a good-bye.
    leaving: Option<Instant>,
    good_bye_is_pending: bool,
    ended: Option<Ended>,
    /// The thread was started.
    has_thread: bool,
}

/// How far writing got.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pumped {
    /// All is written.
    Idle,
    /// There is no room for the rest.
    Blocked,
    /// The connection has ended.
    Ended,
}

impl<S: Sink> StreamSender<S> {
    /// Over a sink whose other end has agreed.
    pub fn new(sink: S, framing: Framing) -> Self {
        Self(Arc::new(Shared {
            sink,
            framing,
            state: Mutex::default(),
            work: Condvar::new(),
        }))
    }

    /// Writes a sample as far as there is room. `Blocked` when it has begun and is not done.
    fn begin(&self, state: &mut State, sample: Sample) -> Result<Pumped, Refused> {
        if sample.payload.len() > MAX_SAMPLE {
            return Err(Refused::TooLarge(sample.payload.len()));
        }
        let is_full = state.pending.is_some() && self.0.pump(state) == Pumped::Blocked;
        if let Some(ended) = state.ended() {
            return Err(Refused::Ended(ended));
        }
        if is_full {
            return Err(Refused::Full(sample));
        }
        let head = Head::of(&sample, self.0.framing);
        let size = head.bytes().len() + sample.payload.len();
        match self.0.write(state, head.bytes(), &sample.payload) {
            Err(ended) => Err(Refused::Ended(ended)),
            Ok(0) => Err(Refused::Full(sample)),
            Ok(gone) if gone == size => Ok(Pumped::Idle),
            Ok(gone) => {
                state.pending = Some(Pending::sample(sample, head, gone));
                match self.0.pump(state) {
                    Pumped::Ended => Err(Refused::Ended(state.ended().unwrap_or(Ended::Here))),
                    pumped => Ok(pumped),
                }
            }
        }
    }

    /// Writes the rest of the sample that has begun, until then; later the thread does.
    fn finish(&self, until: Option<Instant>) {
        loop {
            let waited = match left(until) {
                Duration::ZERO => Err(io::ErrorKind::TimedOut.into()),
                left => self.0.sink.wait(left.min(LOOK)),
            };
            let mut state = lock(&self.0.state);
            if self.0.pump(&mut state) != Pumped::Blocked {
                return;
            }
            if waited.is_err() || state.leaving.is_some() {
                return self.0.leave_to_thread(&mut state);
            }
        }
    }
}

/// Time until then; none is for ever.
fn left(until: Option<Instant>) -> Duration {
    until.map_or(Duration::MAX, |until| {
        until.saturating_duration_since(Instant::now())
    })
}

impl State {
    fn ended(&self) -> Option<Ended> {
        let leaves = || self.leaving.map(|_| Ended::Here);
        self.ended.clone().or_else(leaves)
    }
}

impl<S: Sink> Shared<S> {
    /// Writes what is pending, and the good-bye when it is to be said.
    fn pump(&self, state: &mut State) -> Pumped {
        loop {
            if state.ended.is_some() {
                return Pumped::Ended;
            }
            let Some(pending) = &mut state.pending else {
                match (state.leaving, state.good_bye_is_pending) {
                    (None, _) => return Pumped::Idle,
                    (Some(_), false) if self.framing.has_good_byes() => {
                        state.pending = Some(Pending::good_bye());
                        state.good_bye_is_pending = true;
                        continue;
                    }
                    (Some(_), _) => return self.end(state, Ended::Here),
                }
            };
            let (header, payload) = pending.rest();
            match self.sink.write(header, payload) {
                Ok(0) => return self.look(state).map_or(Pumped::Blocked, |_| Pumped::Ended),
                Ok(written) => {
                    if pending.advance(written) {
                        state.pending = None;
                    }
                }
                Err(error) => {
                    self.fail(state, &error);
                    return Pumped::Ended;
                }
            }
        }
    }

    /// Writes what there is room for, 0 when there is none.
    fn write(&self, state: &mut State, header: &[u8], payload: &[u8]) -> Result<usize, Ended> {
        match self.sink.write(header, payload) {
            Ok(0) => self.look(state).map_or(Ok(0), Err),
            Ok(written) => Ok(written),
            Err(error) => Err(self.fail(state, &error)),
        }
    }

    /// Why the connection has ended, if it has; asks the sink.
    fn look(&self, state: &mut State) -> Option<Ended> {
        if state.ended().is_none()
            && let Some(ended) = self.sink.look()
        {
            self.end(state, ended);
        }
        state.ended.clone()
    }

    /// The sink cannot be written to, or waited for.
    fn fail(&self, state: &mut State, error: &io::Error) -> Ended {
        let ended = self.sink.look().unwrap_or_else(|| Ended::lost(error));
        self.end(state, ended);
        state.ended().unwrap_or(Ended::Here)
    }

    fn end(&self, state: &mut State, ended: Ended) -> Pumped {
        state.pending = None;
        state.ended.get_or_insert(match state.leaving {
            Some(_) => Ended::Here,
            None => ended,
        });
        self.sink.shut();
        self.work.notify_all();
        Pumped::Ended
    }

    fn close(self: &Arc<Self>, parting: Parting) {
        let mut state = lock(&self.state);
        if state.ended().is_some() {
            return;
        }
        match parting {
            Parting::Loss => {
                self.end(&mut state, Ended::Here);
            }
            Parting::GoodBye => {
                state.leaving = Some(Instant::now());
                if self.pump(&mut state) == Pumped::Blocked {
                    self.leave_to_thread(&mut state);
                }
            }
        }
    }

    /// Lets the thread write what is pending.
    fn leave_to_thread(self: &Arc<Self>, state: &mut State) {
        self.work.notify_all();
        if state.has_thread {
            return;
        }
        let shared = Arc::clone(self);
        let thread = std::thread::Builder::new().name("rts-send".to_owned());
        match thread.spawn(move || shared.write_pending()) {
            Ok(_) => state.has_thread = true,
            Err(error) => {
                let text =
                    format!("no thread can be started here to send the rest of a sample: {error}");
                self.end(state, Ended::Lost(text));
            }
        }
    }

    /// The thread: writes what is pending, until the connection ends.
    fn write_pending(&self) {
        let mut state = lock(&self.state);
        loop {
            match self.pump(&mut state) {
                Pumped::Ended => return,
                Pumped::Idle => {
                    state = self
                        .work
                        .wait(state)
                        .unwrap_or_else(PoisonError::into_inner);
                }
                Pumped::Blocked => {
                    drop(state);
                    let waited = self.sink.wait(LOOK);
                    state = lock(&self.state);
                    self.judge(&mut state, waited);
                }
            }
        }
    }

    /// Ends what has waited too long with its good-bye, or cannot wait.
    fn judge(&self, state: &mut MutexGuard<'_, State>, waited: io::Result<()>) {
        if let Err(error) = waited {
            self.fail(state, &error);
        } else if state.leaving.is_some_and(|since| since.elapsed() > PARTING) {
            self.end(state, Ended::Here);
        }
    }
}

impl<S: Sink> Sender for StreamSender<S> {
    fn push(&mut self, sample: Sample) -> Result<(), Refused> {
        let mut state = lock(&self.0.state);
        if self.begin(&mut state, sample)? == Pumped::Blocked {
            self.0.leave_to_thread(&mut state);
        }
        Ok(())
    }

    fn push_within(&mut self, mut sample: Sample, patience: Duration) -> Result<(), Refused> {
        // Most samples need no clock.
        let mut until = None;
        loop {
            let begun = self.begin(&mut lock(&self.0.state), sample);
            let mut until = || *until.get_or_insert_with(|| Instant::now().checked_add(patience));
            match begun {
                Ok(Pumped::Blocked) => {
                    self.finish(until());
                    return Ok(());
                }
                Ok(_) => return Ok(()),
                Err(Refused::Full(back)) if !left(until()).is_zero() => sample = back,
                Err(refused) => return Err(refused),
            }
            // What cannot wait has ended, which is seen by the next look.
            let _ = self.0.sink.wait(left(until()).min(LOOK));
        }
    }

    fn ended(&mut self) -> Option<Ended> {
        let mut state = lock(&self.0.state);
        self.0.look(&mut state);
        state.ended()
    }

    fn asked(&mut self) -> Option<Question> {
        let mut state = lock(&self.0.state);
        self.0.look(&mut state);
        self.0.sink.asked()
    }

    fn linger(&mut self) {
        let state = lock(&self.0.state);
        let leaves = |state: &mut State| state.leaving.is_some() && state.ended.is_none();
        // The thread ends it in time; this is for one that does not get to run.
        drop(self.0.work.wait_timeout_while(state, 2 * PARTING, leaves));
    }

    fn handle(&self) -> Handle {
        Handle::new(Arc::new(This(Arc::clone(&self.0))))
    }
}

struct This<S>(Arc<Shared<S>>);

impl<S: Sink> End for This<S> {
    fn close(&self, parting: Parting) {
        self.0.close(parting);
    }

    fn watched(&self) -> Option<BorrowedFd<'_>> {
        Some(self.0.sink.fd())
    }

    fn has_gone(&self) -> bool {
        has_gone(self.0.sink.fd())
    }
}

impl<S: Sink> Drop for StreamSender<S> {
    fn drop(&mut self) {
        self.0.close(Parting::Loss);
    }
}
