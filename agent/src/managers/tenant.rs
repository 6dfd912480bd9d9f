//! Who lives in a run folder: told by its description, its lock and its age, never by one failed look.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use std::time::{Duration, SystemTime};

use rts_host::identity::{Identity, boot_id, start_ticks};
use rts_host::process::{Process, group_lives};
use rts_manager_api::files::{LOCK, MANAGER_JSON, ManagerFile};
use rustix::fs::FlockOperation;
use rustix::process::Signal;

use crate::process::signal_group;

/// How long a manager may take from its folder to its description.
pub(super) const DESCRIBE: Duration = Duration::from_secs(2);
/// Largest description in bytes.
const MAX_FILE: u64 = 64 * 1024;

/// Who lives in a run folder.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Tenant {
    /// There is no folder.
    None,
    /// This very manager.
    Lives(ManagerFile),
    /// A manager that may just be starting, or somebody who holds the lock and does not say who he is.
    Nameless,
    /// Nobody any more. Processes of this group, which once was a manager's, may be left.
    Gone(Option<ManagerFile>),
}

/// Looks. An error means that nothing is known.
pub(super) fn look(folder: &Path) -> io::Result<Tenant> {
    let made = match fs::metadata(folder) {
        Ok(folder) => folder.modified()?,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Tenant::None),
        Err(e) => return Err(e),
    };
    match describe(folder)? {
        // The lock is no evidence against a process that lives: its file may have been deleted.
        Some(file) if lives(&file) => Ok(Tenant::Lives(file)),
        Some(file) => Ok(Tenant::Gone(Some(file))),
        // A look at the lock takes it for a moment: not while a manager may be about to take it.
        None if is_young(made) || is_locked(folder)? => Ok(Tenant::Nameless),
        None => Ok(Tenant::Gone(None)),
    }
}

fn lives(file: &ManagerFile) -> bool {
    let identity = Identity {
        pid: file.pid,
        start_ticks: file.start_ticks,
        boot_id: file.boot_id.clone(),
        version: String::new(),
    };
    Process::identified(&identity).is_some()
}

fn is_young(made: SystemTime) -> bool {
    // A time in the future tells nothing: then the folder is as good as new only for a moment of a wrong clock.
    made.elapsed().is_ok_and(|age| age < DESCRIBE)
}

/// The description; none when there is none or it makes no sense.
fn describe(folder: &Path) -> io::Result<Option<ManagerFile>> {
    let mut text = Vec::new();
    match File::open(folder.join(MANAGER_JSON)) {
        Ok(file) => file.take(MAX_FILE).read_to_end(&mut text)?,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(e),
    };
    Ok(serde_json::from_slice(&text).ok())
}

/// True when a live process holds the lock.
fn is_locked(folder: &Path) -> io::Result<bool> {
    let file = match File::open(folder.join(LOCK)) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(false),
        Err(e) => return Err(e),
    };
    match rustix::fs::flock(&file, FlockOperation::NonBlockingLockShared) {
        Ok(()) => Ok(false),
        Err(rustix::io::Errno::WOULDBLOCK) => Ok(true),
        Err(e) => Err(e.into()),
    }
}

/// Removes the folder of a manager that is gone, and kills what is left of its process group: a child that it forked
/// may even hold its lock.
pub(super) fn bury(folder: &Path, file: Option<&ManagerFile>) -> io::Result<()> {
    if let Some(file) = file
        && boot_id().is_some_and(|boot| boot == file.boot_id)
        // While the group has members, its number is given to no new process.
        && start_ticks(file.pid).is_none_or(|ticks| ticks == file.start_ticks)
        && group_lives(file.pid)
    {
        tracing::warn!(
            pid = file.pid,
            "killing what is left of a dead manager's group"
        );
        signal_group(file.pid, Signal::KILL);
    }
    fs::remove_dir_all(folder)
}
