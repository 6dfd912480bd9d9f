//! What really runs on the node: all managers are asked at once, and their answers merged.

mod acted;
mod difference;
#[cfg(test)]
mod fixtures;
mod hang;
mod merge;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rts_agent_api::session::AgentEvent;
use rts_host::timing::TARGET;
use rts_manager_api::control::{RequestBody, ResponseBody};
use rts_plan::observed::Inventory;
use tokio::time::{Instant, sleep, timeout};
use tracing::{Instrument, info_span};

use crate::agent::Agent;
use crate::events::lock;
use crate::managers::Manager;

pub(crate) use acted::Acted;
pub(crate) use difference::delta;
use difference::{differences, without_counters};
pub(crate) use hang::why_hanging;
use merge::{View, merge};
pub(crate) use merge::{port, system_ref};

/// How long a manager may take to answer before it counts as not responsive.
const ANSWER: Duration = Duration::from_secs(1);
/// The same for one that did not answer the last time, so that it does not hold up everybody again.
const ANSWER_SILENT: Duration = Duration::from_millis(250);

/// Longest time from the end of a process's connections to its own.
const DYING: Duration = Duration::from_millis(200);
/// Pause before another look at what is not well.
const AGAIN: Duration = Duration::from_millis(500);

/// What was seen last.
#[derive(Debug)]
struct Last {
    inventory: Arc<Inventory>,
    /// The same without counters.
    bare: Inventory,
}

/// Keeps the last inventory and its revision.
#[derive(Debug)]
pub(crate) struct Keeper {
    last: Mutex<Last>,
    /// Rounds that were begun; each has a number, from 1.
    begun: AtomicU64,
    /// Number of the last round that ended.
    ended: AtomicU64,
    /// Held while one runs: since when managers have not answered, by incarnation.
    one_at_a_time: tokio::sync::Mutex<BTreeMap<String, Instant>>,
    /// A round is about to come, to look again at what is not well.
    again: AtomicBool,
}

impl Keeper {
    /// An empty inventory.
    pub fn new(node: &str) -> Self {
        let empty = Inventory {
            node: node.to_owned(),
            ..Inventory::default()
        };
        Self {
            last: Mutex::new(Last {
                inventory: Arc::new(empty.clone()),
                bare: empty,
            }),
            begun: AtomicU64::new(0),
            ended: AtomicU64::new(0),
            one_at_a_time: Default::default(),
            again: AtomicBool::new(false),
        }
    }

    /// What was seen last.
    pub fn last(&self) -> Arc<Inventory> {
        lock(&self.last).inventory.clone()
    }

    /// Looks at what was seen last.
    pub fn look<T>(&self, at: impl FnOnce(&Inventory) -> T) -> T {
        at(&lock(&self.last).inventory)
    }

    /// Revision of what was seen last.
    pub fn revision(&self) -> u64 {
        lock(&self.last).inventory.revision
    }

    /// Keeps a new inventory; its revision is higher than the last when more than counters differ. Returns it, and the
    /// events that tell the difference.
    fn keep(&self, mut new: Inventory) -> (Arc<Inventory>, Vec<AgentEvent>) {
        let mut last = lock(&self.last);
        let before = last.inventory.clone();
        new.revision = before.revision;
        let bare = without_counters(&new);
        let changed = bare != last.bare;
        let events = if changed && before.revision > 0 {
            differences(&before, &new)
        } else {
            Vec::new()
        };
        // The first answer has revision 1, even when it is empty.
        if changed || before.revision == 0 {
            new.revision += 1;
        }
        let inventory = Arc::new(new);
        *last = Last {
            inventory: inventory.clone(),
            bare,
        };
        (inventory, events)
    }
}

impl Agent {
    /// Asks all managers, in a round that begins after this call. Callers that come while one runs share the next. A
    /// round goes on when its caller gives up, so that others may rely on it.
    pub async fn observe(self: &Arc<Self>) -> Arc<Inventory> {
        let agent = self.clone();
        let asked = self.inventory.begun.load(Ordering::SeqCst);
        let round = async move { agent.round_after(asked).await };
        let round = tokio::spawn(round.instrument(info_span!(target: TARGET, "look")));
        round.await.unwrap_or_else(|e| {
            tracing::error!("a round of questions failed: {e}");
            self.inventory.last()
        })
    }

