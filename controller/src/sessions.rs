//! Greetings and heartbeats of agents. The newest session of a node wins; silence makes the node unknown.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use jiff::Timestamp;
use rts_agent_api::PROTOCOL_VERSION;
use rts_agent_api::session::{SessionGreeting, UNKNOWN_AFTER};
use rts_controller_api::Problem;
use rts_plan::observed::Inventory;
use tokio::sync::watch;
use tokio::time::Instant;

use crate::fleet::Agent;

/// Sessions that were replaced and are still refused, per node.
const SUPERSEDED: usize = 16;
/// Failures to answer within this time are one failure.
const ONCE: Duration = Duration::from_secs(2);
/// Nodes that may greet.
const MAX_NODES: usize = 1000;

/// All nodes that ever greeted this controller.
pub struct Sessions {
    nodes: Mutex<BTreeMap<String, NodeEntry>>,
    changed: watch::Sender<u64>,
}

/// What is known of a node.
#[derive(Clone)]
pub struct NodeEntry {
    /// Identity of the node object.
    pub uid: String,
    /// When it first greeted.
    pub created: Timestamp,
    /// Its agent.
    pub session: Session,
    /// No heartbeat came in time.
    pub lost: bool,
    /// Why the agent did not answer the last two times it was asked, though its heartbeats come.
    pub silent: Option<String>,
    /// Times in a row that it was asked and did not answer.
    failures: u32,
    /// When the last of them was counted.
    failed: Option<Instant>,
    /// What was last seen there.
    pub inventory: Inventory,
    superseded: VecDeque<String>,
}

/// A session of an agent.
#[derive(Clone)]
pub struct Session {
    /// Its id.
    pub id: String,
    /// Program version of the agent.
    pub version: String,
    /// Its socket.
    pub endpoint: String,
    /// Names by which hosts in profiles may mean the node.
    pub aliases: Vec<String>,
    /// Generation in the agent's ledger when it greeted.
    pub applied: Option<u64>,
    /// The agent.
    pub agent: Arc<dyn Agent>,
    /// Last sign of life, wall clock; for display.
    pub seen: Timestamp,
    alive: Instant,
    revision: u64,
}

/// What a heartbeat brought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beat {
    /// The inventory has another revision.
    pub inventory_changed: bool,
    /// The node was unknown until now.
    pub back: bool,
}

impl NodeEntry {
    /// True when it did not answer once: too little to call it unknown.
    pub fn unsure(&self) -> bool {
        !self.lost && self.failures == 1
    }

    /// `Ready`, `NotReady` or `Unknown`.
    pub fn state(&self) -> &'static str {
        match (self.lost, &self.silent) {
            (true, _) => "Unknown",
            (false, Some(_)) => "NotReady",
            (false, None) => "Ready",
        }
    }
}

impl Default for Sessions {
    fn default() -> Self {
        Self {
            nodes: Mutex::default(),
            changed: watch::Sender::new(0),
        }
    }
}

impl Sessions {
    /// Takes a greeting. True when it is a new session.
    pub fn greet(
        &self,
        node: &str,
        greeting: SessionGreeting,
        agent: Arc<dyn Agent>,
        uid: String,
        now: Timestamp,
    ) -> Result<bool, Problem> {
        if greeting.protocol_version != PROTOCOL_VERSION {
            let side = if greeting.protocol_version > PROTOCOL_VERSION {
                "rts-controller"
            } else {
                "rts-agent"
            };
            return Err(Problem::conflict(
                "protocol-version",
                format!(
                    "the agent of node {node} speaks protocol {}, this controller {PROTOCOL_VERSION}: upgrade {side}",
                    greeting.protocol_version
                ),
            ));
        }
        let mut nodes = self.nodes();
        if nodes.len() >= MAX_NODES && !nodes.contains_key(node) {
            let detail = format!("{MAX_NODES} nodes have greeted already");
            return Err(Problem::unavailable("too-many-nodes", detail));
        }
        let session = Session {
            id: greeting.session,
            version: greeting.version,
            endpoint: greeting.endpoint,
            aliases: greeting.aliases,
            applied: greeting.ledger.map(|ledger| ledger.generation),
            agent,
            seen: now,
            alive: Instant::now(),
            revision: greeting.inventory.revision,
        };
        let fresh = match nodes.get_mut(node) {
            None => {
                let entry = NodeEntry {
                    uid,
                    created: now,
                    session,
                    lost: false,
                    silent: None,
                    failures: 0,
                    failed: None,
                    inventory: greeting.inventory,
                    superseded: VecDeque::new(),
                };
                nodes.insert(node.to_owned(), entry);
                true
            }
            Some(entry) => entry.take_over(node, session, greeting.inventory)?,
        };
        drop(nodes);
        self.tell();
        Ok(fresh)
    }

