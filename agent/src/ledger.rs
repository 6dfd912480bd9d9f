//! The ledger: the last NodeSpec that was accepted, durable, and the fence that refuses the past.

mod fence;
mod sealed;
#[cfg(test)]
mod tests;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rts_agent_api::messages::{NodeSpecEnvelope, NodeSpecReceipt};
use rts_host::disk::{Disk, replace_durably};
use rts_http::problem::Problem;

pub(crate) use fence::{Fence, ledger_fence};
use fence::{Verdict, judge};
pub(crate) use sealed::Sealed;

/// Name of the ledger's file in the state folder.
const FILE: &str = "node-spec.json";
/// Largest file in bytes: more than a request may have.
const MAX_FILE: u64 = 128 * 1024 * 1024;

/// A ledger that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum LedgerError {
    /// The file cannot be read.
    #[error("cannot read the ledger {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file makes no sense.
    #[error(
        "the ledger {} is damaged: {reason}; move it away, and the controller will send it anew",
        path.display()
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
}

/// What a disk holds; none when it was told nothing yet.
async fn read(disk: &dyn Disk, path: &Path) -> Result<Option<Sealed>, LedgerError> {
    let bytes = match disk.read(path, MAX_FILE).await {
        Ok(Some(bytes)) => bytes,
        Ok(None) => return Ok(None),
        Err(source) => {
            let path = path.to_owned();
            return Err(LedgerError::Read { path, source });
        }
    };
    let damaged = |reason: String| LedgerError::Damaged {
        path: path.to_owned(),
        reason,
    };
    let sealed: Sealed = serde_json::from_slice(&bytes).map_err(|e| damaged(e.to_string()))?;
    if !sealed.is_whole() {
        return Err(damaged("its digest does not fit its contents".to_owned()));
    }
    Ok(Some(sealed))
}

/// The ledger of a running agent.
pub(crate) struct Ledger {
    node: String,
    disk: Arc<dyn Disk>,
    path: PathBuf,
    held: Option<Sealed>,
}

impl Ledger {
    /// Reads what was accepted last from a state folder.
    pub async fn load(node: &str, state: &Path, disk: Arc<dyn Disk>) -> Result<Self, LedgerError> {
        let path = state.join(FILE);
        Ok(Self {
            node: node.to_owned(),
            held: read(&*disk, &path).await?,
            disk,
            path,
        })
    }

    /// What it holds.
    pub fn held(&self) -> Option<&NodeSpecEnvelope> {
        self.sealed().map(Sealed::envelope)
    }

    /// The same, with its text.
    pub fn sealed(&self) -> Option<&Sealed> {
        self.held.as_ref()
    }

    /// The fence of what it holds.
    pub fn fence(&self) -> Option<Fence> {
        self.held().map(Fence::of)
    }

    /// Accepts or refuses a write; durable when it returns. Must not be dropped before: disk and memory would differ.
    pub async fn put(&mut self, offered: Sealed) -> Result<NodeSpecReceipt, Problem> {
        let verdict = judge(&self.node, self.held(), &offered)?;
        let offered = offered.accepted();
        let generation = offered.envelope().generation;
        let changed = verdict == Verdict::Newer;
        if changed {
            self.save(&offered).await.map_err(|e| {
                Problem::internal(format!("cannot save the node spec of {}: {e}", self.node))
            })?;
            self.held = Some(offered);
        }
        Ok(NodeSpecReceipt {
            generation,
            changed,
        })
    }

    /// Replaces what is on disk. Durable when it returns.
    async fn save(&self, sealed: &Sealed) -> io::Result<()> {
        let text = serde_json::to_vec_pretty(sealed)?;
        replace_durably(&*self.disk, &self.path, text).await
    }
}
