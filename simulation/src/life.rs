//! The life of a program, from its start to its crash. A dead program can do nothing: its calls to the outside never
//! return, and nothing from outside reaches it. What its tasks still think does not matter to anybody.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::Notify;

/// One life of one program. Clones are the same life.
#[derive(Clone)]
pub struct Life(Arc<Inner>);

struct Inner {
    host: String,
    number: u32,
    dead: AtomicBool,
    /// Wakes those who wait for the crash in the order in which they came; a `watch` channel wakes them in any.
    crashed: Notify,
    /// Calls to the outside until it crashes.
    fuse: Mutex<Option<u64>>,
}

impl fmt::Debug for Life {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}#{}", self.0.host, self.0.number)
    }
}

impl Life {
    /// The `number`th life of the program of a host (`controller`, or a node's agent by the node's name).
    pub fn new(host: impl Into<String>, number: u32) -> Self {
        Self(Arc::new(Inner {
            host: host.into(),
            number,
            dead: AtomicBool::new(false),
            crashed: Notify::new(),
            fuse: Mutex::new(None),
        }))
    }

    /// Whose.
    pub fn host(&self) -> &str {
        &self.0.host
    }

    /// The how manieth.
    pub fn number(&self) -> u32 {
        self.0.number
    }

    /// True after its crash.
    pub fn is_over(&self) -> bool {
        self.0.dead.load(Ordering::SeqCst)
    }

    /// The crash, now.
    pub fn end(&self) {
        self.0.dead.store(true, Ordering::SeqCst);
        self.0.crashed.notify_waiters();
    }

    /// Lets it crash when it comes to its `calls`th passage to or from the outside, the first being 1.
    pub fn burn(&self, calls: u64) {
        *self.0.fuse.lock().unwrap_or_else(PoisonError::into_inner) = Some(calls);
    }

    /// Waits for the crash.
    pub async fn over(&self) {
        let crashed = self.0.crashed.notified();
        if !self.is_over() {
            crashed.await;
        }
    }

    /// A passage to or from the outside: the crash may come here. Never returns in a life that is over.
    pub async fn pass(&self) {
        {
            let mut fuse = self.0.fuse.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(left) = fuse.as_mut() {
                *left = left.saturating_sub(1);
                if *left == 0 {
                    *fuse = None;
                    self.end();
                }
            }
        }
        if self.is_over() {
            std::future::pending::<()>().await;
        }
    }

    /// A call to the outside. Where the crash comes meanwhile, the work stops where it is.
    pub async fn call<T>(&self, work: impl Future<Output = T>) -> T {
        self.pass().await;
        let done = tokio::select! {
            biased;
            () = self.over() => std::future::pending().await,
            done = work => done,
        };
        self.pass().await;
        done
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::time::Duration;

    use tokio::time::{sleep, timeout};

    use super::*;

    #[tokio::test(start_paused = true)]
    async fn a_dead_program_gets_no_answer() {
        let life = Life::new("node1", 1);
        assert_eq!(life.call(async { 1 }).await, 1);
        let slow = life.call(sleep(Duration::from_secs(1)));
        let end = async {
            sleep(Duration::from_millis(500)).await;
            life.end();
            std::future::pending::<()>().await;
        };
        let both = async { tokio::join!(slow, end) };
        assert!(timeout(Duration::from_secs(9), both).await.is_err());
        assert!(timeout(Duration::from_secs(9), life.pass()).await.is_err());
    }

    #[tokio::test(start_paused = true)]
    async fn a_fuse_ends_it_before_or_after_a_call() {
        for (calls, effects) in [(1, 0), (2, 1), (3, 1), (4, 2)] {
            let life = Life::new("node1", 1);
            life.burn(calls);
            let done = AtomicU32::new(0);
            let work = async {
                for _ in 0..2 {
                    let effect = async { done.fetch_add(1, Ordering::SeqCst) };
                    life.call(effect).await;
                }
            };
            assert!(timeout(Duration::from_secs(9), work).await.is_err());
            assert_eq!(done.into_inner(), effects, "{calls}");
        }
    }
}
