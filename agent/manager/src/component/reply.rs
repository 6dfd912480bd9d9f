//! The answer of an execution context to whoever asked it, who may wait for several at once.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, sync_channel};
use std::thread::Thread;
use std::time::Instant;

use rts_manager_api::control::Failure;

/// How a request ended.
pub type Answer = Result<(), Failure>;

/// Who asked has given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GivenUp;

/// The way back for one answer.
#[derive(Debug)]
pub struct Reply {
    /// Taken before the thread is woken: it must see that no answer comes.
    answer: Option<SyncSender<Answer>>,
    /// Woken when there is an answer, or none will come.
    waker: Option<Thread>,
}

impl Reply {
    /// Gives the answer.
    pub fn send(mut self, answer: Answer) -> Result<(), GivenUp> {
        let way = self.answer.take().ok_or(GivenUp)?;
        way.send(answer).map_err(|_| GivenUp)
    }
}

impl Drop for Reply {
    fn drop(&mut self) {
        drop(self.answer.take());
        if let Some(thread) = &self.waker {
            thread.unpark();
        }
    }
}

/// An answer that is being waited for.
#[derive(Debug)]
pub struct Pending {
    answer: Receiver<Answer>,
    /// So long it is waited for.
    pub deadline: Instant,
}

/// Why there is no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Missing {
    /// It may still come.
    Yet,
    /// The deadline has passed.
    Late,
    /// None will come: its component is gone.
    Gone,
}

/// A way back, and its end. With a `waker` that thread is unparked when it is worth a look ([`Pending::look`]).
pub fn reply(deadline: Instant, waker: Option<Thread>) -> (Reply, Pending) {
    let (sender, answer) = sync_channel(1);
    let reply = Reply {
        answer: Some(sender),
        waker,
    };
    (reply, Pending { answer, deadline })
}

impl Pending {
    /// Waits until the deadline.
    pub fn wait(&self) -> Result<Answer, Missing> {
        let left = self.deadline.saturating_duration_since(Instant::now());
        self.answer.recv_timeout(left).map_err(|e| match e {
            RecvTimeoutError::Timeout => Missing::Late,
            RecvTimeoutError::Disconnected => Missing::Gone,
        })
    }

    /// Looks, and does not wait.
    pub fn look(&self) -> Result<Answer, Missing> {
        self.answer.try_recv().map_err(|e| match e {
            TryRecvError::Disconnected => Missing::Gone,
            TryRecvError::Empty if Instant::now() >= self.deadline => Missing::Late,
            TryRecvError::Empty => Missing::Yet,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::thread;
    use std::time::Duration;

    use super::*;

    #[test]
    fn who_waits_for_several_is_woken_by_each_and_by_one_that_will_never_come() {
        let deadline = Instant::now() + Duration::from_secs(60);
        let make = || reply(deadline, Some(thread::current()));
        let ((answers, answered), (gone, never)) = (make(), make());
        assert_eq!(answered.look(), Err(Missing::Yet));
        let others = thread::spawn(move || {
            answers.send(Ok(())).unwrap();
            drop(gone);
        });
        let (mut first, mut second) = (answered.look(), never.look());
        while (&first, &second) != (&Ok(Ok(())), &Err(Missing::Gone)) {
            thread::park_timeout(Duration::from_secs(60));
            first = first.or_else(|_| answered.look());
            second = never.look();
            assert!(Instant::now() < deadline, "nobody woke it");
        }
        others.join().unwrap();
    }

    #[test]
    fn who_answers_learns_that_nobody_waits() {
        let (late, pending) = reply(Instant::now(), None);
        assert_eq!(pending.look(), Err(Missing::Late));
        assert_eq!(pending.wait(), Err(Missing::Late));
        drop(pending);
        assert_eq!(late.send(Ok(())), Err(GivenUp));
    }
}
