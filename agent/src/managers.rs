//! The live managers of the node: starting them, finding them, watching their end, and stopping them.

mod adopt;
mod end;
mod start;
mod stop;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, Weak};

use rts_manager_api::control::ManagerInventory;
use rts_plan::desired::{ManagerKey, SystemRef};
use rts_plan::observed::Usage;
use tokio::sync::watch;

use crate::agent::Agent;
use crate::events::{lock, of_manager};
use crate::machine::{Control, Family};
use crate::manager_link::{Link, OnChanged};

pub(crate) use adopt::{adopt_all, adopt_round, bury_orphans};
use end::{End, Undying};
pub(crate) use start::StartManagerError;
pub(crate) use stop::{Patience, StopError};

/// The registry.
#[derive(Debug, Default)]
pub(crate) struct Managers {
    live: Mutex<BTreeMap<ManagerKey, Arc<Manager>>>,
    /// One lock per manager that is being started.
    starting: Mutex<BTreeMap<ManagerKey, Arc<tokio::sync::Mutex<()>>>>,
    /// Run folders of dead managers, something of which does not die.
    undying: Mutex<BTreeMap<PathBuf, Undying>>,
    /// Held while run folders are looked at, made or removed.
    folders: tokio::sync::Mutex<()>,
}

/// One start of a manager.
#[derive(Debug)]
pub(crate) struct Manager {
    pub key: ManagerKey,
    pub incarnation: String,
    pub pid: u32,
    /// Its process and what that started.
    family: Box<dyn Family>,
    /// Wall-clock start, RFC 3339; set once it has said so.
    pub started: OnceLock<String>,
    pub folder: PathBuf,
    pub link: Link,
    /// What it held when it was asked last.
    pub seen: Mutex<Seen>,
    /// Set when its end is wanted.
    stopping: AtomicBool,
    end: watch::Sender<End>,
}

/// What was last seen of a manager.
#[derive(Debug)]
pub(crate) struct Seen {
    /// It answered in time.
    pub responsive: bool,
    /// It has answered once: its contents are what was seen then.
    pub answered: bool,
    /// Its contents.
    pub inventory: ManagerInventory,
    /// Incarnations that it said it has deleted, and that an answer from before may still hold.
    pub deleted: BTreeSet<String>,
    /// Components that it was asked to make.
    pub made: u64,
    /// How many of them it had been asked for when it was asked what it holds, and answered.
    pub told: u64,
    /// Instance name → incarnation of what it said it has made.
    pub incarnations: BTreeMap<String, String>,
    /// Connectors that it was asked to bind, and that its contents do not show yet.
    pub bound: BTreeSet<String>,
}

impl Seen {
    /// Of one that was asked nothing yet.
    fn new() -> Self {
        Self {
            responsive: true,
            answered: false,
            inventory: ManagerInventory {
                modules: Default::default(),
                opened: Default::default(),
                components: Vec::new(),
                taps: Vec::new(),
            },
            deleted: BTreeSet::new(),
            made: 0,
            told: 0,
            incarnations: BTreeMap::new(),
            bound: BTreeSet::new(),
        }
    }

    /// It said that it has deleted a component: what was seen before is not to bring it back.
    pub fn forget(&mut self, instance: &str) {
        self.incarnations.remove(instance);
        let found = self
            .inventory
            .components
            .iter()
            .position(|c| c.instance == instance);
        if let Some(at) = found {
            let component = self.inventory.components.remove(at);
            self.deleted.insert(component.incarnation);
        }
    }

    /// True while it may hold what is not in its contents: it has said nothing yet, or nothing since it was asked to make
    /// something.
    pub fn may_hold_more(&self) -> bool {
        !self.answered || self.told < self.made
    }

    /// True while it may have an in-port end of this connector.
    pub fn may_bind(&self, connector: &str) -> bool {
        !self.answered || self.bound.contains(connector) || self.shows(connector)
    }

