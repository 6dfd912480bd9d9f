//! From the tables of an older program to those of this one, step by step, in one transaction.

use std::io;
use std::path::{Path, PathBuf};

use redb::{Database, Error, ReadableDatabase, WriteTransaction};
use serde_json::{Map, Value};

use super::rows::{self, EPOCH, META, NODES, VERSION};
use crate::store::SCHEMA_VERSION;

type Step = fn(&WriteTransaction) -> Result<(), Error>;

/// What leads to the next version, by the version that it starts from.
const STEPS: &[(u32, Step)] = &[(1, epochs_of_nodes)];

/// The schema version of a file; none when it is new.
pub fn version(database: &Database) -> Result<Option<u32>, Error> {
    let transaction = database.begin_read()?;
    match transaction.open_table(META) {
        Ok(meta) => rows::get(&meta, VERSION),
        Err(redb::TableError::TableDoesNotExist(_)) => Ok(None),
        Err(e) => Err(e.into()),
    }
}

/// Brings the tables up to date; all of it, or nothing.
pub fn migrate(database: &Database, from: u32) -> Result<(), Error> {
    let transaction = database.begin_write()?;
    for (_, step) in STEPS.iter().filter(|(version, _)| *version >= from) {
        step(&transaction)?;
    }
    transaction
        .open_table(META)?
        .insert(VERSION, rows::bytes(&SCHEMA_VERSION)?.as_slice())?;
    Ok(transaction.commit()?)
}

/// Keeps a copy of the file as it is: `controller.redb.v1`. Durable when it returns.
pub fn keep_copy(path: &Path, version: u32) -> io::Result<PathBuf> {
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".v{version}"));
    let copy = PathBuf::from(name);
    rts_host::files::replace_durably(&copy, &std::fs::read(path)?)?;
    Ok(copy)
}

/// 1 → 2: a node's generation says in which epoch it was given out.
fn epochs_of_nodes(transaction: &WriteTransaction) -> Result<(), Error> {
    let epoch: u64 = rows::get(&transaction.open_table(META)?, EPOCH)?.unwrap_or(1);
    let mut nodes = transaction.open_table(NODES)?;
    let all = rows::all::<Map<String, Value>>(&nodes)?;
    for (node, mut generation) in all {
        generation.insert("epoch".to_owned(), epoch.into());
        nodes.insert(node.as_str(), rows::bytes(&generation)?.as_slice())?;
    }
    Ok(())
}
