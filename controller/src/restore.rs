//! Restores a store from a backup while no controller runs. Agents and managers go on.

use std::io;
use std::path::{Path, PathBuf};

use jiff::Timestamp;
use serde::{Deserialize, Serialize};

use crate::home::{Home, HomeError};
use crate::store::{Backup, BackupError, RedbStore, State, StoreError, nodes_of, numbers_of};

/// Why a backup was not restored. The store is as it was.
#[derive(Debug, thiserror::Error)]
pub enum RestoreError {
    /// The backup.
    #[error("the backup cannot be restored")]
    Backup(#[from] BackupError),
    /// The home.
    #[error(transparent)]
    Home(#[from] HomeError),
    /// The new store.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A file.
    #[error("cannot {what} {}", path.display())]
    Io {
        /// What was being tried.
        what: &'static str,
        /// Where.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
}

/// What is in a backup, or was done with it: one line of JSON for whoever started the program.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Report {
    /// When the backup was made.
    pub created: Timestamp,
    /// Its cluster uid.
    pub cluster_uid: String,
    /// The epoch: of the backup, or of the restored store.
    pub epoch: u64,
    /// Names of its systems.
    pub systems: Vec<String>,
    /// Where the old store's file is now; none when there was none, or nothing was done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kept: Option<PathBuf>,
}

/// Reads a backup and says what is in it. Changes nothing.
pub fn check(file: &Path) -> Result<Report, RestoreError> {
    read(file).map(|(backup, state)| report(&backup, &state, None))
}

/// Puts a backup in the place of the store. The store wins over newer ledgers with `take_over`, else they win.
pub fn restore(root: &Path, file: &Path, take_over: bool) -> Result<Report, RestoreError> {
    let (backup, mut state) = read(file)?;
    let home = Home::take(root)?;
    let now = Timestamp::now();
    let path = home.store();
    let old = numbers_of(&path).unwrap_or_default();
    state.epoch = state.epoch.max(old.epoch).saturating_add(1);
    state.revisions = state.revisions.max(old.revisions).max(by_time(now, 20));
    state.indexes = state.indexes.max(old.indexes).max(by_time(now, 4));
    let told = nodes_of(&path, &state.cluster_uid);
    state.restore(now, take_over, told);
    let new = beside(&path, "restoring");
    remove(&new)?;
    let store = RedbStore::open(&new, &state.cluster_uid)?;
    store.write(&state.writes())?;
    drop(store);
    let kept = keep(&path, now)?;
    std::fs::rename(&new, &path).map_err(failed("put the new store to", &path))?;
    sync(&path)?;
    Ok(report(&backup, &state, kept))
}

/// Above every number that a store without jumps has given out by now, also one that was lost: 2^`bits` for each second
/// since 2020. With 20 bits it stays below 2^53, so that every JSON reader takes it for what it is.
fn by_time(now: Timestamp, bits: u32) -> u64 {
    const BEGIN: i64 = 1_577_836_800;
    let seconds = u64::try_from(now.as_second() - BEGIN).unwrap_or(0);
    seconds.min(1 << 32) << bits
}

fn read(file: &Path) -> Result<(Backup, State), RestoreError> {
    let bytes = std::fs::read(file).map_err(failed("read", file))?;
    Ok(Backup::read(&bytes)?)
}

fn report(backup: &Backup, state: &State, kept: Option<PathBuf>) -> Report {
    Report {
        created: backup.created,
        cluster_uid: state.cluster_uid.clone(),
        epoch: state.epoch,
        systems: state.systems.keys().cloned().collect(),
        kept,
    }
}

/// Gives the old store another name beside its own, so that there is a store at every moment.
fn keep(path: &Path, now: Timestamp) -> Result<Option<PathBuf>, RestoreError> {
    let stamp = now.strftime("%Y%m%dT%H%M%SZ").to_string();
    for number in 0..100 {
        let kept = match number {
            0 => beside(path, &format!("before-restore-{stamp}")),
            n => beside(path, &format!("before-restore-{stamp}-{n}")),
        };
        match std::fs::hard_link(path, &kept) {
            Ok(()) => return Ok(Some(kept)),
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
            Err(e) => return Err(failed("keep", path)(e)),
        }
    }
    Err(failed("keep", path)(io::ErrorKind::AlreadyExists.into()))
}

fn beside(path: &Path, word: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".");
    name.push(word);
    name.into()
}

/// What an earlier restore that broke off left.
fn remove(path: &Path) -> Result<(), RestoreError> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(failed("remove", path)(e)),
        _ => Ok(()),
    }
}

fn sync(path: &Path) -> Result<(), RestoreError> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let synced = std::fs::File::open(folder).and_then(|folder| folder.sync_all());
    synced.map_err(failed("sync", folder))
}

