//! Finding managers that were started by an earlier agent, and taking them over.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use rts_manager_api::files::ManagerFile;
use rts_plan::desired::{ManagerKey, SystemRef};
use tokio::time::{Instant, sleep};

use super::{Identity, Manager, Undying};
use crate::agent::Agent;
use crate::events::{lock, of_manager};
use crate::folders::folder_id;
use crate::machine::{DESCRIBE, Found, Tenant};

/// Pause between two looks at a folder.
const PAUSE: Duration = Duration::from_millis(50);

/// Adopts the live managers of the node and removes the folders of dead ones. Waits for those that are just starting.
pub(crate) async fn adopt_all(agent: &Arc<Agent>) {
    // A little longer than a folder is young.
    let end = Instant::now() + DESCRIBE + 2 * PAUSE;
    while !adopt_round(agent).await && Instant::now() < end {
        sleep(PAUSE).await;
    }
    let left = unknown_folders(agent).await;
    for folder in left {
        tracing::error!(
            "{} is held by a process that does not say who it is, or that does not die; it is looked at again now and then",
            folder.display()
        );
    }
}

/// Looks once at every folder that is not a known manager's; false when one of them could not be settled.
pub(crate) async fn adopt_round(agent: &Arc<Agent>) -> bool {
    // Nobody makes or removes a folder meanwhile; whoever starts a manager waits, and then finds it adopted.
    let _folders = agent.managers.folders.lock().await;
    forget_undying(agent).await;
    let mut settled = true;
    for folder in unknown_folders(agent).await {
        match settle(agent, &folder).await {
            Ok(Settled::Adopted(_) | Settled::Free | Settled::Undying) => {}
            Ok(Settled::Held) => settled = false,
            Err(e) => {
                settled = false;
                tracing::debug!("cannot tell who lives in {}: {e}", folder.display());
            }
        }
    }
    settled
}

/// Forgets what does not die where its folder is gone.
async fn forget_undying(agent: &Agent) {
    let folders: Vec<PathBuf> = lock(&agent.managers.undying).keys().cloned().collect();
    for folder in folders {
        if matches!(agent.inputs.machine.look(&folder).await, Ok(Tenant::None)) {
            lock(&agent.managers.undying).remove(&folder);
        }
    }
}

async fn unknown_folders(agent: &Agent) -> Vec<PathBuf> {
    let mut folders = agent.inputs.machine.run_folders().await;
    folders.sort();
    let starting: Vec<_> = {
        let starting = lock(&agent.managers.starting);
        starting.keys().map(|k| agent.folders.manager(k)).collect()
    };
    let live: Vec<_> = {
        let live = lock(&agent.managers.live);
        live.values().map(|m| m.folder.clone()).collect()
    };
    folders.retain(|folder| !starting.contains(folder) && !live.contains(folder));
    folders
}

/// What became of a folder.
pub(super) enum Settled {
    /// Its manager is ours now.
    Adopted(Arc<Manager>),
    /// Nothing is there any more.
    Free,
    /// Somebody may live there; perhaps he says who he is later.
    Held,
    /// Its manager is dead, and something that it started does not die.
    Undying,
}

/// Adopts the manager of a folder, or removes the folder when it is positively dead. Call it with
/// [`super::Managers::folders`] locked.
pub(super) async fn settle(agent: &Arc<Agent>, folder: &Path) -> io::Result<Settled> {
    let machine = &agent.inputs.machine;
    match machine.look(folder).await? {
        Tenant::None => Ok(Settled::Free),
        Tenant::Gone(file) => {
            let before = lock(&agent.managers.undying).get(folder).copied();
            if before.is_some_and(|undying| undying.next > Instant::now()) {
                return Ok(Settled::Undying);
            }
            if let (Some(file), None) = (&file, before) {
                // While its folder tells of it.
                agent.manager_died_unseen(file).await;
            }
            let buried = machine.bury(folder, file).await;
            let mut undying = lock(&agent.managers.undying);
            match buried {
                Ok(()) => {
                    undying.remove(folder);
                    Ok(Settled::Free)
                }
                Err(e) => {
                    undying.insert(folder.to_owned(), Undying::after(before));
                    tracing::warn!("cannot remove {}: {e}", folder.display());
                    Ok(Settled::Undying)
                }
            }
        }
        Tenant::Nameless => Ok(Settled::Held),
        Tenant::Lives(file) => adopt(agent, folder, file).await.map(Settled::Adopted),
    }
}

async fn adopt(agent: &Arc<Agent>, folder: &Path, file: ManagerFile) -> io::Result<Arc<Manager>> {
    let key = ManagerKey {
        system: file.system.as_ref().map(|s| SystemRef {
            name: s.name.clone(),
            uid: s.uid.clone(),
        }),
        name: file.name.clone(),
    };
    if folder.file_name().and_then(|n| n.to_str()) != Some(folder_id(&key).as_str()) {
        let message = format!("its file says that it is {}", key.display_name());
        return Err(io::Error::other(message));
    }
    let known = lock(&agent.managers.live).get(&key).cloned();
    if let Some(manager) = known.filter(|m| m.incarnation == file.incarnation) {
        return Ok(manager);
    }
    let Found { family, exit } = agent.inputs.machine.find(folder, &file).await?;
    let pid = file.pid;
    let name = Identity {
        key: key.clone(),
        incarnation: file.incarnation,
        family,
        folder: folder.to_owned(),
    };
    let manager = Manager::new(agent, name, None);
    let _ = manager.started.set(file.started);
    agent.register(manager.clone(), exit);
    let message = format!("process {pid} was found running");
    agent
        .events
        .push(of_manager("Normal", "ManagerAdopted", &key, message));
    Ok(manager)
}

/// Kills what managers left behind that have no run folder any more.
pub(crate) async fn bury_orphans(agent: &Arc<Agent>) {
    // Nobody makes or removes a folder meanwhile.
    let _folders = agent.managers.folders.lock().await;
    let living = agent
        .managers
        .all()
        .iter()
        .map(|m| m.folder.clone())
        .collect();
    agent.inputs.machine.bury_orphans(living).await;
}
