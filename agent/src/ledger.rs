//! The ledger: the last NodeSpec that was accepted, durable, and the fence that refuses the past.

use std::io;
use std::path::PathBuf;

use rts_agent_api::messages::{NodeSpecEnvelope, NodeSpecReceipt};
use rts_http::problem::Problem;
use rts_plan::place::digest;

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
    fn load(&self) -> Result<Option<NodeSpecEnvelope>, LedgerError>;
    /// Replaces the contents. Durable when it returns.
    fn save(&self, envelope: &NodeSpecEnvelope) -> io::Result<()>;
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
    fn load(&self) -> Result<Option<NodeSpecEnvelope>, LedgerError> {
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
        let envelope: NodeSpecEnvelope =
            serde_json::from_slice(&bytes).map_err(|e| damaged(e.to_string()))?;
        if digest(&envelope.spec) != envelope.digest {
            return Err(damaged("its digest does not fit its contents".to_owned()));
        }
        Ok(Some(envelope))
    }

    fn save(&self, envelope: &NodeSpecEnvelope) -> io::Result<()> {
        rts_host::files::replace_durably(&self.path, &serde_json::to_vec_pretty(envelope)?)
    }
}

/// What a write means for the ledger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// It is what the ledger holds already.
    Same,
    /// It replaces what the ledger holds.
    Newer,
}

/// Decides on a write. `node` is this node's name, `held` what the ledger holds.
pub(crate) fn judge(
    node: &str,
    held: Option<&NodeSpecEnvelope>,
    offered: &NodeSpecEnvelope,
) -> Result<Verdict, Problem> {
    if digest(&offered.spec) != offered.digest {
        return Err(Problem::invalid(
            "digest-mismatch",
            "the digest does not fit the node spec: it was changed on its way, or the controller has another version",
        ));
    }
    if offered.spec.node != node {
        return Err(Problem::invalid(
            "wrong-node",
            format!("this is node {node}; the spec is for {}", offered.spec.node),
        ));
    }
    let Some(held) = held else {
        return Ok(Verdict::Newer);
    };
    if held.cluster_uid != offered.cluster_uid {
        return if held.spec.systems.is_empty() {
            Ok(Verdict::Newer)
        } else {
            Err(foreign(node, held, offered))
        };
    }
    fence(node, held, offered)
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
    Problem::conflict(
        "foreign-cluster",
        format!(
            "node {node} belongs to cluster {} and runs {}; cluster {} may not change it",
            held.cluster_uid,
            systems.join(", "),
            offered.cluster_uid
        ),
    )
}

/// The ledger of a running agent.
pub(crate) struct Ledger {
    node: String,
    store: std::sync::Arc<dyn Store>,
    held: Option<NodeSpecEnvelope>,
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
        self.held.as_ref()
    }

    /// Accepts or refuses a write; durable when it returns.
    pub async fn put(&mut self, offered: NodeSpecEnvelope) -> Result<NodeSpecReceipt, Problem> {
        let verdict = judge(&self.node, self.held.as_ref(), &offered)?;
        let generation = offered.generation;
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

#[cfg(test)]
mod tests {
    use super::*;
    use rts_plan::desired::{NodeSpec, NodeSystem, SystemRef};
    use std::sync::Arc;

    fn envelope(cluster: &str, epoch: u64, generation: u64, systems: &[&str]) -> NodeSpecEnvelope {
        let spec = NodeSpec {
            node: "local".to_owned(),
            systems: systems
                .iter()
                .map(|name| NodeSystem {
                    system: SystemRef {
                        name: (*name).to_owned(),
                        uid: format!("uid-{name}"),
                    },
                    components: Vec::new(),
                    connectors: Vec::new(),
                    orders: Default::default(),
                })
                .collect(),
        };
        NodeSpecEnvelope {
            cluster_uid: cluster.to_owned(),
            epoch,
            generation,
            digest: digest(&spec),
            spec,
        }
    }

    fn code(held: &NodeSpecEnvelope, offered: &NodeSpecEnvelope) -> (u16, String) {
        let problem = judge("local", Some(held), offered).unwrap_err();
        (problem.status, problem.code)
    }

    #[test]
    fn the_past_and_strangers_are_refused_each_with_its_own_code() {
        let held = envelope("a", 2, 7, &["hello"]);
        let refused = |offered: NodeSpecEnvelope| code(&held, &offered);
        assert_eq!(
            refused(envelope("a", 1, 9, &[])),
            (409, "stale-epoch".into())
        );
        assert_eq!(
            refused(envelope("a", 2, 6, &[])),
            (409, "stale-generation".into())
        );
        assert_eq!(
            refused(envelope("a", 2, 7, &[])),
            (409, "digest-mismatch".into())
        );
        assert_eq!(
            refused(envelope("b", 9, 9, &["hello"])),
            (409, "foreign-cluster".into())
        );
        assert_eq!(
            refused(envelope("b", 9, 9, &[])),
            (409, "foreign-cluster".into())
        );
    }

    #[test]
    fn what_is_newer_or_the_same_is_accepted() {
        let held = envelope("a", 2, 7, &["hello"]);
        let judged = |offered| judge("local", Some(&held), &offered).unwrap();
        assert_eq!(judged(envelope("a", 2, 7, &["hello"])), Verdict::Same);
        assert_eq!(judged(envelope("a", 2, 8, &["hello"])), Verdict::Newer);
        assert_eq!(judged(envelope("a", 3, 1, &[])), Verdict::Newer);
        let empty = envelope("a", 2, 7, &[]);
        let stranger = envelope("b", 1, 1, &["x"]);
        assert_eq!(
            judge("local", Some(&empty), &stranger).unwrap(),
            Verdict::Newer
        );
        assert_eq!(judge("local", None, &stranger).unwrap(), Verdict::Newer);
    }

    #[test]
    fn a_wrong_digest_or_node_is_invalid() {
        let mut offered = envelope("a", 1, 1, &["hello"]);
        assert_eq!(
            judge("other", None, &offered).unwrap_err().code,
            "wrong-node"
        );
        offered.digest.replace_range(..1, "x");
        let problem = judge("local", None, &offered).unwrap_err();
        assert_eq!(
            (problem.status, problem.code.as_str()),
            (422, "digest-mismatch")
        );
    }

    #[tokio::test]
    async fn what_was_accepted_survives_a_restart_and_damage_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let store = Arc::new(FileStore::new(folder.path()));
        let mut ledger = Ledger::load("local", store.clone()).unwrap();
        assert!(ledger.held().is_none());
        let first = envelope("a", 1, 1, &["hello"]);
        assert!(ledger.put(first.clone()).await.unwrap().changed);
        assert!(!ledger.put(first.clone()).await.unwrap().changed);
        assert!(ledger.put(envelope("a", 1, 0, &[])).await.is_err());

        let again = Ledger::load("local", store.clone()).unwrap();
        assert_eq!(again.held(), Some(&first));

        let path = folder.path().join(FILE);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace("uid-hello", "uid-other")).unwrap();
        let error = Ledger::load("local", store.clone()).err().unwrap();
        assert!(error.to_string().contains("digest"), "{error}");
        std::fs::write(&path, &text[..20]).unwrap();
        assert!(Ledger::load("local", store).is_err());
    }
}
