//! A process as its own tasks have it. What they do stops where it is when the process ends, and waits while it hangs.

use std::future::pending;
use std::sync::Arc;

use tokio::sync::watch;

use super::Shared;
use super::state::{Process, Run, State};

/// A process from within. Clones are the same process.
#[derive(Clone)]
pub(super) struct Handle {
    pub shared: Arc<Shared>,
    pub number: u64,
    run: watch::Receiver<Run>,
}

impl Handle {
    pub fn new(shared: Arc<Shared>, process: &Process) -> Self {
        Self {
            shared,
            number: process.number,
            run: process.run.subscribe(),
        }
    }

    /// Does something besides, as long as the process lives.
    pub fn spawn(&self, work: impl Future<Output = ()> + Send + 'static) {
        let handle = self.clone();
        tokio::spawn(async move {
            tokio::select! {
                biased;
                () = handle.ended() => {}
                () = work => {}
            }
        });
    }

    /// How it is.
    pub fn now(&self) -> Run {
        *self.run.borrow()
    }

    /// Waits until it has ended.
    pub async fn ended(&self) {
        let mut run = self.run.clone();
        // The sender goes after the end only.
        let _ = run.wait_for(|run| matches!(run, Run::Ended(_))).await;
    }

    /// Waits while it hangs, and for ever once it has ended.
    pub async fn runs(&self) {
        let mut run = self.run.clone();
        let runs = run.wait_for(|run| *run != Run::Hangs).await;
        if !runs.is_ok_and(|run| *run == Run::Runs) {
            pending::<()>().await;
        }
    }

    /// Takes some time, in microseconds from and to.
    pub async fn work(&self, low: u64, high: u64) {
        self.shared.pause(low, high).await;
        self.runs().await;
    }

    /// Looks at everything on the machine, or changes it.
    pub fn change<T>(&self, change: impl FnOnce(&mut State) -> T) -> T {
        self.shared.change(change)
    }

    /// The same with this process; none once it has ended.
    pub fn with<T>(&self, change: impl FnOnce(&mut Process) -> T) -> Option<T> {
        let number = self.number;
        self.change(|state| state.living(number).map(change))
    }
}
