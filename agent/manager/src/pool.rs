//! Threads for requests and connections, so that one that waits keeps no other from running.
//!
//! Some are kept ready: while an initialiser hangs in dlopen, the C library lets no new thread get started.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::sync_channel;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use crate::sync::lock;

/// A thread that is not needed ends after this time.
const IDLE: Duration = Duration::from_secs(10);

/// A thread that has not started after this time is not waited for.
const STARTING: Duration = Duration::from_secs(5);

type Job = Box<dyn FnOnce() + Send>;

/// A pool that grows on demand up to a limit and shrinks when idle.
#[derive(Clone)]
pub struct Pool {
    shared: Arc<Shared>,
    name: &'static str,
    limit: usize,
}

/// No thread is free for a job.
#[derive(Debug)]
pub struct Full;

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    wake: Condvar,
    started: Condvar,
    spare: usize,
}

#[derive(Default)]
struct State {
    jobs: VecDeque<Job>,
    threads: usize,
    /// Threads that have started to run.
    ready: usize,
    busy: usize,
}

impl State {
    fn free(&self) -> usize {
        self.threads - self.busy
    }

    fn ready_and_free(&self) -> usize {
        self.ready - self.busy
    }
}

impl Pool {
    /// With at most `limit` threads, of which `spare` are kept for when none can be started. None is started yet.
    pub fn new(name: &'static str, limit: usize, spare: usize) -> Self {
        Self {
            shared: Arc::new(Shared {
                spare,
                ..Shared::default()
            }),
            name,
            limit,
        }
    }

    /// Starts the threads that are kept ready, as far as they are not there, and does not wait for them.
    pub fn prepare(&self) {
        self.prepare_for(0);
    }

    /// The same, and threads for so many jobs that will come.
    pub fn prepare_for(&self, jobs: usize) {
        let mut state = lock(&self.shared.state);
        let wanted = state.jobs.len() + jobs + self.shared.spare;
        self.grow(&mut state, wanted);
    }

    /// The same, and waits until they run: before anything that may keep new ones from starting.
    pub fn settle(&self) {
        self.prepare();
        let state = lock(&self.shared.state);
        let _ = self
            .shared
            .started
            .wait_timeout_while(state, STARTING, |state| state.ready < state.threads);
    }

    /// Runs a job on a thread of its own, or refuses when `limit` jobs run already, or when the pool may not grow and no more
    /// than `reserved` threads are ready: those are kept for jobs that reserve none.
    pub fn run(
        &self,
        may_grow: bool,
        reserved: usize,
        job: impl FnOnce() + Send + 'static,
    ) -> Result<(), Full> {
        let mut state = lock(&self.shared.state);
        state.jobs.push_back(Box::new(job));
        if may_grow {
            let wanted = state.jobs.len();
            self.grow(&mut state, wanted);
        }
        let free = match may_grow {
            true => state.free(),
            false => state.ready_and_free().saturating_sub(reserved),
        };
        if free < state.jobs.len() {
            state.jobs.pop_back();
            return Err(Full);
        }
        self.shared.wake.notify_one();
        Ok(())
    }

    /// Starts threads until so many are free, as far as that goes.
    fn grow(&self, state: &mut State, wanted: usize) {
        while state.free() < wanted && state.threads < self.limit {
            let shared = Arc::clone(&self.shared);
            let spawned = thread::Builder::new()
                .name(self.name.to_owned())
                .spawn(move || shared.work());
            if spawned.is_err() {
                break;
            }
            state.threads += 1;
        }
    }
}

impl Shared {
    fn work(&self) {
        // A first wait for a channel registers a thread-local destructor, which is what waits for a dlopen that hangs. A
        // channel without room waits even for no time at all.
        let (_sender, receiver) = sync_channel::<()>(0);
        let _ = receiver.recv_timeout(Duration::ZERO);
        lock(&self.state).ready += 1;
        self.started.notify_all();
        while let Some(job) = self.next() {
            // The panic hook has printed it; the thread is still good.
            let _ = catch_unwind(AssertUnwindSafe(job));
            lock(&self.state).busy -= 1;
        }
    }

    fn next(&self) -> Option<Job> {
        let mut state = lock(&self.state);
        loop {
            let (waited, idle) = self
                .wake
                .wait_timeout_while(state, IDLE, |state| state.jobs.is_empty())
                .unwrap_or_else(PoisonError::into_inner);
            state = waited;
            if let Some(job) = state.jobs.pop_front() {
                state.busy += 1;
                return Some(job);
            }
            if idle.timed_out() && state.free() > self.spare {
                state.threads -= 1;
                state.ready -= 1;
                return None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn jobs_do_not_wait_for_each_other_and_are_bounded() {
        let pool = Pool::new("job", 2, 0);
        let (started, starts) = mpsc::channel();
        let (release, gate) = mpsc::channel::<()>();
        let gate = Arc::new(Mutex::new(gate));
        for number in 0..2 {
            let (started, gate) = (started.clone(), Arc::clone(&gate));
            pool.run(true, 0, move || {
                started.send(number).unwrap();
                let _ = lock(&gate).recv();
            })
            .unwrap();
        }
        let mut both = [starts.recv().unwrap(), starts.recv().unwrap()];
        both.sort_unstable();
        assert_eq!(both, [0, 1]);
        assert!(pool.run(true, 0, || ()).is_err());

        release.send(()).unwrap();
        release.send(()).unwrap();
        let (done, finished) = mpsc::channel();
        while pool
            .run(true, 0, {
                let done = done.clone();
                move || done.send(()).unwrap()
            })
            .is_err()
        {
            thread::yield_now();
        }
        finished.recv().unwrap();
        assert!(lock(&pool.shared.state).threads <= 2);
    }

    #[test]
    fn a_pool_that_may_not_grow_uses_the_threads_that_are_ready() {
        let pool = Pool::new("job", 4, 2);
        assert!(pool.run(false, 0, || ()).is_err());
        pool.settle();
        let (done, finished) = mpsc::channel();
        let (release, gate) = mpsc::channel::<()>();
        let job = {
            let done = done.clone();
            move || {
                done.send(()).unwrap();
                let _ = gate.recv();
            }
        };
        pool.run(false, 1, job).unwrap();
        let refused = pool.run(false, 1, || panic!("takes what is reserved"));
        assert!(refused.is_err(), "one is kept for who ends something");
        pool.run(false, 0, move || done.send(()).unwrap()).unwrap();
        finished.recv().unwrap();
        finished.recv().unwrap();
        drop(release);
        pool.run(true, 0, || panic!("must cost no thread")).unwrap();
        let (done, finished) = mpsc::channel();
        pool.run(true, 0, move || done.send(()).unwrap()).unwrap();
        finished.recv().unwrap();
    }
}
