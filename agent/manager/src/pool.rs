//! Threads that carry out requests, so that one that waits for a component keeps no other from running.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use crate::sync::lock;

/// An idle thread ends after this time.
const IDLE: Duration = Duration::from_secs(10);

type Job = Box<dyn FnOnce() + Send>;

/// A pool that grows on demand up to a limit and shrinks when idle.
#[derive(Clone)]
pub struct Pool {
    shared: Arc<Shared>,
    limit: usize,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    wake: Condvar,
}

#[derive(Default)]
struct State {
    jobs: VecDeque<Job>,
    threads: usize,
    idle: usize,
}

impl Pool {
    /// With at most `limit` threads. None is started yet.
    pub fn new(limit: usize) -> Self {
        Self {
            shared: Arc::default(),
            limit,
        }
    }

    /// Runs a job on a thread of its own, or refuses when `limit` jobs run already.
    pub fn run(&self, job: impl FnOnce() + Send + 'static) -> Result<(), &'static str> {
        let mut state = lock(&self.shared.state);
        if state.idle > state.jobs.len() {
            state.jobs.push_back(Box::new(job));
            self.shared.wake.notify_one();
            return Ok(());
        }
        if state.threads >= self.limit {
            return Err("too many requests are under way");
        }
        state.threads += 1;
        drop(state);
        let shared = Arc::clone(&self.shared);
        let spawned = thread::Builder::new()
            .name("request".to_owned())
            .spawn(move || {
                job();
                shared.work();
            });
        if spawned.is_err() {
            lock(&self.shared.state).threads -= 1;
            return Err("no thread could be started");
        }
        Ok(())
    }
}

impl Shared {
    fn work(&self) {
        while let Some(job) = self.next() {
            job();
        }
    }

    fn next(&self) -> Option<Job> {
        let mut state = lock(&self.state);
        state.idle += 1;
        let (mut state, _) = self
            .wake
            .wait_timeout_while(state, IDLE, |state| state.jobs.is_empty())
            .unwrap_or_else(PoisonError::into_inner);
        state.idle -= 1;
        let job = state.jobs.pop_front();
        if job.is_none() {
            state.threads -= 1;
        }
        job
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn jobs_do_not_wait_for_each_other_and_are_bounded() {
        let pool = Pool::new(2);
        let (started, starts) = mpsc::channel();
        let (release, gate) = mpsc::channel::<()>();
        let gate = Arc::new(Mutex::new(gate));
        for number in 0..2 {
            let (started, gate) = (started.clone(), Arc::clone(&gate));
            pool.run(move || {
                started.send(number).unwrap();
                let _ = lock(&gate).recv();
            })
            .unwrap();
        }
        let mut both = [starts.recv().unwrap(), starts.recv().unwrap()];
        both.sort_unstable();
        assert_eq!(both, [0, 1]);
        assert!(pool.run(|| ()).is_err());

        release.send(()).unwrap();
        release.send(()).unwrap();
        let (done, finished) = mpsc::channel();
        while pool
            .run({
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
}
