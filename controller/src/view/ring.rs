//! The last changes, in order. A reader keeps its own place; one that falls behind the oldest has lost its way.

use std::collections::VecDeque;
use std::sync::Arc;

use rts_controller_api::objects::Kind;

use super::change::Change;

/// The ring.
pub struct Ring {
    size: usize,
    /// Most bytes of all changes.
    most: usize,
    bytes: usize,
    /// Changes up to this revision are no longer here.
    forgotten: u64,
    changes: VecDeque<Arc<Change>>,
}

impl Ring {
    /// An empty ring that knows nothing of what happened up to `start`.
    pub fn new(size: usize, most: usize, start: u64) -> Self {
        Self {
            size,
            most,
            bytes: 0,
            forgotten: start,
            changes: VecDeque::new(),
        }
    }

    /// Appends a change and forgets the oldest ones above the sizes; the newest stays, however large.
    pub fn push(&mut self, change: Arc<Change>) {
        self.bytes += change.weight();
        self.changes.push_back(change);
        while self.changes.len() > self.size || (self.bytes > self.most && self.changes.len() > 1) {
            let Some(oldest) = self.changes.pop_front() else {
                break;
            };
            self.bytes -= oldest.weight();
            self.forgotten = oldest.revision;
        }
    }

    /// Changes of a kind after a revision; none when some may be forgotten.
    pub fn after(&self, kind: Kind, revision: u64) -> Option<Vec<Arc<Change>>> {
        if revision < self.forgotten {
            return None;
        }
        let from = self.changes.partition_point(|c| c.revision <= revision);
        let changes = self.changes.iter().skip(from);
        Some(changes.filter(|c| c.kind == kind).cloned().collect())
    }
}

#[cfg(test)]
mod tests {
    use rts_controller_api::watch::WatchType;

    use super::*;

    fn change(revision: u64, bytes: usize) -> Arc<Change> {
        Arc::new(Change::of(
            WatchType::Added,
            revision,
            Kind::System,
            Arc::new(()),
            bytes,
        ))
    }

    #[test]
    fn few_large_changes_are_forgotten_like_many_small_ones() {
        let mut ring = Ring::new(10, 100, 0);
        for revision in 1..=4 {
            ring.push(change(revision, 40));
        }
        assert_eq!((ring.changes.len(), ring.bytes), (2, 80));
        assert!(ring.after(Kind::System, 1).is_none());
        assert_eq!(ring.after(Kind::System, 2).map(|c| c.len()), Some(2));
        ring.push(change(5, 1000));
        assert_eq!((ring.changes.len(), ring.bytes), (1, 1000));
        assert!(ring.after(Kind::System, 3).is_none());
        for revision in 6..=20 {
            ring.push(change(revision, 1));
        }
        assert_eq!((ring.changes.len(), ring.bytes), (10, 10));
    }
}
