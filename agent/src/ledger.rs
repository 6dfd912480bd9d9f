//! The ledger: the last NodeSpec that was accepted, durable, and the fence that refuses the past.

mod fence;
mod sealed;
#[cfg(test)]
mod tests;

use std::io;
use std::path::PathBuf;

use rts_agent_api::messages::{NodeSpecEnvelope, NodeSpecReceipt};
use rts_http::problem::Problem;

pub(crate) use fence::{Fence, ledger_fence};
use fence::{Verdict, judge};
pub(crate) use sealed::Sealed;

/// Name of the ledger's file in the state folder.
const FILE: &str = "node-spec.json";

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

/// Where a ledger lies.
pub(crate) trait Store: Send + Sync + 'static {
    /// The last contents that were saved; none when there are none.
    fn load(&self) -> Result<Option<Sealed>, LedgerError>;
    /// Replaces the contents. Durable when it returns.
    fn save(&self, sealed: &Sealed) -> io::Result<()>;
}

/// A file.
#[derive(Debug)]
pub(crate) struct FileStore {
    path: PathBuf,
}

impl FileStore {
    /// The ledger of a state folder.
    pub fn new(state: &std::path::Path) -> Self {
        Self {
            path: state.join(FILE),
        }
    }
}

impl Store for FileStore {
    fn load(&self) -> Result<Option<Sealed>, LedgerError> {
        let bytes = match std::fs::read(&self.path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(source) => {
                let path = self.path.clone();
                return Err(LedgerError::Read { path, source });
            }
        };
        let damaged = |reason: String| LedgerError::Damaged {
            path: self.path.clone(),
            reason,
        };
        let sealed: Sealed = serde_json::from_slice(&bytes).map_err(|e| damaged(e.to_string()))?;
        if !sealed.is_whole() {
            return Err(damaged("its digest does not fit its contents".to_owned()));
        }
        Ok(Some(sealed))
    }

    fn save(&self, sealed: &Sealed) -> io::Result<()> {
        rts_host::files::replace_durably(&self.path, &serde_json::to_vec_pretty(sealed)?)
    }
}

/// The ledger of a running agent.
pub(crate) struct Ledger {
    node: String,
    store: std::sync::Arc<dyn Store>,
    held: Option<Sealed>,
}

impl Ledger {
    /// Reads what was accepted last.
    pub fn load(node: &str, store: std::sync::Arc<dyn Store>) -> Result<Self, LedgerError> {
        Ok(Self {
            node: node.to_owned(),
            held: store.load()?,
            store,
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
            let store = self.store.clone();
            let (offered, saved) = tokio::task::spawn_blocking(move || {
                let saved = store.save(&offered);
                (offered, saved)
            })
            .await
            .map_err(|e| Problem::internal(format!("the ledger's write failed: {e}")))?;
            saved.map_err(|e| {
                Problem::internal(format!("cannot save the node spec of {}: {e}", self.node))
            })?;
            self.held = Some(offered);
        }
        Ok(NodeSpecReceipt {
            generation,
            changed,
        })
    }
}
