//! What really runs on the node: all managers are asked at once, and their answers merged.

mod merge;

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use rts_agent_api::session::AgentEvent;
use rts_manager_api::control::{RequestBody, ResponseBody};
use rts_plan::observed::{ConnectorState, Inventory, LifeCycleState};

use crate::agent::Agent;
use crate::events::{lock, of_manager};
use crate::managers::Manager;

pub(crate) use merge::system_ref;
use merge::{View, merge};

/// How long a manager may take to answer before it counts as not responsive.
const ANSWER: Duration = Duration::from_secs(1);
/// The same for one that did not answer the last time, so that it does not hold up everybody again.
const ANSWER_SILENT: Duration = Duration::from_millis(250);

/// Keeps the last inventory and its revision.
#[derive(Debug)]
pub(crate) struct Keeper {
    last: Mutex<Inventory>,
    /// Rounds that were begun.
    rounds: AtomicU64,
    one_at_a_time: tokio::sync::Mutex<()>,
}

impl Keeper {
    /// An empty inventory.
    pub fn new(node: &str) -> Self {
        Self {
            last: Mutex::new(Inventory {
                node: node.to_owned(),
                ..Inventory::default()
            }),
            rounds: AtomicU64::new(0),
            one_at_a_time: tokio::sync::Mutex::new(()),
        }
    }

    /// What was seen last.
    pub fn last(&self) -> Inventory {
        lock(&self.last).clone()
    }

    /// Revision of what was seen last.
    pub fn revision(&self) -> u64 {
        lock(&self.last).revision
    }

    /// Keeps a new inventory; its revision is higher than the last when more than counters differ. Returns it, and the
    /// events that tell the difference.
    fn keep(&self, mut new: Inventory) -> (Inventory, Vec<AgentEvent>) {
        let mut last = lock(&self.last);
        new.revision = last.revision;
        let changed = without_counters(&new) != without_counters(&last);
        let events = if changed && last.revision > 0 {
            differences(&last, &new)
        } else {
            Vec::new()
        };
        // The first answer has revision 1, even when it is empty.
        if changed || last.revision == 0 {
            new.revision += 1;
        }
        *last = new.clone();
        (new, events)
    }
}

impl Agent {
    /// Asks all managers. Callers that come while a round runs share the next one.
    pub async fn observe(&self) -> Inventory {
        let begun = self.inventory.rounds.load(Ordering::SeqCst);
        let _one = self.inventory.one_at_a_time.lock().await;
        if self.inventory.rounds.load(Ordering::SeqCst) > begun {
            return self.inventory.last();
        }
        self.inventory.rounds.fetch_add(1, Ordering::SeqCst);
        let managers = self.managers.all();
        let views = futures_util::future::join_all(managers.iter().map(|m| ask(m))).await;
        let before = self.inventory.revision();
        let (inventory, events) = self.inventory.keep(merge(&self.config.node, views));
        for event in events {
            self.events.push(event);
        }
        if inventory.revision != before {
            self.events.bell.notify_one();
        }
        inventory
    }
}

async fn ask(manager: &Manager) -> View {
    let limit = if lock(&manager.seen).responsive {
        ANSWER
    } else {
        ANSWER_SILENT
    };
    let answer = manager
        .link
        .call_within(RequestBody::Inventory, limit, limit)
        .await;
    let mut seen = lock(&manager.seen);
    seen.responsive = match answer {
        Ok(ResponseBody::Inventory(inventory)) => {
            seen.inventory = inventory;
            true
        }
        _ => false,
    };
    View {
        key: manager.key.clone(),
        incarnation: manager.incarnation.clone(),
        pid: manager.pid,
        started: manager.started.get().cloned().unwrap_or_default(),
        responsive: seen.responsive,
        inventory: seen.inventory.clone(),
    }
}

/// The same inventory with its counters and its revision at zero.
fn without_counters(inventory: &Inventory) -> Inventory {
    let mut inventory = inventory.clone();
    inventory.revision = 0;
    for component in inventory
        .managers
        .iter_mut()
        .flat_map(|m| &mut m.components)
    {
        component.executions = 0;
        for connector in &mut component.connectors {
            connector.samples_sent = 0;
            connector.samples_received = 0;
            connector.bytes = 0;
            connector.drops = 0;
        }
    }
    inventory
}

/// What people should know of the change from one inventory to the next.
fn differences(old: &Inventory, new: &Inventory) -> Vec<AgentEvent> {
    let mut events = Vec::new();
    for manager in &new.managers {
        let before = old
            .managers
            .iter()
            .find(|m| m.incarnation == manager.incarnation);
        match (before.is_none_or(|m| m.responsive), manager.responsive) {
            (true, false) => events.push(of_manager(
                "Warning",
                "ManagerSilent",
                &manager.key,
                format!("process {} does not answer", manager.pid),
            )),
            (false, true) => events.push(of_manager(
                "Normal",
                "ManagerAnswers",
                &manager.key,
                format!("process {} answers again", manager.pid),
            )),
            _ => {}
        }
        for component in &manager.components {
            let before = before
                .into_iter()
                .flat_map(|m| &m.components)
                .find(|c| c.incarnation == component.incarnation);
            let was_in_error = before.is_some_and(|c| c.state == LifeCycleState::Error);
            let system = component.system.as_ref().map(|s| s.name.clone());
            if component.state == LifeCycleState::Error && !was_in_error {
                events.push(AgentEvent {
                    kind: "Warning".to_owned(),
                    reason: "ComponentError".to_owned(),
                    object: format!("component/{}", component.instance),
                    system: system.clone(),
                    message: component
                        .message
                        .clone()
                        .unwrap_or_else(|| "went to Error".to_owned()),
                });
            }
            for connector in &component.connectors {
                let was_connected = before
                    .into_iter()
                    .flat_map(|c| &c.connectors)
                    .any(|c| c.name == connector.name && c.state == ConnectorState::Connected);
                if connector.state == ConnectorState::Disconnected && was_connected {
                    events.push(AgentEvent {
                        kind: "Warning".to_owned(),
                        reason: "ConnectorDisconnected".to_owned(),
                        object: format!("connector/{}", connector.name),
                        system: system.clone(),
                        message: format!("lost its other end, {}", connector.target),
                    });
                }
            }
        }
    }
    events
}
