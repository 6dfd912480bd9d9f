//! The ledger: the last NodeSpec that was accepted, made durable while it is carried out, and the fence that refuses the
//! past.

mod fence;
mod file;
mod sealed;
#[cfg(test)]
mod tests;
mod text;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rts_agent_api::messages::{LedgerFence, NodeSpecEnvelope, NodeSpecReceipt};
use rts_host::disk::Disk;
use rts_http::problem::Problem;

pub(crate) use fence::{Fence, ledger_fence};
use fence::{Verdict, judge};
pub use file::newest;
use file::{Files, Numbered};
pub(crate) use sealed::Sealed;

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

/// The ledger of a running agent: what it obeys. That is durable a moment later, see [`Files`].
pub(crate) struct Ledger {
    node: String,
    files: Arc<Files>,
    /// With its number: each spec that is accepted has the next one.
    held: Option<Numbered>,
}

impl Ledger {
    /// Reads what was accepted last from a state folder.
    pub async fn load(node: &str, state: &Path, disk: Arc<dyn Disk>) -> Result<Self, LedgerError> {
        let (files, held) = Files::load(state, disk).await?;
        Ok(Self {
            node: node.to_owned(),
            files: Arc::new(files),
            held,
        })
    }

    /// What it holds.
    pub fn held(&self) -> Option<&NodeSpecEnvelope> {
        self.sealed().map(|sealed| sealed.envelope())
    }

    /// The same, with its text.
    pub fn sealed(&self) -> Option<&Arc<Sealed>> {
        self.held.as_ref().map(|(_, sealed)| sealed)
    }

    /// The fence of what it holds.
    pub fn fence(&self) -> Option<Fence> {
        self.held().map(Fence::of)
    }

    /// What is on the disk.
    pub fn saved(&self) -> Option<LedgerFence> {
        self.files.saved()
    }

    /// What makes it durable.
    pub fn saver(&self) -> Saver {
        Saver {
            node: self.node.clone(),
            files: self.files.clone(),
            held: self.held.clone(),
        }
    }

    /// Accepts or refuses a write. What it accepts counts when it returns, and is durable once its [`saver`] has ended:
    /// should power be lost before, nothing that runs is left that it could be missed for. What tells whom the node obeys
    /// is durable before it counts, and so is everything as long as the disk does not work. Must not be dropped before.
    ///
    /// [`saver`]: Ledger::saver
    pub async fn accept(&mut self, offered: Sealed) -> Result<NodeSpecReceipt, Problem> {
        let verdict = judge(&self.node, self.held(), &offered)?;
        let offered = offered.accepted();
        let generation = offered.envelope().generation;
        let changed = verdict == Verdict::Newer;
        if changed {
            let lags = self.may_lag(offered.envelope());
            let number = self.held.as_ref().map_or(0, |(number, _)| *number);
            let numbered = (number.saturating_add(1), Arc::new(offered));
            if !lags {
                let (node, files) = (self.node.clone(), self.files.clone());
                let held = Some(numbered.clone());
                Saver { node, files, held }.save().await?;
            }
            self.held = Some(numbered);
        }
        Ok(NodeSpecReceipt {
            generation,
            changed,
        })
    }

    /// True for a spec of the same store and epoch as the one that is held.
    fn may_lag(&self, offered: &NodeSpecEnvelope) -> bool {
        let whose = |spec: &NodeSpecEnvelope| (spec.cluster_uid.clone(), spec.epoch);
        let same = |held| whose(held) == whose(offered);
        self.held().is_some_and(same) && !self.files.failed()
    }
}

/// Makes what a ledger held durable.
pub(crate) struct Saver {
    node: String,
    files: Arc<Files>,
    held: Option<Numbered>,
}

impl Saver {
    /// Durable when it ends well, this or something later. Must not be dropped before.
    pub async fn save(&self) -> Result<(), Problem> {
        let Some((number, sealed)) = &self.held else {
            return Ok(());
        };
        let saved = self.files.save(*number, sealed).await;
        saved.map_err(|e| {
            Problem::internal(format!("cannot save the node spec of {}: {e}", self.node))
        })
    }
}
