//! Finding managers that were started by an earlier agent, and taking them over.

use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use rts_host::identity::{boot_id, start_ticks};
use rts_host::process::group_lives;
use rts_manager_api::files::{CONTROL_SOCKET, LOCK, MANAGER_JSON, ManagerFile};
use rts_plan::desired::{ManagerKey, SystemRef};
use rustix::fs::FlockOperation;
use rustix::process::Signal;
use tokio::time::{Instant, sleep};

use super::{Identity, Manager};
use crate::agent::Agent;
use crate::events::of_manager;
use crate::folders::{folder_id, is_folder_id};
use crate::launch::Exit;
use crate::pidfd::PidFd;
use crate::process::signal_group;

/// How long a manager that holds its lock may take to describe itself.
const DESCRIBE: Duration = Duration::from_secs(2);
/// Largest description in bytes.
const MAX_FILE: u64 = 64 * 1024;

/// Adopts the live managers of the node and removes the folders of dead ones.
pub(crate) async fn adopt_all(agent: &Arc<Agent>) {
    let Ok(entries) = fs::read_dir(&agent.folders.run) else {
        return;
    };
    for entry in entries.flatten() {
        if entry.file_name().to_str().is_some_and(is_folder_id) {
            look_at(agent, &entry.path()).await;
        }
    }
}

async fn look_at(agent: &Arc<Agent>, folder: &Path) {
    let end = Instant::now() + DESCRIBE;
    loop {
        if !is_locked(folder) {
            bury(folder);
            return;
        }
        match adopt(agent, folder) {
            Ok(()) => return,
            // It may be about to write its file, or about to end.
            Err(_) if Instant::now() < end => sleep(Duration::from_millis(50)).await,
            Err(e) => {
                let folder = folder.display();
                tracing::error!("cannot adopt the manager in {folder}, it is left alone: {e}");
                return;
            }
        }
    }
}

fn adopt(agent: &Arc<Agent>, folder: &Path) -> io::Result<()> {
    let file = describe(folder)?;
    let key = ManagerKey {
        system: file.system.as_ref().map(|s| SystemRef {
            name: s.name.clone(),
            uid: s.uid.clone(),
        }),
        name: file.name,
    };
    if folder.file_name().and_then(|n| n.to_str()) != Some(folder_id(&key).as_str()) {
        let message = format!("its file says that it is {}", key.display_name());
        return Err(io::Error::other(message));
    }
    let pidfd = PidFd::open(file.pid, Some(file.start_ticks))?;
    let pid = file.pid;
    let identity = Identity {
        key: key.clone(),
        incarnation: file.incarnation,
        pid,
        folder: folder.to_owned(),
    };
    let manager = Manager::new(agent, identity, None);
    let _ = manager.started.set(file.started);
    let exit = async move {
        pidfd.ended().await;
        signal_group(pid, Signal::KILL);
        Exit::Unknown
    };
    agent.register(manager, Box::pin(exit));
    let message = format!("process {pid} was found running");
    agent
        .events
        .push(of_manager("Normal", "ManagerAdopted", &key, message));
    Ok(())
}

fn describe(folder: &Path) -> io::Result<ManagerFile> {
    use std::io::Read;
    let mut text = Vec::new();
    File::open(folder.join(MANAGER_JSON))?
        .take(MAX_FILE)
        .read_to_end(&mut text)?;
    Ok(serde_json::from_slice(&text)?)
}

/// True when a live manager holds the folder.
pub(super) fn is_locked(folder: &Path) -> bool {
    let Ok(file) = File::open(folder.join(LOCK)) else {
        return false;
    };
    rustix::fs::flock(&file, FlockOperation::NonBlockingLockShared)
        == Err(rustix::io::Errno::WOULDBLOCK)
}

/// Removes the folder of a dead manager, and what is left of its process group.
fn bury(folder: &Path) {
    if let Ok(file) = describe(folder)
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
    let _ = fs::remove_file(folder.join(CONTROL_SOCKET));
    if let Err(e) = fs::remove_dir_all(folder) {
        tracing::warn!("cannot remove {}: {e}", folder.display());
    }
}
