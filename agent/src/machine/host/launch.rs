//! How a manager process is started: one that is ready is told who it is; else the zygote makes one; else it is spawned.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::fd::AsFd;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::Arc;

use rts_host::cgroup::Cgroup;
use rts_manager_api::control::SystemId;
use rts_manager_api::zygote::Become;
use rts_manager_api::{frame, passing};

use super::child::Child;
use super::nursery::{Nursery, Ready};
use super::spawn::Spawner;
use crate::launch::{LaunchError, Start};
use crate::log_mark;

/// Starts manager processes.
#[derive(Debug)]
pub(super) struct Launcher {
    program: Box<Path>,
    spawner: Spawner,
    /// None where each is spawned.
    nursery: Option<Arc<Nursery>>,
}

/// What is there for a start.
pub(super) struct Ground {
    /// Opened for appending.
    pub log: File,
    /// Folder of a control group that a process can be born in.
    pub cgroup: Option<File>,
}

/// A process that was started, and whether it is in its control group already.
pub(super) struct Born {
    /// The process.
    pub child: Child,
    /// True when it was born there.
    pub in_cgroup: bool,
}

/// Opens the log of a start for appending, marks it, and gives its length.
pub(super) fn open_log(start: &Start) -> Result<(File, u64), LaunchError> {
    let (path, who) = (&start.log, start.key.display_name());
    if let Err(e) = log_mark::mark(path, &who) {
        // A full disk must not stop a robot.
        tracing::warn!("cannot mark the log {}: {e}", path.display());
    }
    let mut options = OpenOptions::new();
    let opened = options.append(true).create(true).mode(0o600).open(path);
    opened
        .and_then(|log| Ok((log.metadata()?.len(), log)))
        .map(|(length, log)| (log, length))
        .map_err(|source| LaunchError {
            what: path.display().to_string(),
            source,
        })
}

impl Launcher {
    /// Starts this program.
    pub fn new(program: &Path, nursery: Option<Arc<Nursery>>) -> Self {
        Self {
            program: program.into(),
            spawner: Spawner::new(program),
            nursery,
        }
    }

    /// What keeps processes ready.
    pub fn nursery(&self) -> Option<&Arc<Nursery>> {
        self.nursery.as_ref()
    }

    /// One that is ready in a control group of its own, told who it is.
    pub fn waiting(&self, start: &Start, log: &File) -> Option<(Child, Option<Cgroup>)> {
        let ready = waiting(self.nursery.as_ref()?, start, log, true)?;
        Some((ready.child, ready.cgroup))
    }

    /// Starts one, and does not wait until it serves.
    pub async fn launch(&self, start: &Start, ground: Ground) -> Result<Born, LaunchError> {
        if let Some(nursery) = &self.nursery
            && let Some(born) = from(nursery, start, &ground).await
        {
            return Ok(born);
        }
        let child = self.spawner.spawn(start, ground.log).await;
        let child = child.map_err(|source| LaunchError {
            what: self.program.display().to_string(),
            source,
        })?;
        Ok(Born {
            child,
            in_cgroup: false,
        })
    }
}

/// One that is ready, or a new copy of the zygote; none when neither is to be had.
async fn from(nursery: &Arc<Nursery>, start: &Start, ground: &Ground) -> Option<Born> {
    match waiting(nursery, start, &ground.log, false) {
        Some(ready) => Some(Born {
            child: ready.child,
            in_cgroup: false,
        }),
        None => copy(nursery, start, ground).await,
    }
}

/// One that is ready, in a control group of its own or in none, and is told who it is.
fn waiting(nursery: &Nursery, start: &Start, log: &File, in_group: bool) -> Option<Ready> {
    while let Some(ready) = nursery.take(in_group) {
        let cgroup = ready.cgroup.as_ref().map(Cgroup::name);
        match name(&ready.child, start, log, cgroup) {
            Ok(()) => return Some(ready),
            Err(e) => {
                let pid = ready.child.pid;
                tracing::info!(pid, "a manager that was ready is none: {e}");
                ready.let_go(nursery.groups());
            }
        }
    }
    None
}

/// A new copy, told who it is.
async fn copy(nursery: &Nursery, start: &Start, ground: &Ground) -> Option<Born> {
    let born = nursery.fork(ground.cgroup.as_ref()).await?;
    match name(&born.child, start, &ground.log, None) {
        Ok(()) => Some(born),
        Err(e) => {
            tracing::warn!(
                pid = born.child.pid,
                "a copy of the zygote is no manager: {e}"
            );
            born.child.let_go();
            None
        }
    }
}

/// Tells a process who it is.
fn name(child: &Child, start: &Start, log: &File, cgroup: Option<&str>) -> io::Result<()> {
    let system = start.key.system.as_ref();
    let named = Become {
        dir: start.folder.clone(),
        name: start.key.name.clone(),
        system: system.map(|system| SystemId {
            name: system.name.clone(),
            uid: system.uid.clone(),
        }),
        incarnation: start.incarnation.clone(),
        cgroup: cgroup.map(str::to_owned),
    };
    let bytes = frame::encode(&named).map_err(io::Error::other)?;
    // Into an empty socket, where it has room.
    let sent = passing::send(&child.control, &bytes, &[log.as_fd()])?;
    match sent == bytes.len() {
        true => Ok(()),
        false => Err(io::ErrorKind::WriteZero.into()),
    }
}
