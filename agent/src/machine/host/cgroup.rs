//! The control groups of managers: made before a start, entered right after it, and buried when nobody owns them.

use std::path::{Path, PathBuf};

use rts_host::cgroup::{Cgroup, NotPermitted};
use tokio::task::spawn_blocking;

use super::Host;
use super::family::remove;
use super::tenant::bury_cgroup;
use crate::launch::{LaunchError, Start};
use crate::machine::GROUP_END;

impl Host {
    /// An empty control group for a start; `None` where none is permitted. What the one before left is killed first.
    pub(super) async fn make_cgroup(&self, start: &Start) -> Result<Option<Cgroup>, LaunchError> {
        let (cgroups, name) = (self.cgroups.clone(), self.folders.cgroup(&start.folder));
        let made = spawn_blocking(move || {
            let cgroup = cgroups.create(&name)?;
            Ok::<_, NotPermitted>((cgroup.kill_within(GROUP_END), cgroup))
        });
        match made.await {
            Ok(Ok((true, cgroup))) => Ok(Some(cgroup)),
            Ok(Ok((false, _))) => Err(LaunchError::ending()),
            Ok(Err(e)) => {
                self.without_cgroups(&e);
                Ok(None)
            }
            Err(e) => Err(LaunchError {
                what: format!("manager {}", start.key.display_name()),
                source: e.into(),
            }),
        }
    }

    /// Puts a process that was just started into its group, before it is told anything.
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
        pid: u32,
    ) -> std::io::Result<Option<Cgroup>> {
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
