//! The control groups of this node: that of a manager has the name of its run folder, and that of a process which waits
//! to become one a name of its own, which its `manager.json` tells later.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use rts_host::cgroup::{Cgroup, Cgroups, NotPermitted, Version};

use super::family::remove;
use super::tenant::describe;
use crate::events::lock;
use crate::folders::{Folders, is_folder_id};
use crate::machine::GROUP_END;

/// Numbers that are tried for a new name: what has one of them was made by an agent with this process's number.
const TRIES: u32 = 100;

/// Name of a group that no manager has.
const PROBE: &str = "probe";

/// Makes groups, and knows those of the processes that wait.
#[derive(Debug)]
pub(super) struct Groups {
    cgroups: Cgroups,
    folders: Folders,
    /// One that was made: others are made beside it, without a search for the place.
    made: Mutex<Option<Cgroup>>,
    /// The next number of a name.
    next: AtomicU64,
    /// Names that were given to processes that wait, and to what became of them.
    given: Mutex<BTreeSet<String>>,
}

impl Groups {
    /// Those of a node.
    pub fn new(cgroups: Cgroups, folders: Folders) -> Self {
        Self {
            cgroups,
            folders,
            made: Mutex::default(),
            next: AtomicU64::new(0),
            given: Mutex::default(),
        }
    }

    /// All of the home.
    pub fn all(&self) -> &Cgroups {
        &self.cgroups
    }

    /// The group of a manager that is about to start; none when that cannot be had in a moment: nobody knows yet where
    /// groups are permitted, or it is there, and somebody may live in it.
    pub fn fresh(&self, folder: &Path) -> Option<Cgroup> {
        let made = lock(&self.made).clone()?;
        made.beside(&self.folders.cgroup(folder)).ok()
    }

    /// The same, however long it takes to kill who lives in it; none when somebody does not die. Blocks.
    pub fn make(&self, folder: &Path) -> Result<Option<Cgroup>, NotPermitted> {
        let cgroup = self.cgroups.create(&self.folders.cgroup(folder))?;
        *lock(&self.made) = Some(cgroup.clone());
        Ok(cgroup.kill_within(GROUP_END).then_some(cgroup))
    }

    /// True when a manager of this run folder left a group behind.
    pub fn is_left(&self, folder: &Path) -> bool {
        let made = lock(&self.made).clone();
        let parent = made.as_ref().and_then(|made| made.path().parent());
        parent.is_some_and(|parent| parent.join(self.folders.cgroup(folder)).exists())
    }

