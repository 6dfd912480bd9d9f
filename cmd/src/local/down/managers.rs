//! The end of managers: asked, then SIGTERM, then SIGKILL.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use rts_host::identity::Identity;
use rts_host::process::{Process, end_group_of, group_of_lives};
use rts_manager_api::client::Client;
use rts_manager_api::control::RequestBody;
use rts_manager_api::files::{CONTROL_SOCKET, LOCK, MANAGER_JSON, ManagerFile};
use rustix::process::Signal;

use super::{GRACE, KILLED, Stopped, folders, name_of};
use crate::local::LocalError;
use crate::local::home::Home;
use crate::local::lock::is_held;

/// How long a manager may take from its folder's making to its lock.
const STARTING: Duration = Duration::from_secs(1);
/// Most looks at the run folder; more than fit into [`STARTING`].
const MAX_ROUNDS: u32 = 100;
/// Time between two looks at the run folder.
const PAUSE: Duration = Duration::from_millis(50);

/// A manager that holds its lock, or that left processes behind.
#[derive(Debug, Clone)]
pub struct LiveManager {
    folder: PathBuf,
    file: Option<ManagerFile>,
}

impl LiveManager {
    fn of(folder: PathBuf) -> Self {
        let bytes = std::fs::read(folder.join(MANAGER_JSON)).ok();
        let file = bytes.and_then(|b| serde_json::from_slice(&b).ok());
        Self { folder, file }
    }

    /// `hello.main`, or its folder when it did not say who it is.
    pub fn display_name(&self) -> String {
        match &self.file {
            Some(file) => match &file.system {
                Some(system) => format!("{}.{}", system.name, file.name),
                None => file.name.clone(),
            },
            None => self.folder.display().to_string(),
        }
    }

    /// System that it belongs to.
    pub fn system(&self) -> Option<&str> {
        Some(self.file.as_ref()?.system.as_ref()?.name.as_str())
    }

    fn identity(&self) -> Option<Identity> {
        let file = self.file.as_ref()?;
        Some(Identity {
            pid: file.pid,
            start_ticks: file.start_ticks,
            boot_id: file.boot_id.clone(),
            version: String::new(),
        })
    }

    fn lives(&self) -> Result<bool, LocalError> {
        let left = || self.identity().is_some_and(|it| group_of_lives(&it));
        Ok(is_held(&self.folder.join(LOCK))? || left())
    }
}

/// Managers that live now, over all nodes.
pub fn live_managers(home: &Home) -> Result<Vec<LiveManager>, LocalError> {
    let mut found = Vec::new();
    for folder in manager_folders(home)? {
        let manager = LiveManager::of(folder);
        if manager.lives()? {
            found.push(manager);
        }
    }
    Ok(found)
}

/// Names of all managers that have a run folder, by the names of their control groups.
pub(super) fn names(home: &Home) -> Result<BTreeMap<String, String>, LocalError> {
    let named = manager_folders(home)?.into_iter().map(|folder| {
        let node = folder.parent().map(name_of).unwrap_or_default();
        let own = format!("{node}.{}", name_of(&folder));
        let manager = LiveManager::of(folder);
        let recorded = manager.file.as_ref().and_then(|file| file.cgroup.clone());
        (recorded.unwrap_or(own), manager.display_name())
    });
    Ok(named.collect())
}

fn manager_folders(home: &Home) -> Result<Vec<PathBuf>, LocalError> {
    let mut all = Vec::new();
    for node in folders(&home.run())? {
        all.extend(folders(&node)?);
    }
    Ok(all)
}

/// Goes round until no manager is alive and none is just being started.
pub(super) fn stop(home: &Home, stopped: &mut Stopped) -> Result<(), LocalError> {
    let end = Instant::now() + STARTING;
    let mut unknown = BTreeSet::new();
    for _ in 0..MAX_ROUNDS {
        let mut live = live_managers(home)?;
        live.retain(|manager| !unknown.contains(&manager.folder));
        if !live.is_empty() {
            unknown.extend(stop_all(&live, stopped));
            if !stopped.left.is_empty() {
                return Ok(());
            }
        } else if Instant::now() >= end || !any_starting(home)? {
            return Ok(());
        }
        std::thread::sleep(PAUSE);
    }
    let again = "managers are started again and again".to_owned();
    stopped.left.push(again);
    Ok(())
}

