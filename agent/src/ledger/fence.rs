//! The fence: which write is newer than what the ledger holds, which is of the past, and which comes from a stranger.

use rts_agent_api::messages::{LedgerFence, NodeSpecEnvelope};
use rts_http::problem::Problem;

use super::Sealed;

/// What orders were given under: only those of the very spec that the ledger holds are obeyed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Fence {
    /// Uid of the controller's store.
    pub cluster_uid: String,
    /// Epoch of the controller's store.
    pub epoch: u64,
    /// Generation of the NodeSpec.
    pub generation: u64,
}

impl Fence {
    /// The fence of a spec.
    pub fn of(spec: &NodeSpecEnvelope) -> Self {
        Self {
            cluster_uid: spec.cluster_uid.clone(),
            epoch: spec.epoch,
            generation: spec.generation,
        }
    }
}

impl std::fmt::Display for Fence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            cluster_uid,
            epoch,
            generation,
        } = self;
        write!(
            f,
            "generation {generation} of cluster {cluster_uid}, epoch {epoch}"
        )
    }
}

/// What a write means for the ledger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It is what the ledger holds already.
    Same,
    /// It replaces what the ledger holds.
    Newer,
}

/// Decides on a write. `node` is this node's name, `held` what the ledger holds.
pub(super) fn judge(
    node: &str,
    held: Option<&NodeSpecEnvelope>,
    offered: &Sealed,
) -> Result<Verdict, Problem> {
    if !offered.is_whole() {
        return Err(Problem::invalid(
            "digest-mismatch",
            "the digest does not fit the node spec: it was changed on its way",
        ));
    }
    let offered = offered.envelope();
    if offered.spec.node != node {
        return Err(Problem::invalid(
            "wrong-node",
            format!("this is node {node}; the spec is for {}", offered.spec.node),
        ));
    }
    let Some(held) = held else {
        return Ok(Verdict::Newer);
    };
    if held.cluster_uid == offered.cluster_uid {
        return fence(node, held, offered);
    }
    let free = match &offered.take_over {
        Some(meant) => *meant == ledger_fence(held),
        // Nobody misses an empty one.
        None => held.spec.systems.is_empty(),
    };
    if free {
        Ok(Verdict::Newer)
    } else {
        Err(foreign(node, held, offered))
    }
}

/// What a ledger holds, in the words of a greeting.
pub(crate) fn ledger_fence(held: &NodeSpecEnvelope) -> LedgerFence {
    LedgerFence {
        cluster_uid: held.cluster_uid.clone(),
        epoch: held.epoch,
        generation: held.generation,
        digest: held.digest.clone(),
    }
}

fn fence(
    node: &str,
    held: &NodeSpecEnvelope,
    offered: &NodeSpecEnvelope,
) -> Result<Verdict, Problem> {
    use std::cmp::Ordering::{Equal, Greater, Less};
    let stale = |code, what: &str, offered, held| {
        let detail =
            format!("node {node} has {what} {held} already; {offered} is of the past: ask again");
        Err(Problem::conflict(code, detail))
    };
    match offered.epoch.cmp(&held.epoch) {
        Less => return stale("stale-epoch", "epoch", offered.epoch, held.epoch),
        Greater => return Ok(Verdict::Newer),
        Equal => {}
    }
    match offered.generation.cmp(&held.generation) {
        Less => stale(
            "stale-generation",
            "generation",
            offered.generation,
            held.generation,
        ),
        Greater => Ok(Verdict::Newer),
        Equal if offered.digest == held.digest => Ok(Verdict::Same),
        Equal => Err(Problem::conflict(
            "digest-mismatch",
            format!(
                "node {node} has another spec under the same generation {}: two controllers write to it, or a store was copied",
                held.generation
            ),
        )),
    }
}

fn foreign(node: &str, held: &NodeSpecEnvelope, offered: &NodeSpecEnvelope) -> Problem {
    let systems: Vec<_> = held
        .spec
        .systems
        .iter()
        .map(|s| s.system.name.as_str())
        .collect();
    let runs = match systems.is_empty() {
        true => "nothing".to_owned(),
        false => systems.join(", "),
    };
    let stale = match offered.take_over {
        Some(_) => "its ledger is another than the one to be taken over: look again; ",
        None => "",
    };
    Problem::conflict(
        "foreign-cluster",
        format!(
            "node {node} belongs to cluster {}, which runs {runs} there; cluster {} may not change it: {stale}`rtsctl controller adopt {node}` takes the node over and keeps everything running, `rtsctl controller take-over {node}` replaces what runs there",
            held.cluster_uid, offered.cluster_uid
        ),
    )
}
