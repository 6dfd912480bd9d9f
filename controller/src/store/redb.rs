//! The store in one redb file. Every write is one transaction, on the disk before it returns.

use std::fs::OpenOptions;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use redb::backends::FileBackend;
use redb::{Database, ReadableDatabase, ReadableTable, TableDefinition};
use serde::{Serialize, de::DeserializeOwned};

use super::{NodeGeneration, SCHEMA_VERSION, State, Store, StoreError, SystemRecord};

const META: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("meta");
const SYSTEMS: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("systems");
const NODES: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("nodes");

const VERSION: &str = "schemaVersion";
const CLUSTER_UID: &str = "clusterUid";
const EPOCH: &str = "epoch";
const REVISIONS: &str = "revisions";

type Cause = Box<dyn std::error::Error + Send + Sync>;

/// The store.
pub struct RedbStore {
    path: PathBuf,
    database: Database,
}

impl RedbStore {
    /// Opens the file, or makes it (mode 0600) with this cluster uid.
    pub fn open(path: &Path, new_uid: &str) -> Result<Self, StoreError> {
        let failed = |source: Cause| StoreError::Failed {
            what: "open",
            path: path.to_owned(),
            source,
        };
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            .open(path)
            .map_err(|e| failed(e.into()))?;
        // The file may have been damaged by others: that must be an error, not a panic.
        let database = Database::builder()
            .set_check_integrity_on_open(true)
            .create_with_backend(FileBackend::new(file).map_err(|e| failed(e.into()))?)
            .map_err(|e| failed(e.into()))?;
        let store = Self {
            path: path.to_owned(),
            database,
        };
        store.prepare(new_uid)?;
        Ok(store)
    }

    /// Checks the schema version, or writes the identity of a new store.
    fn prepare(&self, new_uid: &str) -> Result<(), StoreError> {
        let found = self.within("open", || {
            let transaction = self.database.begin_write()?;
            let found = {
                let mut meta = transaction.open_table(META)?;
                transaction.open_table(SYSTEMS)?;
                transaction.open_table(NODES)?;
                let found = get::<u32>(&meta, VERSION)?;
                if found.is_none() {
                    put(&mut meta, VERSION, &SCHEMA_VERSION)?;
                    put(&mut meta, CLUSTER_UID, &new_uid)?;
                    put(&mut meta, EPOCH, &1u64)?;
                }
                found
            };
            transaction.commit()?;
            Ok(found.unwrap_or(SCHEMA_VERSION))
        })?;
        if found > SCHEMA_VERSION {
            let path = self.path.clone();
            return Err(StoreError::FutureSchema { path, found });
        }
        Ok(())
    }

    fn within<T>(
        &self,
        what: &'static str,
        work: impl FnOnce() -> Result<T, Cause>,
    ) -> Result<T, StoreError> {
        work().map_err(|source| StoreError::Failed {
            what,
            path: self.path.clone(),
            source,
        })
    }

    fn write<T: Serialize>(
        &self,
        table: TableDefinition<'_, &str, &[u8]>,
        key: &str,
        value: &T,
    ) -> Result<(), StoreError> {
        self.within("write", || {
            let transaction = self.database.begin_write()?;
            put(&mut transaction.open_table(table)?, key, value)?;
            transaction.commit()?;
            Ok(())
        })
    }
}

fn get<T: DeserializeOwned>(
    table: &impl ReadableTable<&'static str, &'static [u8]>,
    key: &str,
) -> Result<Option<T>, Cause> {
    let found = table.get(key)?;
    found
        .map(|value| serde_json::from_slice(value.value()).map_err(Cause::from))
        .transpose()
}

fn put<T: Serialize>(
    table: &mut redb::Table<'_, &'static str, &'static [u8]>,
    key: &str,
    value: &T,
) -> Result<(), Cause> {
    table.insert(key, serde_json::to_vec(value)?.as_slice())?;
    Ok(())
}

fn all<T: DeserializeOwned>(
    table: &impl ReadableTable<&'static str, &'static [u8]>,
) -> Result<std::collections::BTreeMap<String, T>, Cause> {
    table
        .iter()?
        .map(|row| {
            let (key, value) = row?;
            Ok((
                key.value().to_owned(),
                serde_json::from_slice(value.value())?,
            ))
        })
        .collect()
}

impl Store for RedbStore {
    fn load(&self) -> Result<State, StoreError> {
        self.within("read", || {
            let transaction = self.database.begin_read()?;
            let meta = transaction.open_table(META)?;
            Ok(State {
                cluster_uid: get(&meta, CLUSTER_UID)?.unwrap_or_default(),
                epoch: get(&meta, EPOCH)?.unwrap_or(1),
                revisions: get(&meta, REVISIONS)?.unwrap_or(0),
                systems: all(&transaction.open_table(SYSTEMS)?)?,
                nodes: all(&transaction.open_table(NODES)?)?,
            })
        })
    }

    fn put_system(&self, record: &SystemRecord) -> Result<(), StoreError> {
        self.write(SYSTEMS, record.name(), record)
    }

    fn remove_system(&self, name: &str) -> Result<(), StoreError> {
        self.within("write", || {
            let transaction = self.database.begin_write()?;
            transaction.open_table(SYSTEMS)?.remove(name)?;
            transaction.commit()?;
            Ok(())
        })
    }

    fn put_node(&self, node: &str, generation: &NodeGeneration) -> Result<(), StoreError> {
        self.write(NODES, node, generation)
    }

    fn reserve_revisions(&self, up_to: u64) -> Result<(), StoreError> {
        self.within("write", || {
            let transaction = self.database.begin_write()?;
            {
                let mut meta = transaction.open_table(META)?;
                let now: u64 = get(&meta, REVISIONS)?.unwrap_or(0);
                put(&mut meta, REVISIONS, &now.max(up_to))?;
            }
            transaction.commit()?;
            Ok(())
        })
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
        store.write(META, VERSION, &2u32).unwrap();
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
    fn a_damaged_file_is_an_error_and_no_panic() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.redb");
        std::fs::write(&path, b"this is no database").unwrap();
        assert!(matches!(
            RedbStore::open(&path, "u"),
            Err(StoreError::Failed { what: "open", .. })
        ));
    }
}