/// Notes every lock that is still held when all that we know of has ended.
pub(super) fn note_held(home: &Home, stopped: &mut Stopped) -> Result<(), LocalError> {
    for folder in manager_folders(home)? {
        let lock = folder.join(LOCK);
        if is_held(&lock)? {
            let name = LiveManager::of(folder).display_name();
            let lock = lock.display();
            let left = format!("manager {name} holds {lock} but its process is not known");
            stopped.left.push(left);
        }
    }
    Ok(())
}

/// Gives the folders of those whose process is not known.
fn stop_all(live: &[LiveManager], stopped: &mut Stopped) -> Vec<PathBuf> {
    let outcomes = std::thread::scope(|scope| {
        let threads: Vec<_> = live
            .iter()
            .map(|manager| scope.spawn(|| stop_manager(manager)))
            .collect();
        let joined = threads.into_iter().map(std::thread::ScopedJoinHandle::join);
        joined.collect::<Vec<_>>()
    });
    let mut unknown = Vec::new();
    for (manager, outcome) in live.iter().zip(outcomes) {
        let name = manager.display_name();
        match outcome {
            Ok(Outcome::Unknown) => unknown.push(manager.folder.clone()),
            Ok(Outcome::Left(reason)) => stopped.left.push(reason),
            Ok(Outcome::Stopped { killed }) => {
                stopped.managers.push(name);
                stopped.killed.extend(killed);
            }
            Err(_) => {
                let left = format!("manager {name}: stopping it failed");
                stopped.left.push(left);
            }
        }
    }
    unknown
}

/// A manager's folder without its file: its process may be about to take the lock.
fn any_starting(home: &Home) -> Result<bool, LocalError> {
    let folders = manager_folders(home)?;
    Ok(folders.iter().any(|f| !f.join(MANAGER_JSON).exists()))
}

/// How the end of one manager went.
enum Outcome {
    /// It is gone; with what had to be killed.
    Stopped { killed: Option<String> },
    /// Somebody holds its lock who does not say who he is.
    Unknown,
    /// It is not, and why.
    Left(String),
}

/// Asks, then SIGTERM, then SIGKILL; the last two to the whole process group.
fn stop_manager(manager: &LiveManager) -> Outcome {
    let name = manager.display_name();
    let client = Client::connect(&manager.folder.join(CONTROL_SOCKET), GRACE).ok();
    let identity = manager
        .identity()
        .or_else(|| Identity::of(client.as_ref()?.hello().pid));
    let process = identity.as_ref().and_then(Process::identified);
    let mut killed = None;
    if let Some(process) = process {
        let asked = client.is_some_and(|mut c| c.call(RequestBody::Shutdown, GRACE).is_ok());
        let what = format!("manager {name} (pid {})", process.pid());
        match end(&process, asked) {
            End::Orderly => {}
            End::Killed => killed = Some(what),
            End::Lives => return Outcome::Left(format!("{what} does not die")),
        }
    }
    if let Some(leader) = identity.filter(group_of_lives) {
        if !end_group_of(&leader, KILLED) {
            let left = format!("what manager {name} started does not die");
            return Outcome::Left(left);
        }
        killed.get_or_insert(format!("what manager {name} had started"));
    }
    // Perhaps a child in a group of its own: the control group has it.
    if is_held(&manager.folder.join(LOCK)).unwrap_or(true) {
        return Outcome::Unknown;
    }
    // Its folder without its file would look like a manager that is about to start.
    let _ = std::fs::remove_dir_all(&manager.folder);
    Outcome::Stopped { killed }
}

/// How a process ended.
enum End {
    Orderly,
    Killed,
    Lives,
}

fn end(process: &Process, asked: bool) -> End {
    if asked && process.ended(GRACE) {
        return End::Orderly;
    }
    process.signal_group(Signal::TERM);
    if process.ended(GRACE) {
        return End::Orderly;
    }
    process.signal_group(Signal::KILL);
    if process.ended(KILLED) {
        End::Killed
    } else {
        End::Lives
    }
}
