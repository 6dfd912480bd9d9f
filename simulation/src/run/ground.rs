//! What lives now, by what really happened.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::Notify;

use crate::truth::{Happened, Subject, Witness};

/// What lives. Clones are the same.
#[derive(Clone, Default)]
pub(super) struct Ground {
    state: Arc<Mutex<State>>,
    /// Told of each step that begins.
    stepped: Arc<Notify>,
}

#[derive(Default)]
struct State {
    /// By incarnation.
    alive: BTreeMap<String, Alive>,
    /// Node and incarnation.
    processes: BTreeSet<(String, String)>,
    /// Steps that began.
    steps: u32,
}

/// A component that lives.
#[derive(Debug, Clone)]
pub(super) struct Alive {
    pub subject: Subject,
    pub state: String,
    pub connectors: BTreeSet<String>,
}

impl Ground {
    /// All components.
    pub fn alive(&self) -> Vec<Alive> {
        self.lock().alive.values().cloned().collect()
    }

    /// Number of processes.
    pub fn processes(&self) -> usize {
        self.lock().processes.len()
    }

    /// Waits until so many steps have begun.
    pub async fn until_step(&self, step: u32) {
        loop {
            let stepped = self.stepped.notified();
            if self.lock().steps >= step {
                return;
            }
            stepped.await;
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Witness for Ground {
    fn see(&mut self, _: Duration, what: &Happened) {
        if let Happened::StepBegan { .. } = what {
            self.lock().steps += 1;
            self.stepped.notify_waiters();
        }
        let state = &mut *self.lock();
        match what {
            Happened::ProcessStarted { node, process, .. } => {
                state.processes.insert((node.clone(), process.clone()));
            }
            Happened::ProcessEnded { node, process, .. } => {
                state.processes.remove(&(node.clone(), process.clone()));
                state.alive.retain(|_, a| a.subject.process != *process);
            }
            Happened::Created(subject) => {
                let alive = Alive {
                    subject: subject.clone(),
                    state: "Inactive".to_owned(),
                    connectors: BTreeSet::new(),
                };
                state.alive.insert(subject.incarnation.clone(), alive);
            }
            Happened::Deleted(subject, _) => drop(state.alive.remove(&subject.incarnation)),
            Happened::State { of, to, .. } => {
                if let Some(alive) = state.alive.get_mut(&of.incarnation) {
                    alive.state.clone_from(to);
                }
            }
            Happened::Connected { of, connector } => {
                if let Some(alive) = state.alive.get_mut(&of.incarnation) {
                    alive.connectors.insert(connector.clone());
                }
            }
            Happened::Disconnected { of, connector, .. } => {
                if let Some(alive) = state.alive.get_mut(&of.incarnation) {
                    alive.connectors.remove(connector);
                }
            }
            Happened::Rebooted { node } => {
                state.processes.retain(|(n, _)| n != node);
                state.alive.retain(|_, a| a.subject.node != *node);
            }
            _ => {}
        }
    }
}
