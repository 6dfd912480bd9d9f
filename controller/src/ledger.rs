//! What an agent's ledger says against what is stored here: whose set a node runs, and which of the two is newer.
//!
//! Nothing is sent to a node before the two agree. [`settle`] brings them together where that can be done without a
//! word of the user; [`claim`] does what the user said of a ledger of another store.

pub mod claim;
mod import;
pub mod settle;

use std::collections::BTreeMap;

use rts_agent_api::messages::{LedgerFence, NodeSpecEnvelope};
use rts_plan::desired::NodeSpec;

use crate::core::{Core, Registry};
use crate::sessions::NodeEntry;

/// How an agent's ledger stands to the store.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Standing {
    /// The store may be sent.
    Agreed,
    /// It is another store's.
    Foreign(LedgerFence),
    /// It was written in a later epoch of this store: another controller took over.
    Stale(LedgerFence),
    /// The same, but this store was restored since: its epoch is to be raised.
    Overtaken(LedgerFence),
    /// It is newer than the store, which was restored or rolled back.
    Ahead(LedgerFence),
}

impl Standing {
    /// Of every node that greeted.
    pub fn all(core: &Core) -> BTreeMap<String, Self> {
        let nodes = core.sessions.all();
        let epoch = core.epoch();
        let registry = core.registry();
        let judge = |(node, entry): (String, NodeEntry)| {
            let standing = Self::of(&core.cluster_uid, epoch, &registry, &node, &entry);
            (node, standing)
        };
        nodes.into_iter().map(judge).collect()
    }

    /// Of one node.
    pub fn get(core: &Core, node: &str) -> Self {
        let entry = core.sessions.get(node);
        let epoch = core.epoch();
        entry.map_or(Self::Agreed, |entry| {
            Self::of(&core.cluster_uid, epoch, &core.registry(), node, &entry)
        })
    }

    fn of(cluster: &str, epoch: u64, registry: &Registry, node: &str, entry: &NodeEntry) -> Self {
        let Some(ledger) = &entry.session.ledger else {
            return Self::Agreed;
        };
        if ledger.cluster_uid != cluster {
            let claimed = entry.session.claim.as_ref() == Some(ledger);
            // A set of nothing is nobody's loss.
            return if claimed || ledger.digest == digest_of_nothing(node) {
                Self::Agreed
            } else {
                Self::Foreign(ledger.clone())
            };
        }
        let restored = registry.restored.as_ref();
        let restored = restored.filter(|restored| !restored.settled.contains(node));
        if ledger.epoch > epoch {
            return match restored {
                Some(_) => Self::Overtaken(ledger.clone()),
                None => Self::Stale(ledger.clone()),
            };
        }
        if restored.is_some_and(|restored| restored.take_over) {
            return Self::Agreed;
        }
        let known = registry.nodes.get(node).cloned().unwrap_or_default();
        let told = (ledger.epoch, ledger.generation);
        let given = (known.epoch, known.generation);
        if told > given || (told == given && ledger.digest != known.digest) {
            Self::Ahead(ledger.clone())
        } else {
            Self::Agreed
        }
    }

    /// One CamelCase word; none when all is well.
    pub fn reason(&self) -> Option<&'static str> {
        match self {
            Self::Agreed => None,
            Self::Foreign(_) => Some("ForeignLedger"),
            Self::Stale(_) => Some("StaleController"),
            Self::Overtaken(_) | Self::Ahead(_) => Some("LedgerAhead"),
        }
    }

    /// What is the matter and how to mend it; none when all is well.
    pub fn message(&self, core: &Core, node: &str) -> Option<String> {
        let (own, epoch) = (&core.cluster_uid, core.epoch());
        match self {
            Self::Agreed => None,
            Self::Foreign(ledger) => Some(format!(
                "node {node} belongs to another controller ({}), and this one ({own}) changes nothing there; \
                 `rtsctl controller adopt {node}` makes what runs there this controller's, without a restart; \
                 `rtsctl controller take-over {node}` puts this controller's set in its place",
                words(ledger)
            )),
            Self::Stale(ledger) => Some(format!(
                "a newer controller has taken over node {node} ({}), and this one has epoch {epoch}; end this one with \
                 `rtsctl down`, or make it the newest with `rtsctl controller restore` from a backup",
                words(ledger)
            )),
            Self::Overtaken(ledger) | Self::Ahead(ledger) => Some(format!(
                "node {node} was told newer things ({}) than this restored store knows; they are being taken in",
                words(ledger)
            )),
        }
    }

    /// The ledger that the store does not agree with.
    pub fn ledger(&self) -> Option<&LedgerFence> {
        match self {
            Self::Agreed => None,
            Self::Foreign(ledger)
            | Self::Stale(ledger)
            | Self::Overtaken(ledger)
            | Self::Ahead(ledger) => Some(ledger),
        }
    }
}

/// The fence of an envelope.
pub fn fence(envelope: &NodeSpecEnvelope) -> LedgerFence {
    LedgerFence {
        cluster_uid: envelope.cluster_uid.clone(),
        epoch: envelope.epoch,
        generation: envelope.generation,
        digest: envelope.digest.clone(),
    }
}

fn words(ledger: &LedgerFence) -> String {
    let LedgerFence {
        cluster_uid,
        epoch,
        generation,
        ..
    } = ledger;
    format!("cluster {cluster_uid}, epoch {epoch}, generation {generation}")
}

fn digest_of_nothing(node: &str) -> String {
    rts_plan::digest(&NodeSpec {
        node: node.to_owned(),
        systems: Vec::new(),
    })
}
