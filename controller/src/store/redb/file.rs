//! The file of the store: made, opened, identified.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use redb::backends::FileBackend;
use redb::{Database, Error};

use super::migrate;
use super::rows::{self, CLUSTER_UID, EPOCH, META, NODES, SYSTEMS, VERSION};
use crate::store::{SCHEMA_VERSION, StoreError};

/// Opens the file, or makes it (mode 0600) with this cluster uid.
pub fn open(path: &Path, new_uid: &str) -> Result<Database, StoreError> {
    let options = || {
        let mut options = OpenOptions::new();
        options.read(true).write(true).mode(0o600);
        options
    };
    let made = !path.exists();
    let file = options().create(true).truncate(false).open(path);
    let mut database = take(path, file)?;
    let found = migrate::version(&database).map_err(|e| failed("open", path, e))?;
    match found {
        None => make(&database, new_uid).map_err(|e| failed("make", path, e))?,
        Some(SCHEMA_VERSION) => {}
        Some(found) if found > SCHEMA_VERSION => {
            let path = path.to_owned();
            return Err(StoreError::FutureSchema { path, found });
        }
        Some(found) => {
            // Closed while it is copied, so that the copy is whole.
            drop(database);
            let copy = migrate::keep_copy(path, found);
            let copy = copy.map_err(|e| failed("copy", path, e.into()))?;
            tracing::info!(from = found, to = SCHEMA_VERSION, copy = %copy.display(), "store migrated");
            database = reopen(path)?;
            migrate::migrate(&database, found).map_err(|e| failed("migrate", path, e))?;
        }
    }
    if made {
        keep_name(path).map_err(|e| failed("make", path, e.into()))?;
    }
    Ok(database)
}

/// Opens the file again after an error. It must be there: a new one would be another store.
pub fn reopen(path: &Path) -> Result<Database, StoreError> {
    take(path, OpenOptions::new().read(true).write(true).open(path))
}

fn take(path: &Path, file: io::Result<File>) -> Result<Database, StoreError> {
    let file = file.map_err(|e| failed("open", path, e.into()))?;
    let backend = FileBackend::new(file).map_err(|e| failed("open", path, e.into()))?;
    // The file may have been damaged by others: that must be an error, not a panic.
    Database::builder()
        .set_check_integrity_on_open(true)
        .create_with_backend(backend)
        .map_err(|e| failed("open", path, e.into()))
}

/// Writes the identity of a new store.
fn make(database: &Database, new_uid: &str) -> Result<(), Error> {
    let transaction = database.begin_write()?;
    {
        let mut meta = transaction.open_table(META)?;
        transaction.open_table(SYSTEMS)?;
        transaction.open_table(NODES)?;
        meta.insert(VERSION, rows::bytes(&SCHEMA_VERSION)?.as_slice())?;
        meta.insert(CLUSTER_UID, rows::bytes(&new_uid)?.as_slice())?;
        meta.insert(EPOCH, rows::bytes(&1u64)?.as_slice())?;
    }
    Ok(transaction.commit()?)
}

/// A new file's name must outlive a power cut as its contents do.
fn keep_name(path: &Path) -> io::Result<()> {
    File::open(path.parent().unwrap_or(Path::new(".")))?.sync_all()
}

/// The error of an operation.
pub fn failed(what: &'static str, path: &Path, error: Error) -> StoreError {
    let path = path.to_owned();
    match error {
        Error::Io(e)
            if matches!(
                e.kind(),
                io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded
            ) =>
        {
            StoreError::Full { path }
        }
        Error::Corrupted(reason) => StoreError::Damaged { path, reason },
        // The file does not begin as a redb file does.
        Error::Io(e) if e.kind() == io::ErrorKind::InvalidData => StoreError::Damaged {
            path,
            reason: e.to_string(),
        },
        error => StoreError::Failed {
            what,
            path,
            source: Box::new(error),
        },
    }
}
