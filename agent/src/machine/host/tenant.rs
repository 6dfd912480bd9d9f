//! Who lives in a run folder: told by its description, its lock and its age, never by one failed look.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use std::time::SystemTime;

use rts_host::cgroup::Cgroup;
use rts_host::identity::Identity;
use rts_host::process::{Process, end_group_of, group_of_lives};
use rts_manager_api::files::{LOCK, MANAGER_JSON, ManagerFile};
use rustix::fs::FlockOperation;

use super::groups::Groups;
use crate::machine::{DESCRIBE, GROUP_END, Tenant};

/// Largest description in bytes.
const MAX_FILE: u64 = 64 * 1024;

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
    Process::identified(&identity(file)).is_some()
}

/// Who the manager is, or was.
pub(super) fn identity(file: &ManagerFile) -> Identity {
    Identity {
        pid: file.pid,
        start_ticks: file.start_ticks,
        boot_id: file.boot_id.clone(),
        version: String::new(),
    }
}

fn is_young(made: SystemTime) -> bool {
    // A time in the future tells nothing: then the folder is as good as new only for a moment of a wrong clock.
    made.elapsed().is_ok_and(|age| age < DESCRIBE)
}

/// The description; none when there is none or it makes no sense.
pub(super) fn describe(folder: &Path) -> io::Result<Option<ManagerFile>> {
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

/// Removes the folder of a manager that is gone, after it has killed what is left of its process group and its control
/// group: a child that it forked may even hold its lock. A folder from before the machine was booted names nobody.
pub(super) fn bury(folder: &Path, file: Option<&ManagerFile>, groups: &Groups) -> io::Result<()> {
    if let Some(file) = file {
        bury_group(file)?;
    }
    let recorded = file.and_then(|file| file.cgroup.as_deref());
    let names = [groups.name(folder, None), groups.name(folder, recorded)];
    for left in groups.all().find() {
        if names.iter().any(|name| name == left.name()) {
            bury_cgroup(&left)?;
        }
    }
    fs::remove_dir_all(folder)
}

fn bury_group(file: &ManagerFile) -> io::Result<()> {
    let leader = identity(file);
    if !group_of_lives(&leader) {
        return Ok(());
    }
    let pid = file.pid;
    tracing::warn!(pid, "killing what is left of a dead manager's group");
    if end_group_of(&leader, GROUP_END) {
        Ok(())
    } else {
        Err(stubborn(pid))
    }
}

/// Kills what a dead manager left in its control group, and removes that.
pub(super) fn bury_cgroup(cgroup: &Cgroup) -> io::Result<()> {
    if let Some(process) = cgroup.processes().first() {
        tracing::warn!(
            pid = process.pid(),
            "killing what a dead manager started: {}",
            cgroup.path().display()
        );
    }
    if !cgroup.kill_within(GROUP_END) {
        return Err(stubborn(cgroup.path().display()));
    }
    cgroup.remove()
}

fn stubborn(whose: impl std::fmt::Display) -> io::Error {
    io::Error::other(format!(
        "what a dead manager started does not die ({whose}); look at it with `ps`"
    ))
}
