//! The last changes, in order. A reader keeps its own place; one that falls behind the oldest has lost its way.

use std::collections::VecDeque;
use std::sync::Arc;

use rts_controller_api::objects::Kind;

/// One change, written once for all watchers.
#[derive(Debug)]
pub struct Change {
    /// Version after it.
    pub revision: u64,
    /// Kind of the object.
    pub kind: Kind,
    /// A [`rts_controller_api::watch::WatchEvent`].
    pub json: String,
}

/// The ring.
pub struct Ring {
    size: usize,
    /// Changes up to this revision are no longer here.
    forgotten: u64,
    changes: VecDeque<Arc<Change>>,
}

impl Ring {
    /// An empty ring that knows nothing of what happened up to `start`.
    pub fn new(size: usize, start: u64) -> Self {
        Self {
            size,
            forgotten: start,
            changes: VecDeque::new(),
        }
    }

    /// Appends a change and forgets the oldest one above the size.
    pub fn push(&mut self, change: Arc<Change>) {
        self.changes.push_back(change);
        if self.changes.len() > self.size
            && let Some(oldest) = self.changes.pop_front()
        {
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
