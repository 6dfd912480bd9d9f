//! The store in one redb file. Every write is one transaction, on the disk before it returns.
//!
//! After an I/O error redb refuses everything until its file is closed and opened anew, which is done here.

mod file;
mod migrate;
mod rows;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use redb::{Database, Error, ReadableDatabase, ReadableTable};
use serde::de::IgnoredAny;

use self::rows::{
    CLUSTER_UID, Change, EPOCH, INDEXES, META, NODES, PROBE, RESTORED, REVISIONS, SYSTEMS,
};
use super::{State, StoreError, Write};

/// The store. Calls block: [`OffLoop`](super::OffLoop) moves them off the event loop.
pub struct RedbStore {
    path: PathBuf,
    slot: Mutex<Slot>,
}

struct Slot {
    /// None after an error: the next operation opens the file again, which checks it as a whole.
    database: Option<Database>,
    /// Bytes that could not be written last.
    unwritten: Option<usize>,
}

impl RedbStore {
    /// Opens the file, or makes it (mode 0600) with this cluster uid.
    pub fn open(path: &Path, new_uid: &str) -> Result<Self, StoreError> {
        Ok(Self {
            path: path.to_owned(),
            slot: Mutex::new(Slot {
                database: Some(file::open(path, new_uid)?),
                unwritten: None,
            }),
        })
    }

    fn slot(&self) -> MutexGuard<'_, Slot> {
        self.slot.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn with<T>(
        &self,
        what: &'static str,
        work: impl FnOnce(&Database) -> Result<T, Error>,
    ) -> Result<T, StoreError> {
        let mut slot = self.slot();
        let database = match slot.database.take() {
            Some(database) => database,
            None => file::reopen(&self.path)?,
        };
        let value = work(&database).map_err(|e| file::failed(what, &self.path, e))?;
        slot.database = Some(database);
        Ok(value)
    }

    fn change(&self, changes: &[Change]) -> Result<(), StoreError> {
        let result = self.with("write", |database| rows::write(database, changes));
        // A commit that failed at its very end may be there all the same: what the file says holds.
        let landed = || matches!(self.with("read", |d| rows::are_in(d, changes)), Ok(true));
        if result.is_ok() || landed() {
            self.slot().unwritten = None;
            return Ok(());
        }
        let values = changes.iter().filter_map(|change| change.value.as_ref());
        self.slot().unwritten = Some(values.map(Vec::len).sum());
        result
    }

    /// The numbers as they are; read at most once for each write.
    fn meta(&self, read: &mut Option<Numbers>) -> Result<Numbers, StoreError> {
        let numbers = match *read {
            Some(numbers) => numbers,
            None => self.with("read", |database| {
                numbers(&database.begin_read()?.open_table(META)?)
            })?,
        };
        *read = Some(numbers);
        Ok(numbers)
    }

    fn row(&self, write: &Write, meta: &mut Option<Numbers>) -> Result<Change, StoreError> {
        let row = match write {
            Write::PutSystem(record) => Change::put(SYSTEMS, record.name(), record.as_ref()),
            Write::RemoveSystem(name) => Ok(Change::remove(SYSTEMS, name)),
            Write::PutNode(node, generation) => Change::put(NODES, node, generation),
            Write::Revisions(up_to) => {
                Change::put(META, REVISIONS, &self.meta(meta)?.revisions.max(*up_to))
            }
            Write::Indexes(up_to) => {
                Change::put(META, INDEXES, &self.meta(meta)?.indexes.max(*up_to))
            }
            Write::Epoch(epoch) => Change::put(META, EPOCH, epoch),
            Write::Restored(Some(restored)) => Change::put(META, RESTORED, restored),
            Write::Restored(None) => Ok(Change::remove(META, RESTORED)),
            Write::ClusterUid(uid) => Change::put(META, CLUSTER_UID, uid),
        };
        row.map_err(|e| file::failed("write", &self.path, e))
    }
}

/// Numbers that a store which replaces another must go above.
#[derive(Debug, Clone, Copy, Default)]
pub struct Numbers {
    /// Its epoch.
    pub epoch: u64,
    /// No revision above this one was ever given out.
    pub revisions: u64,
    /// No index above this one was ever given out.
    pub indexes: u64,
}

fn numbers(meta: &impl ReadableTable<&'static str, &'static [u8]>) -> Result<Numbers, Error> {
    Ok(Numbers {
        epoch: rows::get(meta, EPOCH)?.unwrap_or(0),
        revisions: rows::get(meta, REVISIONS)?.unwrap_or(0),
        indexes: rows::get(meta, INDEXES)?.unwrap_or(0),
    })
}

/// The numbers of the store in a file, whatever its version; none when it cannot be read.
pub fn numbers_of(path: &Path) -> Option<Numbers> {
    let database = file::reopen(path).ok()?;
    let transaction = database.begin_read().ok()?;
    numbers(&transaction.open_table(META).ok()?).ok()
}

/// The nodes that the store in a file has told something; none when it cannot be read, or is another cluster's.
pub fn nodes_of(path: &Path, cluster_uid: &str) -> BTreeSet<String> {
    let read = || {
        let database = file::reopen(path).ok()?;
        let transaction = database.begin_read().ok()?;
        let meta = transaction.open_table(META).ok()?;
        let cluster: String = rows::get(&meta, CLUSTER_UID).ok()??;
        let nodes = transaction.open_table(NODES).ok()?;
        let nodes = rows::all::<IgnoredAny>(&nodes).ok();
        nodes.filter(|_| cluster == cluster_uid)
    };
    read().unwrap_or_default().into_keys().collect()
}

impl RedbStore {
    /// See [`Store::check`](super::Store::check).
    pub fn check(&self) -> Result<(), StoreError> {
        let unwritten = self.slot().unwritten;
        if let Some(size) = unwritten {
            let probe = Change {
                table: META,
                key: PROBE.to_owned(),
                value: Some(vec![b' '; size]),
            };
            self.change(&[probe])?;
            self.change(&[Change::remove(META, PROBE)])?;
        }
        self.load().map(drop)
    }

    /// See [`Store::load`](super::Store::load).
    pub fn load(&self) -> Result<State, StoreError> {
        self.with("read", |database| {
            let transaction = database.begin_read()?;
            let meta = transaction.open_table(META)?;
            Ok(State {
                cluster_uid: rows::get(&meta, CLUSTER_UID)?.unwrap_or_default(),
                epoch: rows::get(&meta, EPOCH)?.unwrap_or(1),
                revisions: rows::get(&meta, REVISIONS)?.unwrap_or(0),
                indexes: rows::get(&meta, INDEXES)?.unwrap_or(0),
                restored: rows::get(&meta, RESTORED)?,
                systems: rows::all(&transaction.open_table(SYSTEMS)?)?,
                nodes: rows::all(&transaction.open_table(NODES)?)?,
            })
        })
    }

    /// See [`Store::write`](super::Store::write).
    pub fn write(&self, writes: &[Write]) -> Result<(), StoreError> {
        let mut meta = None;
        let rows: Result<Vec<_>, _> = writes.iter().map(|w| self.row(w, &mut meta)).collect();
        self.change(&rows?)
    }
}

#[cfg(test)]
mod tests;
