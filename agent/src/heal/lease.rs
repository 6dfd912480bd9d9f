//! The session with the controller as a lease: while it is alive, the controller decides and the agent does not.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use tokio::sync::watch;
use tokio::time::Instant;

/// When the controller was heard of last.
#[derive(Debug)]
pub(crate) struct Lease {
    /// The start of the agent counts as the first sign.
    last: watch::Sender<Instant>,
    /// Another agent of this node has the session: it decides, or its controller does.
    superseded: AtomicBool,
}

impl Default for Lease {
    fn default() -> Self {
        Self {
            last: watch::Sender::new(Instant::now()),
            superseded: AtomicBool::new(false),
        }
    }
}

impl Lease {
    /// The controller has answered.
    pub fn sign(&self) {
        self.last.send_replace(Instant::now());
    }

    /// Another agent has taken over.
    pub fn superseded(&self) {
        self.superseded.store(true, Ordering::Relaxed);
    }

    /// True when the controller was not heard of for so long.
    pub fn is_free(&self, after: Duration) -> bool {
        !self.superseded.load(Ordering::Relaxed) && self.last.borrow().elapsed() > after
    }

    /// Rings with each sign from now on.
    pub fn signs(&self) -> watch::Receiver<Instant> {
        self.last.subscribe()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn it_is_free_when_the_controller_was_silent_and_nobody_took_over() {
        let lease = Lease::default();
        let after = Duration::from_secs(3);
        assert!(!lease.is_free(after));
        tokio::time::advance(Duration::from_secs(4)).await;
        assert!(lease.is_free(after));
        let mut signs = lease.signs();
        lease.sign();
        assert!(signs.has_changed().unwrap());
        signs.mark_unchanged();
        assert!(!lease.is_free(after));
        tokio::time::advance(Duration::from_secs(4)).await;
        assert!(lease.is_free(after));
        lease.superseded();
        assert!(!lease.is_free(after));
    }
}