    /// A group of version 2 for a process that will wait in it; none where there is no such. Blocks.
    pub fn waiting(&self) -> io::Result<Option<Cgroup>> {
        let made = lock(&self.made).clone();
        let Some(made) = made.or_else(|| self.probe()) else {
            return Ok(None);
        };
        if made.version() != Version::V2 {
            return Ok(None);
        }
        let pid = std::process::id();
        for _ in 0..TRIES {
            let number = self.next.fetch_add(1, Ordering::Relaxed);
            let name = self.folders.waiting_cgroup(pid, number);
            // Before it is there: nobody takes it for one that nobody owns.
            lock(&self.given).insert(name.clone());
            match made.beside(&name) {
                Ok(group) => return Ok(Some(group)),
                Err(e) => {
                    lock(&self.given).remove(&name);
                    // An agent before this one had the same number.
                    if e.kind() != io::ErrorKind::AlreadyExists {
                        return Err(e);
                    }
                }
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    /// Finds the place where groups are permitted.
    fn probe(&self) -> Option<Cgroup> {
        let probe = self.cgroups.create(PROBE).ok()?;
        // Should it stay, it is empty, and goes with the others.
        let _ = probe.remove();
        *lock(&self.made) = Some(probe.clone());
        Some(probe)
    }

    /// Removes groups of processes that waited for an agent that is gone, as far as nobody is in them. Blocks.
    pub fn sweep(&self) {
        for group in self.cgroups.find() {
            let name = group.name();
            if self.folders.is_waiting_cgroup(name) && !lock(&self.given).contains(name) {
                // Refused while somebody lives in it.
                let _ = group.remove_now();
            }
        }
    }

    /// Removes the group of a process that has ended while it waited. Blocks.
    pub fn remove(&self, group: &Cgroup) {
        remove(group);
        lock(&self.given).remove(group.name());
    }

    /// The group that a manager is in. It is that manager's from here on, whatever becomes of its run folder.
    pub fn holding(&self, folder: &Path, recorded: Option<&str>, pid: u32) -> Option<Cgroup> {
        let group = self.cgroups.holding(&self.name(folder, recorded), pid)?;
        if self.folders.is_waiting_cgroup(group.name()) {
            lock(&self.given).insert(group.name().to_owned());
        }
        Some(group)
    }

    /// The name of a manager's group.
    pub fn name(&self, folder: &Path, recorded: Option<&str>) -> String {
        // What a file says leads nowhere but to a group of this node.
        let recorded = recorded.filter(|name| self.folders.is_waiting_cgroup(name));
        recorded.map_or_else(|| self.folders.cgroup(folder), str::to_owned)
    }

    /// Groups that nobody owns: no manager, alive or dead, whose run folder is there, and no process that waits. Blocks.
    pub fn orphans(&self, living: &[PathBuf]) -> Vec<Cgroup> {
        // Before they are listed: the group of a name that is given meanwhile need not be there yet.
        let known = lock(&self.given).clone();
        let mut orphans = self.cgroups.find();
        let there: BTreeSet<&str> = orphans.iter().map(Cgroup::name).collect();
        // After they were listed: a process that was named meanwhile is in its file, or is known here.
        let (recorded, any_nameless) = self.recorded();
        let mut given = lock(&self.given);
        given.retain(|name| there.contains(name.as_str()) || !known.contains(name));
        let given = given.clone();
        orphans.retain(|cgroup| {
            let name = cgroup.name();
            if self.folders.is_waiting_cgroup(name) {
                // A manager that has not said yet who it is may live in it.
                let may_be_its = any_nameless && cgroup.is_populated();
                return !given.contains(name) && !recorded.contains(name) && !may_be_its;
            }
            let folder = self.folders.of_cgroup(name);
            folder.is_some_and(|folder| !living.contains(&folder) && !folder.exists())
        });
        orphans
    }

    /// The names that the files of run folders tell, and whether a run folder tells nothing.
    fn recorded(&self) -> (BTreeSet<String>, bool) {
        let entries = std::fs::read_dir(&self.folders.run).into_iter().flatten();
        let paths = entries.flatten().map(|entry| entry.path());
        let folders = paths.filter(|path| {
            let name = path.file_name().and_then(|name| name.to_str());
            name.is_some_and(is_folder_id)
        });
        let (mut names, mut any_nameless) = (BTreeSet::new(), false);
        for folder in folders {
            match describe(&folder) {
                Ok(Some(file)) => names.extend(file.cgroup),
                _ => any_nameless = true,
            }
        }
        (names, any_nameless)
    }
}

#[cfg(test)]
mod tests {
    use rts_host::cgroup::Choice;

    use super::*;

    #[test]
    fn a_group_is_nobodys_unless_it_was_given_or_a_run_folder_names_it() {
        let home = tempfile::tempdir_in("/tmp").unwrap();
        let folders = Folders::new(home.path(), "local").unwrap();
        folders.make().unwrap();
        let groups = || Groups::new(Cgroups::of(home.path(), Choice::V2), folders.clone());
        let before = groups();
        let Some((named, empty)) = before.waiting().unwrap().zip(before.waiting().unwrap()) else {
            eprintln!("skipped: no control groups of version 2 are permitted");
            return;
        };
        assert_eq!(before.orphans(&[]), []);
        // An agent that starts anew was given none; with the same number it takes other names.
        let after = groups();
        let own = after.waiting().unwrap().unwrap();
        assert!(own != named && own != empty);
        assert_eq!(after.orphans(&[]).len(), 2);
        let file = serde_json::json!({"protocolVersion": 2, "system": null, "name": "main", "incarnation": "one",
            "pid": 4_000_000, "startTicks": 1, "bootId": "", "started": "", "cgroup": named.name()});
        let folder = folders.run.join("01234567");
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("manager.json"), file.to_string()).unwrap();
        assert_eq!(after.orphans(&[]), std::slice::from_ref(&empty));
        assert_eq!(after.name(&folder, Some(named.name())), named.name());
        assert_eq!(
            after.name(&folder, Some("other.idle-1-1")),
            "local.01234567"
        );
        after.sweep();
        let left = after.all().find();
        assert!(left.contains(&own) && !left.contains(&empty));
        for group in left {
            after.remove(&group);
        }
        assert_eq!(after.all().folders(), Vec::<PathBuf>::new());
    }
}
