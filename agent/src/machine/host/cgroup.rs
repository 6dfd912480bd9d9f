//! The control groups of managers: made before a start, entered at birth or right after it, and buried when nobody owns
//! them.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use rts_host::cgroup::{Cgroup, Cgroups, NotPermitted, Version};
use tokio::task::spawn_blocking;

use super::Host;
use super::family::remove;
use super::launch::Ground;
use super::tenant::bury_cgroup;
use crate::launch::{LaunchError, Start};
use crate::log_mark;
use crate::machine::GROUP_END;

/// What is there for a start.
pub(super) struct Prepared {
    /// None where none is permitted.
    pub cgroup: Option<Cgroup>,
    pub ground: Ground,
    /// Where in its log the start begins, in bytes.
    pub log_start: u64,
}

/// An empty control group; none when somebody in it does not die.
fn make(cgroups: &Cgroups, name: &str) -> Result<Option<Cgroup>, NotPermitted> {
    let cgroup = cgroups.create(name)?;
    Ok(cgroup.kill_within(GROUP_END).then_some(cgroup))
}

/// Opens a log for appending, marks it, and gives its length.
fn open_log(path: &Path, who: &str) -> io::Result<(File, u64)> {
    if let Err(e) = log_mark::mark(path, who) {
        // A full disk must not stop a robot.
        tracing::warn!("cannot mark the log {}: {e}", path.display());
    }
    let mut options = OpenOptions::new();
    let log = options.append(true).create(true).mode(0o600).open(path)?;
    let length = log.metadata()?.len();
    Ok((log, length))
}

impl Host {
    /// Makes what a start needs, all in one go off the thread that serves: an empty control group, where one is permitted,
    /// and the log. What the one before left is killed first.
    pub(super) async fn prepare(&self, start: &Start) -> Result<Prepared, LaunchError> {
        let (cgroups, name) = (self.cgroups.clone(), self.folders.cgroup(&start.folder));
        let manager = start.key.display_name();
        let (log, who) = (start.log.clone(), manager.clone());
        let made = spawn_blocking(move || (make(&cgroups, &name), open_log(&log, &who), log));
        let (cgroup, opened, path) = made.await.map_err(|e| LaunchError {
            what: format!("manager {manager}"),
            source: e.into(),
        })?;
        let cgroup = match cgroup {
            Ok(Some(cgroup)) => Some(cgroup),
            Ok(None) => return Err(LaunchError::ending()),
            Err(e) => {
                self.without_cgroups(&e);
                None
            }
        };
        let (log, log_start) = match opened {
            Ok(opened) => opened,
            Err(source) => {
                if let Some(cgroup) = cgroup {
                    // It cannot panic.
                    let _ = spawn_blocking(move || remove(&cgroup)).await;
                }
                let what = path.display().to_string();
                return Err(LaunchError { what, source });
            }
        };
        let birth = cgroup.as_ref().filter(|c| c.version() == Version::V2);
        let ground = Ground {
            log,
            // Without it, a process is put there after its birth.
            cgroup: birth.and_then(|cgroup| File::open(cgroup.path()).ok()),
        };
        Ok(Prepared {
            cgroup,
            ground,
            log_start,
        })
    }

    /// Puts a process that was just started into its group, before it is greeted.
    pub(super) async fn enter(&self, cgroup: Option<Cgroup>, pid: u32) -> Option<Cgroup> {
        let cgroup = cgroup?;
        let entered = spawn_blocking(move || match cgroup.join(pid) {
            Ok(()) => Ok(cgroup),
            Err(e) => {
                remove(&cgroup);
                Err(e)
            }
        });
        match entered.await {
            Ok(Ok(cgroup)) => Some(cgroup),
            // One that has ended already is told by its exit.
            Ok(Err(e)) if e.raw_os_error() == Some(rustix::io::Errno::SRCH.raw_os_error()) => None,
            Ok(Err(e)) => {
                self.without_cgroups(&e);
                None
            }
            Err(_) => None,
        }
    }

    /// The group that the manager of a run folder is in.
    pub(super) async fn cgroup_of(&self, folder: &Path, pid: u32) -> io::Result<Option<Cgroup>> {
        let (cgroups, name) = (self.cgroups.clone(), self.folders.cgroup(folder));
        Ok(spawn_blocking(move || cgroups.holding(&name, pid)).await?)
    }

    fn without_cgroups(&self, why: &dyn std::error::Error) {
        if self.no_cgroups.set(()).is_ok() {
            tracing::info!(
                "managers have a process group only: {why}; what leaves that group by setsid is not ended with them"
            );
        }
    }

    /// Kills what is left in control groups whose manager has no run folder any more, and removes them.
    pub(super) async fn bury_cgroups(&self, living: &[PathBuf]) {
        let cgroups = self.cgroups.clone();
        let mut orphans = spawn_blocking(move || cgroups.find())
            .await
            .unwrap_or_default();
        orphans.retain(|cgroup| {
            let folder = self.folders.of_cgroup(cgroup.name());
            folder.is_some_and(|folder| !living.contains(&folder) && !folder.exists())
        });
        let buried = spawn_blocking(move || {
            for orphan in orphans {
                if let Err(e) = bury_cgroup(&orphan) {
                    tracing::warn!("cannot remove {}: {e}", orphan.path().display());
                }
            }
        });
        // It cannot panic.
        let _ = buried.await;
    }
}
