//! What is known of one node: its session, and its inventory as far as it was told.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use rts_agent_api::messages::LedgerFence;
use rts_agent_api::session::{Heartbeat, SessionGreeting, Transport};
use rts_controller_api::Problem;
use rts_plan::observed::Inventory;
use tokio::sync::watch;
use tokio::time::Instant;

use super::superseded;
use crate::fault::PATIENCE;
use crate::fleet::Agent;

/// Sessions that were replaced and are still refused, per node.
const SUPERSEDED: usize = 16;
/// Failures to answer within this time are one failure.
const ONCE: Duration = Duration::from_secs(2);

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
    pub(super) failures: u32,
    /// When the last of them was counted.
    failed: Option<Instant>,
    /// When the first of them was.
    unanswered: Option<Instant>,
    /// What was last seen there: the last full answer, and what heartbeats have told since.
    pub inventory: Arc<Inventory>,
    /// When all of it was told last; none when it cannot be relied on.
    told: Option<Instant>,
    /// Raised by everything after which what was asked before is of yesterday.
    doubts: u64,
    pub(super) superseded: VecDeque<String>,
    /// Id of the session that lives; none once it is lost.
    life: Arc<watch::Sender<Option<String>>>,
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
    /// How it is reached, where it is not of this machine.
    pub transport: Option<Transport>,
    /// What the agent's ledger holds: as it greeted, or as it has acknowledged since.
    pub ledger: Option<LedgerFence>,
    /// The ledger of another store that somebody said may be replaced.
    pub claim: Option<LedgerFence>,
    /// The agent.
    pub agent: Arc<dyn Agent>,
    /// Last sign of life, wall clock; for display.
    pub seen: Timestamp,
    pub(super) alive: Instant,
    /// Of the newest heartbeat.
    revision: u64,
}

/// A question to an agent: which session was asked, and what was known to be of yesterday then.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Question {
    session: String,
    doubts: u64,
}

impl Session {
    /// The session that a greeting begins.
    pub fn begin(greeting: &SessionGreeting, agent: Arc<dyn Agent>, now: Timestamp) -> Self {
        Self {
            id: greeting.session.clone(),
            version: greeting.version.clone(),
            endpoint: greeting.endpoint.clone(),
            aliases: greeting.aliases.clone(),
            transport: greeting.transport.clone(),
            ledger: greeting.ledger.clone(),
            claim: None,
            agent,
            seen: now,
            alive: Instant::now(),
            revision: greeting.inventory.revision,
        }
    }
}

impl NodeEntry {
    /// True when it did not answer once: too little to call it unknown.
    pub fn unsure(&self) -> bool {
        !self.lost && self.failures == 1
    }

    /// True for one that was there a moment ago, and is lost or silent now.
    pub fn may_be_back(&self) -> bool {
        let since = match (self.lost, &self.silent) {
            (true, _) => Some(self.session.alive),
            (false, Some(_)) => self.unanswered,
            (false, None) => None,
        };
        !self.sleeps() && since.is_some_and(|since| since.elapsed() < PATIENCE)
    }

    /// Nobody reaches it just now, which is how it should be between two commands.
    pub fn sleeps(&self) -> bool {
        self.lost && self.session.transport.is_some()
    }