fn failed(what: &'static str, path: &Path) -> impl FnOnce(io::Error) -> RestoreError {
    let path = path.to_owned();
    move |source| RestoreError::Io { what, path, source }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Write;

    fn backup(folder: &Path, epoch: u64) -> PathBuf {
        let state = State {
            cluster_uid: "c".into(),
            epoch,
            ..State::default()
        };
        let file = folder.join("backup.json");
        let document = Backup::of(&state, Timestamp::UNIX_EPOCH).unwrap();
        std::fs::write(&file, serde_json::to_vec(&document).unwrap()).unwrap();
        file
    }

    fn held(home: &Path) -> State {
        let path = home.join("state/controller.redb");
        RedbStore::open(&path, "other").unwrap().load().unwrap()
    }

    #[test]
    fn a_restore_goes_above_the_backup_and_the_store_that_it_replaces() {
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().join("home");
        let file = backup(folder.path(), 4);
        let first = restore(&home, &file, false).unwrap();
        assert_eq!((first.epoch, first.kept), (5, None));
        let second = restore(&home, &file, true).unwrap();
        assert_eq!(second.epoch, 6);
        let kept = second.kept.unwrap();
        let old = RedbStore::open(&kept, "u").unwrap().load().unwrap();
        assert_eq!(old.epoch, 5);
        let state = held(&home);
        assert_eq!((state.cluster_uid.as_str(), state.epoch), ("c", 6));
        assert!(state.restored.unwrap().take_over);
    }

    #[test]
    fn no_version_is_given_out_twice() {
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().join("home");
        let file = backup(folder.path(), 4);
        restore(&home, &file, false).unwrap();
        let first = held(&home).revisions;
        assert!(first > 1 << 40 && first < 1 << 53);
        let indexes = held(&home).indexes;
        assert!(indexes > 1 << 30 && indexes < 1 << 40);
        let path = home.join("state/controller.redb");
        let store = RedbStore::open(&path, "other").unwrap();
        let far = 1 << 52;
        let writes = [Write::Revisions(far), Write::Indexes(far)];
        store.write(&writes).unwrap();
        drop(store);
        restore(&home, &file, false).unwrap();
        let state = held(&home);
        let numbers = (state.revisions, state.indexes);
        assert_eq!(numbers, (far, far), "above the store that is replaced");
        std::fs::remove_file(&path).unwrap();
        restore(&home, &file, false).unwrap();
        assert!(
            held(&home).revisions >= first,
            "also where that store was lost"
        );
        assert!(by_time(Timestamp::UNIX_EPOCH, 20) == 0);
    }

    #[test]
    fn the_nodes_of_the_store_that_it_replaces_are_known() {
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().join("home");
        let file = backup(folder.path(), 4);
        restore(&home, &file, false).unwrap();
        let node = Write::PutNode("arm".to_owned(), Default::default());
        let path = home.join("state/controller.redb");
        let store = RedbStore::open(&path, "other").unwrap();
        store.write(std::slice::from_ref(&node)).unwrap();
        drop(store);
        restore(&home, &file, false).unwrap();
        assert!(held(&home).nodes.contains_key("arm"));
        let uid = Write::ClusterUid("stranger".to_owned());
        let store = RedbStore::open(&path, "other").unwrap();
        store.write(&[uid]).unwrap();
        drop(store);
        restore(&home, &file, false).unwrap();
        assert!(held(&home).nodes.is_empty(), "another cluster's");
    }

    #[test]
    fn a_damaged_store_is_replaced_and_kept() {
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().join("home");
        let file = backup(folder.path(), 4);
        restore(&home, &file, false).unwrap();
        std::fs::write(home.join("state/controller.redb"), b"no store").unwrap();
        let report = restore(&home, &file, false).unwrap();
        assert_eq!(std::fs::read(report.kept.unwrap()).unwrap(), b"no store");
        assert_eq!(held(&home).epoch, 5);
    }

    #[test]
    fn a_bad_backup_and_a_controller_that_runs_leave_the_store_alone() {
        let folder = tempfile::tempdir().unwrap();
        let home = folder.path().join("home");
        let file = backup(folder.path(), 4);
        restore(&home, &file, false).unwrap();
        let before = held(&home);
        let bad = folder.path().join("bad.json");
        std::fs::write(&bad, b"{}").unwrap();
        let refused = restore(&home, &bad, false);
        assert!(matches!(refused, Err(RestoreError::Backup(_))));
        let running = Home::take(&home).unwrap();
        let refused = restore(&home, &file, false);
        assert!(matches!(refused, Err(RestoreError::Home(_))));
        drop(running);
        assert_eq!(held(&home), before);
    }
}
