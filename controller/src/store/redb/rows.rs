//! Rows of the tables: JSON by name.

use std::collections::BTreeMap;

use redb::{Database, Error, ReadableDatabase, ReadableTable, TableDefinition, WriteTransaction};
use serde::{Serialize, de::DeserializeOwned};

/// A table.
pub type Table = TableDefinition<'static, &'static str, &'static [u8]>;

/// Facts of the store.
pub const META: Table = TableDefinition::new("meta");
/// Systems by name.
pub const SYSTEMS: Table = TableDefinition::new("systems");
/// Generations by node.
pub const NODES: Table = TableDefinition::new("nodes");

/// Key in [`META`]: version of the tables.
pub const VERSION: &str = "schemaVersion";
/// Key in [`META`].
pub const CLUSTER_UID: &str = "clusterUid";
/// Key in [`META`].
pub const EPOCH: &str = "epoch";
/// Key in [`META`]: revisions that may have been given out.
pub const REVISIONS: &str = "revisions";
/// Key in [`META`]: indexes that may have been given out.
pub const INDEXES: &str = "indexes";
/// Key in [`META`]: set by a restore.
pub const RESTORED: &str = "restored";
/// Key in [`META`]: what is written to see whether it can be.
pub const PROBE: &str = "probe";

/// One row's new value; none removes it.
pub struct Change {
    /// Table.
    pub table: Table,
    /// Key.
    pub key: String,
    /// Value.
    pub value: Option<Vec<u8>>,
}

impl Change {
    /// A new value.
    pub fn put<T: Serialize>(table: Table, key: &str, value: &T) -> Result<Self, Error> {
        let value = Some(bytes(value)?);
        let key = key.to_owned();
        Ok(Self { table, key, value })
    }

    /// No value any more.
    pub fn remove(table: Table, key: &str) -> Self {
        let key = key.to_owned();
        let value = None;
        Self { table, key, value }
    }

    fn make(&self, transaction: &WriteTransaction) -> Result<(), Error> {
        let mut table = transaction.open_table(self.table)?;
        match &self.value {
            Some(value) => table.insert(self.key.as_str(), value.as_slice())?,
            None => table.remove(self.key.as_str())?,
        };
        Ok(())
    }

    fn is_in(&self, database: &Database) -> Result<bool, Error> {
        let table = database.begin_read()?.open_table(self.table)?;
        let found = table.get(self.key.as_str())?;
        Ok(found.as_ref().map(|row| row.value()) == self.value.as_deref())
    }
}

/// Makes all changes in one transaction, durably.
pub fn write(database: &Database, changes: &[Change]) -> Result<(), Error> {
    let transaction = database.begin_write()?;
    for change in changes {
        change.make(&transaction)?;
    }
    Ok(transaction.commit()?)
}

/// True when the store holds them all.
pub fn are_in(database: &Database, changes: &[Change]) -> Result<bool, Error> {
    for change in changes {
        if !change.is_in(database)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// A value as JSON.
pub fn bytes<T: Serialize>(value: &T) -> Result<Vec<u8>, Error> {
    serde_json::to_vec(value).map_err(|e| Error::Io(e.into()))
}

/// One value.
pub fn get<T: DeserializeOwned>(
    table: &impl ReadableTable<&'static str, &'static [u8]>,
    key: &str,
) -> Result<Option<T>, Error> {
    let found = table.get(key)?;
    found.map(|row| parse(key, row.value())).transpose()
}

/// All values.
pub fn all<T: DeserializeOwned>(
    table: &impl ReadableTable<&'static str, &'static [u8]>,
) -> Result<BTreeMap<String, T>, Error> {
    table
        .iter()?
        .map(|row| {
            let (key, value) = row?;
            let key = key.value().to_owned();
            let value = parse(&key, value.value())?;
            Ok((key, value))
        })
        .collect()
}

fn parse<T: DeserializeOwned>(key: &str, json: &[u8]) -> Result<T, Error> {
    serde_json::from_slice(json).map_err(|e| Error::Corrupted(format!("record {key}: {e}")))
}
