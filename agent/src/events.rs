//! What the agent saw and has not yet told its controller: a bounded list; the oldest are dropped first.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use rts_agent_api::session::AgentEvent;
use rts_plan::desired::ManagerKey;
use tokio::sync::Notify;

/// Most events that wait for a controller.
const CAPACITY: usize = 256;

/// Locks a mutex whose data is whole between any two statements, so that a panic elsewhere does not matter.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Events that wait, and the bell that rings when there is something to tell.
#[derive(Debug, Default)]
pub(crate) struct Events {
    waiting: Mutex<Waiting>,
    /// Rings when the controller should hear from us before the next heartbeat is due.
    pub bell: Notify,
}

#[derive(Debug, Default)]
struct Waiting {
    first: u64,
    events: VecDeque<AgentEvent>,
}

impl Events {
    /// Keeps an event and logs it.
    pub fn push(&self, event: AgentEvent) {
        if event.kind == "Warning" {
            tracing::warn!(
                reason = event.reason,
                object = event.object,
                "{}",
                event.message
            );
        } else {
            tracing::info!(
                reason = event.reason,
                object = event.object,
                "{}",
                event.message
            );
        }
        let mut waiting = lock(&self.waiting);
        if waiting.events.len() == CAPACITY {
            waiting.events.pop_front();
            waiting.first += 1;
        }
        waiting.events.push_back(event);
        drop(waiting);
        self.bell.notify_one();
    }

    /// The events that wait, and the mark with which [`Self::told`] forgets them.
    pub fn waiting(&self) -> (u64, Vec<AgentEvent>) {
        let waiting = lock(&self.waiting);
        let mark = waiting.first + waiting.events.len() as u64;
        (mark, waiting.events.iter().cloned().collect())
    }

    /// Forgets the events up to a mark.
    pub fn told(&self, mark: u64) {
        let mut waiting = lock(&self.waiting);
        while waiting.first < mark && waiting.events.pop_front().is_some() {
            waiting.first += 1;
        }
    }
}

/// An event about a manager.
pub(crate) fn of_manager(
    kind: &str,
    reason: &str,
    key: &ManagerKey,
    message: impl Into<String>,
) -> AgentEvent {
    AgentEvent {
        kind: kind.to_owned(),
        reason: reason.to_owned(),
        object: format!("manager/{}", key.display_name()),
        system: key.system.as_ref().map(|s| s.name.clone()),
        message: message.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(n: usize) -> AgentEvent {
        AgentEvent {
            kind: "Normal".to_owned(),
            reason: "Test".to_owned(),
            object: format!("manager/{n}"),
            system: None,
            message: String::new(),
        }
    }

    #[test]
    fn what_was_told_is_forgotten_even_when_the_list_overflowed_meanwhile() {
        let events = Events::default();
        for n in 0..CAPACITY {
            events.push(event(n));
        }
        let (mark, told) = events.waiting();
        assert_eq!(told.len(), CAPACITY);
        for n in 0..10 {
            events.push(event(CAPACITY + n));
        }
        assert_eq!(events.waiting().1.len(), CAPACITY);
        events.told(mark);
        let left: Vec<_> = events.waiting().1.into_iter().map(|e| e.object).collect();
        assert_eq!(left.len(), 10);
        assert_eq!(left[0], format!("manager/{CAPACITY}"));
    }
}
