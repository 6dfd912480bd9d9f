//! What must survive: systems, node generations, identity of the store. Durable before a call returns.
//!
//! Status is not here: it lives in memory and is rebuilt from inventories.

mod backup;
mod durable;
mod memory;
mod off_loop;
mod record;
mod redb;

#[cfg(test)]
mod conformance;

use std::path::PathBuf;

use futures_util::future::BoxFuture;

pub use self::backup::{Backup, BackupError};
pub use self::durable::Durable;
pub use self::memory::MemoryStore;
pub use self::off_loop::OffLoop;
pub use self::record::{NodeGeneration, Records, Restored, State, SystemRecord, Write};
pub use self::redb::{RedbStore, nodes_of, numbers_of};

/// Version of the tables. A store with a higher one is refused.
pub const SCHEMA_VERSION: u32 = 3;

/// A store that cannot be opened, read or written.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A later program wrote it.
    #[error(
        "{} has schema version {found}, and this program knows {SCHEMA_VERSION}: upgrade rts-controller, or move the file away to start afresh", path.display()
    )]
    FutureSchema {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u32,
    },
    /// No space is left for it.
    #[error(
        "the disk of the store {} is full, and nothing was changed; free some space there and try again", path.display()
    )]
    Full {
        /// The file.
        path: PathBuf,
    },
    /// It is no store, or was damaged by others.
    #[error(
        "the store {} is damaged ({reason}); put a backup back with `rtsctl controller restore`, or, without one, end everything with `rtsctl down --purge` and apply the systems again", path.display()
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The file or disk failed.
    #[error("cannot {what} the store {}", path.display())]
    Failed {
        /// What was being tried (`open`, `write`).
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl StoreError {
    /// The task that made a call panicked, or the program ends.
    pub(crate) fn cut_off(error: tokio::task::JoinError) -> Self {
        Self::Failed {
            what: "write",
            path: "state/controller.redb".into(),
            source: Box::new(error),
        }
    }
}

/// The store. Its calls may take long, and do not block; [`Durable`] makes one after the other, each to its end.
///
/// A call that failed changed nothing, and the next one is tried afresh.
pub trait Store: Send + Sync + 'static {
    /// Sees whether it can be read and, after a write failed, written again.
    fn check(&self) -> BoxFuture<'_, Result<(), StoreError>> {
        Box::pin(async { self.load().await.map(drop) })
    }
    /// Everything in it.
    fn load(&self) -> BoxFuture<'_, Result<State, StoreError>>;
    /// Makes all these changes, or none.
    fn write(&self, writes: Vec<Write>) -> BoxFuture<'_, Result<(), StoreError>>;
}