    async fn round_after(self: &Arc<Self>, asked: u64) -> Arc<Inventory> {
        let mut silent = self.inventory.one_at_a_time.lock().await;
        if self.inventory.ended.load(Ordering::SeqCst) > asked {
            return self.inventory.last();
        }
        let number = self.inventory.begun.fetch_add(1, Ordering::SeqCst) + 1;
        let mut managers = self.managers.all();
        // Nothing is in them any more.
        managers.retain(|m| !m.is_stuck());
        let (asked, told) = (Instant::now(), self.components_told());
        let mut views = futures_util::future::join_all(managers.iter().map(|m| ask(m))).await;
        note_silence(&mut silent, &mut views, asked);
        if views.iter().any(is_unwell) {
            self.look_again();
        }
        let before = self.inventory.revision();
        let mut merged = merge(&self.config.node, views, &self.policies());
        self.components_seen(&merged, told);
        merged.held = self.restarts.held(&self.policies());
        let (inventory, events) = self.inventory.keep(merged);
        for event in events {
            self.events.push(event);
        }
        if inventory.revision != before {
            self.events.bell.notify_one();
        }
        self.forget_stale_marks(&inventory);
        self.inventory.ended.store(number, Ordering::SeqCst);
        inventory
    }

    /// Rings for another round soon: time alone changes what hangs.
    fn look_again(self: &Arc<Self>) {
        if self.inventory.again.swap(true, Ordering::SeqCst) {
            return;
        }
        let agent = self.clone();
        tokio::spawn(async move {
            sleep(AGAIN).await;
            agent.inventory.again.store(false, Ordering::SeqCst);
            agent.dirty.notify_one();
        });
    }
}

/// Remembers since when each manager has not answered, and tells it to their views.
fn note_silence(silent: &mut BTreeMap<String, Instant>, views: &mut [View], asked: Instant) {
    let mut now = BTreeMap::new();
    for view in views.iter_mut().filter(|v| !v.responsive) {
        let since = silent.get(&view.incarnation).copied().unwrap_or(asked);
        view.silent = Some(since.elapsed());
        now.insert(view.incarnation.clone(), since);
    }
    *silent = now;
}

/// True for a manager that may soon have to be replaced.
fn is_unwell(view: &View) -> bool {
    !view.responsive || view.inventory.components.iter().any(|c| c.busy.is_some())
}

/// True for a process that has ended, or is just ending: its connections are closed a moment before.
async fn dies(manager: &Manager, patience: Duration) -> bool {
    manager.has_died() || timeout(patience, manager.died()).await.is_ok() || manager.has_died()
}

async fn ask(manager: &Manager) -> View {
    let (answered, made) = {
        let seen = lock(&manager.seen);
        (seen.responsive, seen.made)
    };
    let limit = if answered { ANSWER } else { ANSWER_SILENT };
    let answer = manager
        .link
        .call_within(RequestBody::Inventory, limit, limit)
        .await;
    // One that was silent before may stay so for long, and is not waited for.
    let patience = if answered { DYING } else { Duration::ZERO };
    let dies = answer.is_err() && dies(manager, patience).await;
    let usage = manager.usage();
    let mut seen = lock(&manager.seen);
    match answer {
        Ok(ResponseBody::Inventory(inventory)) => seen.keep(inventory, made),
        // That it has died is told by its end alone.
        _ if dies => {}
        _ => seen.responsive = false,
    }
    View {
        key: manager.key.clone(),
        incarnation: manager.incarnation.clone(),
        pid: manager.pid,
        started: manager.started.get().cloned().unwrap_or_default(),
        responsive: seen.responsive,
        silent: None,
        unseen: !seen.responsive && seen.may_hold_more(),
        inventory: seen.inventory.clone(),
        usage,
    }
}
