//! The control groups of managers: made before a start, entered at birth or right after it, and buried when nobody owns
//! them.

use std::io;
use std::path::{Path, PathBuf};

use rts_host::cgroup::Cgroup;
use rts_manager_api::files::ManagerFile;
use tokio::task::spawn_blocking;

use super::Host;
use super::family::remove;
use super::tenant::bury_cgroup;
use crate::launch::{LaunchError, Start};

impl Host {
    /// An empty control group for a start; none where none is permitted. What the one before left in it is killed first.
    pub(super) async fn group(&self, start: &Start) -> Result<Option<Cgroup>, LaunchError> {
        if let Some(fresh) = self.groups.fresh(&start.folder) {
            return Ok(Some(fresh));
        }
        let (groups, folder) = (self.groups.clone(), start.folder.clone());
        let made = spawn_blocking(move || groups.make(&folder)).await;
        let made = made.map_err(|e| LaunchError {
            what: format!("manager {}", start.key.display_name()),
            source: e.into(),
        })?;
        match made {
            Ok(None) => Err(LaunchError::ending()),
            Ok(made) => Ok(made),
            Err(e) => {
                self.without_cgroups(&e);
                Ok(None)
            }
        }
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
    pub(super) async fn cgroup_of(
        &self,
        folder: &Path,
        file: &ManagerFile,
    ) -> io::Result<Option<Cgroup>> {
        let (groups, folder, file) = (self.groups.clone(), folder.to_owned(), file.clone());
        let held = move || groups.holding(&folder, file.cgroup.as_deref(), file.pid);
        Ok(spawn_blocking(held).await?)
    }

    fn without_cgroups(&self, why: &dyn std::error::Error) {
        if self.no_cgroups.set(()).is_ok() {
            tracing::info!(
                "managers have a process group only: {why}; what leaves that group by setsid is not ended with them"
            );
        }
    }

    /// Kills what is left in control groups whose manager has no run folder any more, and removes them.
    pub(super) async fn bury_cgroups(&self, living: Vec<PathBuf>) {
        let groups = self.groups.clone();
        let buried = spawn_blocking(move || {
            for orphan in groups.orphans(&living) {
                if let Err(e) = bury_cgroup(&orphan) {
                    tracing::warn!("cannot remove {}: {e}", orphan.path().display());
                }
            }
        });
        // It cannot panic.
        let _ = buried.await;
    }
}
