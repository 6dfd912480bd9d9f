//! The locks of a node: one agent at a time. One lies in `run`, where people and other programs look; the other lies
//! beside the ledger that it protects, and outlives a careless hand in `run`.

use std::path::{Path, PathBuf};
use std::time::Duration;

use rts_host::files;
use tokio::time::{Instant, sleep};

use crate::agent::StartError;
use crate::folders::Folders;

/// Name in either folder.
const FILE: &str = "agent.lock";
/// How long the agent before may hold them: longer than its last requests and its last write take.
const PATIENCE: Duration = Duration::from_secs(5);
/// Between two tries.
const PAUSE: Duration = Duration::from_millis(50);

/// Both locks, held for life.
#[derive(Debug)]
pub(super) struct NodeLock {
    node: String,
    /// The durable one is taken first.
    locks: [Held; 2],
}

/// A lock, and where its file was.
#[derive(Debug)]
struct Held {
    path: PathBuf,
    lock: files::Lock,
}

impl NodeLock {
    /// Takes both. The agent before may just be ending.
    pub async fn take(folders: &Folders, node: &str) -> Result<Self, StartError> {
        let state = take(&folders.state, node).await?;
        let run = take(&folders.run, node).await?;
        Ok(Self {
            node: node.to_owned(),
            locks: [state, run],
        })
    }

    /// Takes again what somebody has removed or replaced; an error when another agent has it by now.
    pub fn keep(&mut self) -> Result<(), StartError> {
        for held in &mut self.locks {
            if held.lock.is_at(&held.path) {
                continue;
            }
            let path = held.path.clone();
            tracing::warn!("{} was gone or replaced; it is taken anew", path.display());
            match try_take(&path)? {
                Some(anew) => *held = anew,
                None => return Err(running(&self.node, path)),
            }
        }
        Ok(())
    }
}

async fn take(folder: &Path, node: &str) -> Result<Held, StartError> {
    let path = folder.join(FILE);
    let end = Instant::now() + PATIENCE;
    loop {
        if let Some(held) = try_take(&path)? {
            return Ok(held);
        }
        if Instant::now() >= end {
            return Err(running(node, path));
        }
        sleep(PAUSE).await;
    }
}

fn try_take(path: &Path) -> Result<Option<Held>, StartError> {
    let lock = files::lock(path).map_err(|source| StartError::File {
        path: path.to_owned(),
        source,
    })?;
    Ok(lock.map(|lock| Held {
        path: path.to_owned(),
        lock,
    }))
}

fn running(node: &str, lock: PathBuf) -> StartError {
    let node = node.to_owned();
    StartError::Running { node, lock }
}