    fn shows(&self, connector: &str) -> bool {
        let mut ends = self.inventory.components.iter().flat_map(|c| &c.bindings);
        ends.any(|end| end.connector == connector)
    }

    /// It answered, after it had been asked to make so many. Answers come in the order of the questions, so what one no
    /// longer holds comes in no later one.
    pub fn keep(&mut self, mut inventory: ManagerInventory, made: u64) {
        self.told = self.told.max(made);
        let still = |gone: &String| inventory.components.iter().any(|c| c.incarnation == *gone);
        self.deleted.retain(still);
        inventory
            .components
            .retain(|c| !self.deleted.contains(&c.incarnation));
        self.inventory = inventory;
        let mut bound = std::mem::take(&mut self.bound);
        bound.retain(|connector| !self.shows(connector));
        self.bound = bound;
        self.responsive = true;
        self.answered = true;
    }
}

impl Managers {
    /// All live managers, sorted by key.
    pub fn all(&self) -> Vec<Arc<Manager>> {
        lock(&self.live).values().cloned().collect()
    }

    /// A live manager.
    pub fn get(&self, key: &ManagerKey) -> Option<Arc<Manager>> {
        lock(&self.live)
            .get(key)
            .filter(|m| *m.end.borrow() != End::Over)
            .cloned()
    }

    /// Live managers of the same system.
    pub fn of_system(&self, system: Option<&SystemRef>) -> Vec<Arc<Manager>> {
        let mut all = self.all();
        all.retain(|m| m.key.system.as_ref() == system);
        all
    }

    /// True while a system, by its uid, has a live manager.
    pub fn has(&self, uid: &str) -> bool {
        let is_of = |key: &ManagerKey| key.system.as_ref().is_some_and(|s| s.uid == uid);
        lock(&self.live).keys().any(is_of)
    }

    fn remove(&self, manager: &Manager) {
        let mut live = lock(&self.live);
        if live
            .get(&manager.key)
            .is_some_and(|m| m.incarnation == manager.incarnation)
        {
            live.remove(&manager.key);
        }
    }
}

/// What names one start of a manager.
pub(crate) struct Identity {
    pub key: ManagerKey,
    pub incarnation: String,
    pub family: Box<dyn Family>,
    pub folder: PathBuf,
}

impl Manager {
    fn new(agent: &Arc<Agent>, identity: Identity, first: Option<Box<dyn Control>>) -> Arc<Self> {
        let Identity {
            key,
            incarnation,
            family,
            folder,
        } = identity;
        let link = Link::start(
            key.display_name(),
            incarnation.clone(),
            first,
            (agent.inputs.machine.clone(), folder.clone()),
            on_changed(Arc::downgrade(agent), key.clone()),
        );
        Arc::new(Self {
            link,
            seen: Mutex::new(Seen::new()),
            stopping: AtomicBool::new(false),
            end: watch::Sender::new(End::No),
            key,
            incarnation,
            pid: family.pid(),
            family,
            started: OnceLock::new(),
            folder,
        })
    }

    /// What its process uses of the machine.
    pub fn usage(&self) -> Option<Usage> {
        self.family.usage()
    }

    /// True when its end is wanted.
    pub fn is_stopping(&self) -> bool {
        self.stopping.load(Ordering::Relaxed)
    }
}

fn on_changed(agent: Weak<Agent>, key: ManagerKey) -> OnChanged {
    let manager = key.display_name();
    Arc::new(move |changed| {
        tracing::debug!(manager, target = changed.target, "{}", changed.message);
        if let Some(agent) = agent.upgrade() {
            if let Some(reason) = &changed.reason {
                let mut event = of_manager("Warning", reason, &key, changed.message);
                event.object = changed.target;
                agent.events.push(event);
            }
            agent.dirty.notify_one();
        }
    })
}

#[cfg(test)]
mod tests;