    /// `Ready`, `NotReady`, `Unknown`, or `OnDemand` for one that is reached when a command needs it.
    pub fn state(&self) -> &'static str {
        match (self.lost, &self.silent) {
            (true, _) if self.sleeps() => "OnDemand",
            (true, _) => "Unknown",
            (false, Some(_)) => "NotReady",
            (false, None) => "Ready",
        }
    }

    /// A node that greets for the first time.
    pub(super) fn new(uid: String, session: Session, inventory: Arc<Inventory>) -> Self {
        Self {
            uid,
            created: session.seen,
            life: Arc::new(watch::Sender::new(Some(session.id.clone()))),
            session,
            lost: false,
            silent: None,
            failures: 0,
            failed: None,
            unanswered: None,
            inventory,
            told: Some(Instant::now()),
            doubts: 0,
            superseded: VecDeque::new(),
        }
    }

    /// Takes another session's greeting, or the same one's once more. True when it is another, or was given up.
    pub(super) fn take_over(
        &mut self,
        node: &str,
        session: Session,
        inventory: Arc<Inventory>,
    ) -> Result<bool, Problem> {
        if self.superseded.contains(&session.id) {
            return Err(superseded(node, &session.id));
        }
        if self.session.id == session.id {
            let lost = self.lost;
            self.greeted_again(session, inventory);
            return Ok(lost);
        }
        let old = std::mem::replace(&mut self.session, session);
        self.superseded.push_back(old.id);
        if self.superseded.len() > SUPERSEDED {
            self.superseded.pop_front();
        }
        self.lost = false;
        self.silent = None;
        self.failures = 0;
        self.inventory = inventory;
        self.told = Some(Instant::now());
        self.doubts += 1;
        Ok(true)
    }

    /// The live session greets once more. What was done since it said so may have overtaken it on its way: all is asked
    /// for again, and one that is older than what is known changes nothing. Its ledger counts only where it is newer.
    fn greeted_again(&mut self, mut session: Session, inventory: Arc<Inventory>) {
        if let Some(known) = &self.session.ledger
            && !session
                .ledger
                .as_ref()
                .is_some_and(|told| is_newer(told, known))
        {
            session.ledger = self.session.ledger.clone();
            session.claim = self.session.claim.clone();
        }
        if inventory.revision >= self.inventory.revision {
            session.revision = self.session.revision.max(session.revision);
            self.session = session;
            self.inventory = inventory;
        } else {
            self.session.alive = session.alive;
            self.session.seen = session.seen;
            self.session.ledger = session.ledger;
            self.session.claim = session.claim;
        }
        self.lost = false;
        self.silent = None;
        self.failures = 0;
        self.doubt();
    }

    /// Takes a heartbeat of its session. True when the inventory has another revision.
    pub(super) fn beat(&mut self, heartbeat: &mut Heartbeat, now: Timestamp) -> bool {
        self.session.alive = Instant::now();
        self.session.seen = now;
        let revision = heartbeat.inventory_revision;
        if let Some(delta) = heartbeat.delta.take()
            && delta.to <= revision
        {
            // One that does not fit leaves the copy as it is: then its revision tells that all must be asked for.
            Arc::make_mut(&mut self.inventory).advance(delta);
        }
        // One that was overtaken on its way lowers nothing.
        let newest = self.session.revision.max(revision);
        std::mem::replace(&mut self.session.revision, newest) != newest
    }

    /// The inventory, when heartbeats have kept it up to date and all of it was told within `age`.
    pub fn current(&self, age: Duration) -> Option<&Arc<Inventory>> {
        let fits = self.inventory.revision == self.session.revision;
        let young = self.told.is_some_and(|told| told.elapsed() < age);
        (fits && young && self.silent.is_none() && self.failures == 0).then_some(&self.inventory)
    }

    /// Tells those who wait for the end of its session how it stands: after whatever may change that.
    pub(super) fn tell_life(&self) {
        let now = (!self.lost).then_some(self.session.id.as_str());
        self.life.send_if_modified(|then| {
            let differs = then.as_deref() != now;
            if differs {
                *then = now.map(str::to_owned);
            }
            differs
        });
    }

    /// Tells the session that lives, and when another does, or none.
    pub(super) fn life(&self) -> watch::Receiver<Option<String>> {
        self.life.subscribe()
    }

    /// What is known is of yesterday: the node must be asked.
    pub(super) fn doubt(&mut self) {
        self.told = None;
        self.doubts += 1;
    }

    /// What a question that begins now must remember.
    pub fn question(&self) -> Question {
        Question {
            session: self.session.id.clone(),
            doubts: self.doubts,
        }
    }

    /// Takes an answer. What a former session said, or what was said before a newer heartbeat, changes nothing. One that
    /// says what is known becomes the very same object: what was made of that need not be made anew.
    pub(super) fn answered(&mut self, question: &Question, inventory: &mut Arc<Inventory>) {
        if question.session != self.session.id {
            return;
        }
        self.silent = None;
        self.failures = 0;
        if inventory.revision < self.inventory.revision {
            return;
        }
        if self.inventory == *inventory {
            *inventory = Arc::clone(&self.inventory);
        } else {
            self.inventory = Arc::clone(inventory);
        }
        self.session.revision = self.session.revision.max(inventory.revision);
        if question.doubts == self.doubts {
            self.told = Some(Instant::now());
        }
    }

    /// It did not answer. Questions that were open at the same time count once.
    pub(super) fn unanswered(&mut self, reason: &str) {
        let now = Instant::now();
        let counted = self.failed.replace(now).filter(|_| self.failures > 0);
        if self.failures == 0 {
            self.unanswered = Some(now);
        }
        if counted.is_some_and(|at| now.duration_since(at) < ONCE) {
            self.failed = counted;
        } else {
            self.failures = self.failures.saturating_add(1);
        }
        self.silent = (self.failures > 1).then(|| reason.to_owned());
    }
}

fn is_newer(told: &LedgerFence, known: &LedgerFence) -> bool {
    told.cluster_uid == known.cluster_uid
        && (told.epoch, told.generation) > (known.epoch, known.generation)
}
