//! Greetings and heartbeats of agents. The newest session of a node wins; silence makes the node unknown.

mod entry;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use jiff::Timestamp;
use rts_agent_api::PROTOCOL_VERSION;
use rts_agent_api::messages::LedgerFence;
use rts_agent_api::session::{Heartbeat, SessionGreeting, Transport, UNKNOWN_AFTER};
use rts_controller_api::Problem;
use rts_plan::observed::Inventory;
use tokio::sync::watch;
use tokio::time::Instant;

pub use self::entry::{NodeEntry, Question, Session};
use crate::fleet::Agent;

/// Nodes that may greet: each takes a connection each way.
const MAX_NODES: usize = 10_000;

/// All nodes that ever greeted this controller.
pub struct Sessions {
    nodes: Mutex<BTreeMap<String, NodeEntry>>,
    changed: watch::Sender<u64>,
}

/// What a heartbeat brought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beat {
    /// The inventory has another revision.
    pub inventory_changed: bool,
    /// The node was unknown until now.
    pub back: bool,
}

/// The session of a node ended while something was asked of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lost;

impl Default for Sessions {
    fn default() -> Self {
        Self {
            nodes: Mutex::default(),
            changed: watch::Sender::new(0),
        }
    }
}

impl Sessions {
    /// Takes a greeting. True when it is a new session, or the node was unknown until now.
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
        let session = Session::begin(&greeting, agent, now);
        let fresh = match nodes.get_mut(node) {
            None => {
                let entry = NodeEntry::new(uid, session, greeting.inventory.into());
                nodes.insert(node.to_owned(), entry);
                true
            }
            Some(entry) => {
                let fresh = entry.take_over(node, session, greeting.inventory.into())?;
                entry.tell_life();
                fresh
            }
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
        heartbeat: &mut Heartbeat,
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
        let beat = Beat {
            inventory_changed: entry.beat(heartbeat, now),
            back: std::mem::take(&mut entry.lost),
        };
        entry.tell_life();
        drop(nodes);
        if beat.back {
            self.tell();
        }
        Ok(beat)
    }

    /// Marks nodes whose heartbeats stopped and names them; and when to look again. So long nobody could be heard: that is
    /// nobody's silence.
    pub fn expire(&self, deaf: Duration) -> (Vec<String>, Option<Instant>) {
        let now = Instant::now();
        let mut lost = Vec::new();
        let mut next = None;
        for (name, entry) in self.nodes().iter_mut().filter(|(_, entry)| !entry.lost) {
            entry.session.alive = (entry.session.alive + deaf).min(now);
            let end = entry.session.alive + UNKNOWN_AFTER;
            if end <= now {
                entry.lost = true;
                entry.tell_life();
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

    /// Keeps what a question found.
    pub fn observed(
        &self,
        node: &str,
        question: &Question,
        answer: Result<&mut Arc<Inventory>, &str>,
    ) {
        if let Some(entry) = self.nodes().get_mut(node) {
            match answer {
                Ok(inventory) => entry.answered(question, inventory),
                Err(reason) => entry.unanswered(reason),
            }
        }
    }

    /// Something was done on a node: what was told of it before is of yesterday.
    pub fn doubt(&self, node: &str) {
        if let Some(entry) = self.nodes().get_mut(node) {
            entry.doubt();
        }
    }

    /// A session's agent has stored a spec.
    pub fn stored(&self, node: &str, session: &str, ledger: LedgerFence) {
        if let Some(entry) = self.nodes().get_mut(node)
            && entry.session.id == session
        {
            entry.session.ledger = Some(ledger);
            entry.session.claim = None;
        }
        self.tell();
    }

    /// Somebody said that what a session's ledger holds may be replaced.
    pub fn claim(&self, node: &str, session: &str, ledger: LedgerFence) {
        if let Some(entry) = self.nodes().get_mut(node)
            && entry.session.id == session
        {
            entry.session.claim = Some(ledger);
        }
        self.tell();
    }

    /// What was said of a session's ledger no longer holds.
    pub fn unclaim(&self, node: &str, session: &str) {
        if let Some(entry) = self.nodes().get_mut(node)
            && entry.session.id == session
        {
            entry.session.claim = None;
        }
        self.tell();
    }

    /// Waits for something that a session's agent does, but no longer than the session lives.
    pub async fn while_live<T>(
        &self,
        node: &str,
        session: &str,
        work: impl Future<Output = T>,
    ) -> Result<T, Lost> {
        tokio::select! {
            biased;
            done = work => Ok(done),
            () = self.ended(node, session) => Err(Lost),
        }
    }

    /// All nodes.
    pub fn all(&self) -> BTreeMap<String, NodeEntry> {
        self.nodes().clone()
    }

    /// True when some node did not answer once.
    pub fn any_unsure(&self) -> bool {
        self.nodes().values().any(NodeEntry::unsure)
    }

    /// True when some node was there a moment ago and is not now.
    pub fn any_may_be_back(&self) -> bool {
        self.nodes().values().any(NodeEntry::may_be_back)
    }

    /// Nodes that are reached by a session of their own, and how.
    pub fn transports(&self) -> BTreeMap<String, Transport> {
        let nodes = self.nodes();
        let reached = nodes.iter().filter_map(|(name, entry)| {
            let transport = entry.session.transport.clone()?;
            Some((name.clone(), transport))
        });
        reached.collect()
    }

    /// Nodes, and the hosts that mean them.
    pub fn aliases(&self) -> BTreeMap<String, Vec<String>> {
        let nodes = self.nodes();
        let named = nodes.iter();
        named
            .map(|(name, entry)| (name.clone(), entry.session.aliases.clone()))
            .collect()
    }

    /// A node is no longer one.
    pub fn forget(&self, node: &str) {
        if let Some(mut entry) = self.nodes().remove(node) {
            entry.lost = true;
            entry.tell_life();
        }
        self.tell();
    }

    /// One node.
    pub fn get(&self, node: &str) -> Option<NodeEntry> {
        self.nodes().get(node).cloned()
    }

    /// Waits until a session is no longer the live one of its node.
    pub async fn ended(&self, node: &str, session: &str) {
        // Of this node alone: a thousand that wait must not wake for each other.
        let life = self.nodes().get(node).map(NodeEntry::life);
        if let Some(mut life) = life {
            let _ = life.wait_for(|now| now.as_deref() != Some(session)).await;
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
