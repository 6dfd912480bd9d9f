//! The end of a manager: its process, what it started, its run folder and its entry go, in this order.

use std::sync::{Arc, Weak};
use std::time::Duration;

use rts_agent_api::session::AgentEvent;
use tokio::time::{Instant, sleep_until};

use super::Manager;
use crate::agent::Agent;
use crate::events::{lock, of_manager};
use crate::launch::{Exit, ExitFuture};
use crate::machine::GROUP_END;

/// Shortest and longest pause before what does not die is killed again.
const AGAIN: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(30));

/// How far the end of a manager is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// Its process lives.
    No,
    /// Its process has ended; what it started is being killed.
    Begun,
    /// What it started does not die. Nothing is started in its place before it does.
    Stuck,
    /// All are gone, and so is its run folder.
    Over,
}

/// When what does not die is killed again.
#[derive(Debug, Clone, Copy)]
pub(super) struct Undying {
    pause: Duration,
    pub next: Instant,
}

impl Undying {
    /// After one more try, which has failed.
    pub fn after(before: Option<Self>) -> Self {
        let (first, longest) = AGAIN;
        let pause = before.map_or(first, |before| (before.pause * 2).min(longest));
        let next = Instant::now() + pause;
        Self { pause, next }
    }
}

impl Manager {
    /// True until its process is known to have ended.
    pub fn lives(&self) -> bool {
        *self.end.borrow() == End::No
    }

    /// True when nothing is left of it but what does not die.
    pub fn is_stuck(&self) -> bool {
        *self.end.borrow() == End::Stuck
    }

    /// True when its process has ended, whether that was noticed or not.
    pub fn has_died(&self) -> bool {
        !self.lives() || self.family.has_ended()
    }

    /// Waits until its process is known to have ended.
    pub async fn died(&self) {
        // The sender lives as long as we do.
        let _ = self.end.subscribe().wait_for(|end| *end != End::No).await;
    }

    /// Waits until the process and all that it started are gone and its run folder is removed.
    pub async fn ended(&self) {
        // The sender lives as long as we do.
        let _ = self.end.subscribe().wait_for(|end| *end == End::Over).await;
    }

    /// The same, but no longer than there is hope; false when there is none.
    pub async fn ended_or_stuck(&self) -> bool {
        let mut end = self.end.subscribe();
        let end = end.wait_for(|end| matches!(end, End::Stuck | End::Over));
        end.await.is_ok_and(|end| *end == End::Over)
    }
}

impl Agent {
    /// Puts a manager into the registry and waits for its end in the background.
    pub(super) fn register(self: &Arc<Self>, manager: Arc<Manager>, exit: ExitFuture) {
        lock(&self.managers.live).insert(manager.key.clone(), manager.clone());
        self.has_acted();
        let agent = Arc::downgrade(self);
        tokio::spawn(async move {
            let exit = exit.await;
            manager.end.send_replace(End::Begun);
            let dead = manager.family.end(GROUP_END).await;
            // Without an agent, the next one finds its folder, and counts it.
            let Some(alive) = agent.upgrade() else { return };
            if !manager.is_stopping() {
                // While its folder tells of it: should we end now, the next agent counts it.
                alive.manager_died(&manager.incarnation, exit).await;
            }
            if !dead {
                alive.stuck(&manager);
                drop(alive);
                if !end_at_last(&agent, &manager).await {
                    return;
                }
            }
            if let Some(agent) = agent.upgrade() {
                agent.bury(&manager, exit).await;
            }
        });
    }

    /// What a manager started does not die: until it does, nothing is started in its place.
    fn stuck(&self, manager: &Manager) {
        manager.end.send_replace(End::Stuck);
        let pid = manager.pid;
        let message = format!(
            "process {pid} has ended, but what it started does not die; nothing is started in its place before that is gone: look at it with `ps`"
        );
        self.events
            .push(of_manager("Warning", "ManagerStuck", &manager.key, message));
        self.dirty.notify_one();
    }

    /// Removes what is left of a manager, and tells of its end.
    async fn bury(&self, manager: &Manager, exit: Exit) {
        self.inputs.machine.remove_folder(&manager.folder).await;
        manager.link.close();
        self.managers.remove(manager);
        self.buried(manager, exit);
        manager.end.send_replace(End::Over);
    }

    /// Tells of a manager's end.
    fn buried(&self, manager: &Manager, exit: Exit) {
        if manager.is_stopping() {
            self.has_acted();
            tracing::info!(manager = manager.key.display_name(), "stopped: {exit}");
            return;
        }
        self.dirty.notify_one();
        let event = died(manager, exit);
        self.manager_failed(&manager.key, event.message.clone());
        self.events.push(event);
    }
}

/// Kills what a manager started again and again, until nobody is left; false when the agent has ended before.
async fn end_at_last(agent: &Weak<Agent>, manager: &Manager) -> bool {
    let mut undying = Undying::after(None);
    while agent.strong_count() > 0 {
        sleep_until(undying.next).await;
        if manager.family.end(GROUP_END).await {
            return true;
        }
        undying = Undying::after(Some(undying));
    }
    false
}

fn died(manager: &Manager, exit: Exit) -> AgentEvent {
    let names: Vec<_> = lock(&manager.seen)
        .inventory
        .components
        .iter()
        .map(|c| c.instance.clone())
        .collect();
    let held = if names.is_empty() {
        "it held no component".to_owned()
    } else {
        format!("with it ended {}", names.join(", "))
    };
    let message = format!(
        "process {} ended unexpectedly ({exit}); {held}",
        manager.pid
    );
    of_manager("Warning", "ManagerDied", &manager.key, message)
}
