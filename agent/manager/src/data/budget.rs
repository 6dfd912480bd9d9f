//! How many bytes all queues of the process may hold together.

use std::sync::atomic::{AtomicUsize, Ordering};

/// A number of bytes that queues share.
#[derive(Debug)]
pub struct Budget {
    used: AtomicUsize,
    limit: usize,
}

/// The budget of this process, besides the bound of each queue.
pub static PROCESS: Budget = Budget::new(512 * 1024 * 1024);

/// Of the rings of shared memory that this process has made. A connector for which nothing is left goes without.
pub static RINGS: Budget = Budget::new(256 * 1024 * 1024);

/// Bytes of a budget; given back on drop.
#[derive(Debug)]
pub struct Share {
    budget: &'static Budget,
    bytes: usize,
}

impl Drop for Share {
    fn drop(&mut self) {
        self.budget.give(self.bytes);
    }
}

impl Budget {
    /// Of `limit` bytes.
    pub const fn new(limit: usize) -> Self {
        Self {
            used: AtomicUsize::new(0),
            limit,
        }
    }

    /// Takes bytes when they are left.
    pub fn take(&self, bytes: usize) -> bool {
        let taken = self
            .used
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |used| {
                used.checked_add(bytes).filter(|sum| *sum <= self.limit)
            });
        taken.is_ok()
    }

    /// Takes bytes for as long as the share is kept, when they are left.
    pub fn share(&'static self, bytes: usize) -> Option<Share> {
        // Not made when there is nothing to give back.
        self.take(bytes).then(|| Share {
            budget: self,
            bytes,
        })
    }

    /// Gives bytes back that were taken.
    pub fn give(&self, bytes: usize) {
        self.used.fetch_sub(bytes, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_is_taken_than_there_is() {
        let budget = Budget::new(10);
        assert!(budget.take(6));
        assert!(!budget.take(5));
        assert!(!budget.take(usize::MAX));
        assert!(budget.take(4));
        budget.give(6);
        assert!(budget.take(5));
    }

    #[test]
    fn a_share_is_given_back_when_it_is_dropped() {
        static BUDGET: Budget = Budget::new(10);
        let share = BUDGET.share(6).unwrap();
        assert!(BUDGET.share(6).is_none());
        drop(share);
        assert!(BUDGET.share(6).is_some());
    }
}
