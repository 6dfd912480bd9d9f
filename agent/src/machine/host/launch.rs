//! How a manager process is started: one that is ready is told who it is; else the zygote makes one; else it is spawned.

use std::fs::File;
use std::io;
use std::os::fd::AsFd;
use std::path::Path;
use std::sync::Arc;

use rts_manager_api::control::SystemId;
use rts_manager_api::zygote::Become;
use rts_manager_api::{frame, passing};

use super::child::Child;
use super::nursery::Nursery;
use super::spawn::Spawner;
use crate::launch::{LaunchError, Start};

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
    match waiting(nursery, start, ground) {
        Some(born) => Some(born),
        None => copy(nursery, start, ground).await,
    }
}

/// One that is ready, and is told who it is.
fn waiting(nursery: &Nursery, start: &Start, ground: &Ground) -> Option<Born> {
    while let Some(child) = nursery.idle() {
        match name(&child, start, &ground.log) {
            Ok(()) => {
                return Some(Born {
                    child,
                    in_cgroup: false,
                });
            }
            Err(e) => {
                tracing::info!(pid = child.pid, "a manager that was ready is none: {e}");
                child.let_go();
            }
        }
    }
    None
}

/// A new copy, told who it is.
async fn copy(nursery: &Nursery, start: &Start, ground: &Ground) -> Option<Born> {
    let born = nursery.fork(ground.cgroup.as_ref()).await?;
    match name(&born.child, start, &ground.log) {
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
fn name(child: &Child, start: &Start, log: &File) -> io::Result<()> {
    let system = start.key.system.as_ref();
    let named = Become {
        dir: start.folder.clone(),
        name: start.key.name.clone(),
        system: system.map(|system| SystemId {
            name: system.name.clone(),
            uid: system.uid.clone(),
        }),
        incarnation: start.incarnation.clone(),
    };
    let bytes = frame::encode(&named).map_err(io::Error::other)?;
    // Into an empty socket, where it has room.
    let sent = passing::send(&child.control, &bytes, &[log.as_fd()])?;
    match sent == bytes.len() {
        true => Ok(()),
        false => Err(io::ErrorKind::WriteZero.into()),
    }
}