    /// Takes a heartbeat.
    pub fn beat(
        &self,
        node: &str,
        session: &str,
        revision: u64,
        now: Timestamp,
    ) -> Result<Beat, Problem> {
        let mut nodes = self.nodes();
        let entry = nodes.get_mut(node).ok_or_else(|| unknown(node, session))?;
        if entry.session.id != session {
            return Err(if entry.superseded.iter().any(|s| s == session) {
                superseded(node, session)
            } else {
                unknown(node, session)
            });
        }
        entry.session.alive = Instant::now();
        entry.session.seen = now;
        let beat = Beat {
            inventory_changed: std::mem::replace(&mut entry.session.revision, revision) != revision,
            back: std::mem::take(&mut entry.lost),
        };
        drop(nodes);
        if beat.back {
            self.tell();
        }
        Ok(beat)
    }

    /// Marks nodes whose heartbeats stopped and names them; and when to look again.
    pub fn expire(&self) -> (Vec<String>, Option<Instant>) {
        let now = Instant::now();
        let mut lost = Vec::new();
        let mut next = None;
        for (name, entry) in self.nodes().iter_mut().filter(|(_, entry)| !entry.lost) {
            let end = entry.session.alive + UNKNOWN_AFTER;
            if end <= now {
                entry.lost = true;
                lost.push(name.clone());
            } else {
                next = Some(next.map_or(end, |n: Instant| n.min(end)));
            }
        }
        if !lost.is_empty() {
            self.tell();
        }
        (lost, next)
    }

    /// Keeps what an observation found.
    pub fn observed(&self, node: &str, answer: Result<&Inventory, &str>) {
        if let Some(entry) = self.nodes().get_mut(node) {
            match answer {
                Ok(inventory) => {
                    entry.inventory = inventory.clone();
                    entry.silent = None;
                    entry.failures = 0;
                }
                Err(reason) => {
                    // Questions that were open at the same time count once.
                    let now = Instant::now();
                    let counted = entry.failed.replace(now).filter(|_| entry.failures > 0);
                    if counted.is_some_and(|at| now.duration_since(at) < ONCE) {
                        entry.failed = counted;
                    } else {
                        entry.failures = entry.failures.saturating_add(1);
                    }
                    entry.silent = (entry.failures > 1).then(|| reason.to_owned());
                }
            }
        }
    }

    /// All nodes.
    pub fn all(&self) -> BTreeMap<String, NodeEntry> {
        self.nodes().clone()
    }

    /// One node.
    pub fn get(&self, node: &str) -> Option<NodeEntry> {
        self.nodes().get(node).cloned()
    }

    /// Waits until a session is no longer the live one of its node.
    pub async fn ended(&self, node: &str, session: &str) {
        let mut changed = self.changed.subscribe();
        loop {
            let live = self
                .nodes()
                .get(node)
                .is_some_and(|entry| entry.session.id == session && !entry.lost);
            if !live || changed.changed().await.is_err() {
                return;
            }
        }
    }

    /// Wakes whenever a session or a node's life changes.
    pub fn subscribe(&self) -> watch::Receiver<u64> {
        self.changed.subscribe()
    }

    fn tell(&self) {
        self.changed.send_modify(|n| *n = n.wrapping_add(1));
    }

    fn nodes(&self) -> MutexGuard<'_, BTreeMap<String, NodeEntry>> {
        self.nodes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl NodeEntry {
    fn take_over(
        &mut self,
        node: &str,
        session: Session,
        inventory: Inventory,
    ) -> Result<bool, Problem> {
        if self.superseded.contains(&session.id) {
            return Err(superseded(node, &session.id));
        }
        let fresh = self.session.id != session.id;
        let old = std::mem::replace(&mut self.session, session);
        if fresh {
            self.superseded.push_back(old.id);
            if self.superseded.len() > SUPERSEDED {
                self.superseded.pop_front();
            }
        }
        self.lost = false;
        self.silent = None;
        self.failures = 0;
        self.inventory = inventory;
        Ok(fresh)
    }
}

fn unknown(node: &str, session: &str) -> Problem {
    Problem::not_found(format!(
        "node {node} has no session {session} here: greet again"
    ))
}

fn superseded(node: &str, session: &str) -> Problem {
    Problem::conflict(
        "superseded",
        format!("a newer session of node {node} has taken over from session {session}"),
    )
}

#[cfg(test)]
mod tests;
