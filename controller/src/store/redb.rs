//! The store in one redb file. Every write is one transaction, on the disk before it returns.
//!
//! After an I/O error redb refuses everything until its file is closed and opened anew, which is done here.

mod file;
mod rows;

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use redb::{Database, Error, ReadableDatabase};
use serde::Serialize;

use self::rows::{CLUSTER_UID, Change, EPOCH, META, NODES, PROBE, REVISIONS, SYSTEMS, Table};
use super::{NodeGeneration, State, Store, StoreError, SystemRecord};

/// The store.
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

    fn change(&self, change: &Change<'_>) -> Result<(), StoreError> {
        let result = self.with("write", |database| change.write(database));
        // A commit that failed at its very end may be there all the same: what the file says holds.
        let landed = || matches!(self.with("read", |d| change.is_in(d)), Ok(true));
        if result.is_ok() || landed() {
            self.slot().unwritten = None;
            return Ok(());
        }
        self.slot().unwritten = Some(change.value.as_ref().map_or(0, Vec::len));
        result
    }

    fn put<T: Serialize>(&self, table: Table, key: &str, value: &T) -> Result<(), StoreError> {
        let value = rows::bytes(value).map_err(|e| file::failed("write", &self.path, e))?;
        let value = Some(value);
        self.change(&Change { table, key, value })
    }

    fn remove(&self, table: Table, key: &str) -> Result<(), StoreError> {
        let value = None;
        self.change(&Change { table, key, value })
    }
}

impl Store for RedbStore {
    fn check(&self) -> Result<(), StoreError> {
        let unwritten = self.slot().unwritten;
        if let Some(size) = unwritten {
            let probe = Change {
                table: META,
                key: PROBE,
                value: Some(vec![b' '; size]),
            };
            self.change(&probe)?;
            self.remove(META, PROBE)?;
        }
        self.load().map(drop)
    }

    fn load(&self) -> Result<State, StoreError> {
        self.with("read", |database| {
            let transaction = database.begin_read()?;
            let meta = transaction.open_table(META)?;
            Ok(State {
                cluster_uid: rows::get(&meta, CLUSTER_UID)?.unwrap_or_default(),
                epoch: rows::get(&meta, EPOCH)?.unwrap_or(1),
                revisions: rows::get(&meta, REVISIONS)?.unwrap_or(0),
                systems: rows::all(&transaction.open_table(SYSTEMS)?)?,
                nodes: rows::all(&transaction.open_table(NODES)?)?,
            })
        })
    }

    fn put_system(&self, record: &SystemRecord) -> Result<(), StoreError> {
        self.put(SYSTEMS, record.name(), record)
    }

    fn remove_system(&self, name: &str) -> Result<(), StoreError> {
        self.remove(SYSTEMS, name)
    }

    fn put_node(&self, node: &str, generation: &NodeGeneration) -> Result<(), StoreError> {
        self.put(NODES, node, generation)
    }

    fn reserve_revisions(&self, up_to: u64) -> Result<(), StoreError> {
        let now = self.load()?.revisions;
        self.put(META, REVISIONS, &now.max(up_to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_store_of_a_later_program_is_refused_and_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.redb");
        let store = RedbStore::open(&path, "u").unwrap();
        store.put(META, rows::VERSION, &2u32).unwrap();
        drop(store);
        let Err(error) = RedbStore::open(&path, "u") else {
            panic!("it was opened");
        };
        let text = error
            .to_string()
            .replace(&path.display().to_string(), "FILE");
        insta::assert_snapshot!(text, @"FILE has schema version 2, and this program knows 1: upgrade rts-controller, or move the file away to start afresh");
    }

    #[test]
    fn a_damaged_file_is_an_error_that_says_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.redb");
        std::fs::write(&path, b"this is no database").unwrap();
        let Err(error) = RedbStore::open(&path, "u") else {
            panic!("it was opened");
        };
        let text = error
            .to_string()
            .replace(&path.display().to_string(), "FILE");
        insta::assert_snapshot!(text, @"the store FILE is damaged (Not a redb database: magic number mismatch); put a copy of it back and start again, or, without one, end everything with `rtsctl down --purge` and apply the systems again");
    }

    #[test]
    fn a_damaged_record_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.redb");
        let store = RedbStore::open(&path, "u").unwrap();
        store.put(SYSTEMS, "hello", &7).unwrap();
        let error = store.load().unwrap_err().to_string();
        assert!(error.contains("damaged (record hello: "), "{error}");
        store.remove_system("hello").unwrap();
        store.check().unwrap();
    }
}
