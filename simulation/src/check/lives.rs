//! What lives now, as far as it was told.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use crate::truth::{Happened, Subject};

/// A component that lives.
#[derive(Debug, Clone)]
pub(super) struct Alive {
    pub subject: Subject,
    /// Since when.
    pub born: Duration,
    /// `Inactive`, `Active` or `Error`.
    pub state: String,
    /// A fault has hit it.
    pub blemished: bool,
    /// Its connectors, with the incarnation that each led to when it was made; none where that is not known.
    pub connectors: BTreeMap<String, Option<String>>,
}

/// All components that live, by incarnation.
#[derive(Debug, Default)]
pub(super) struct Lives {
    alive: BTreeMap<String, Alive>,
    /// Incarnations of processes that a fault has hit.
    blemished: BTreeSet<String>,
}

impl Lives {
    /// Takes in what happened. Connectors are the caller's business: what they lead to is a matter of what is desired.
    pub fn see(&mut self, at: Duration, what: &Happened) {
        match what {
            Happened::Created(subject) => {
                let alive = Alive {
                    subject: subject.clone(),
                    born: at,
                    state: "Inactive".to_owned(),
                    blemished: false,
                    connectors: BTreeMap::new(),
                };
                self.alive.insert(subject.incarnation.clone(), alive);
            }
            Happened::Deleted(subject, _) => {
                self.alive.remove(&subject.incarnation);
            }
            Happened::State { of, to, .. } => {
                if let Some(alive) = self.alive.get_mut(&of.incarnation) {
                    alive.state.clone_from(to);
                }
            }
            Happened::ProcessEnded { process, .. } => {
                self.alive
                    .retain(|_, alive| alive.subject.process != *process);
                self.blemished.remove(process);
            }
            Happened::Rebooted { node } => self.alive.retain(|_, a| a.subject.node != *node),
            Happened::Blemished {
                process,
                instance: None,
                ..
            } => {
                self.blemished.insert(process.clone());
            }
            Happened::Blemished {
                process,
                instance: Some(instance),
                ..
            } => {
                let mut all = self.alive.values_mut();
                let hit = |a: &&mut Alive| {
                    a.subject.process == *process && a.subject.instance == *instance
                };
                if let Some(alive) = all.find(hit) {
                    alive.blemished = true;
                }
            }
            _ => {}
        }
    }

    /// This very one.
    pub fn get(&self, incarnation: &str) -> Option<&Alive> {
        self.alive.get(incarnation)
    }

    /// This very one.
    pub fn get_mut(&mut self, incarnation: &str) -> Option<&mut Alive> {
        self.alive.get_mut(incarnation)
    }

    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = &Alive> {
        self.alive.values()
    }

    /// The instance of a system.
    pub fn find(&self, uid: &str, instance: &str) -> Option<&Alive> {
        self.alive.values().find(|alive| {
            let of = alive.subject.system.as_ref();
            of.is_some_and(|s| s.uid == uid) && alive.subject.instance == instance
        })
    }

    /// True when a fault has hit its process, or anything in that.
    pub fn process_is_blemished(&self, process: &str) -> bool {
        let inside = |a: &&Alive| a.subject.process == process;
        self.blemished.contains(process) || self.all().filter(inside).any(|a| a.blemished)
    }
}

impl Subject {
    /// For people.
    pub(super) fn shown(&self) -> String {
        let instance = &self.instance;
        let of = self.system.as_ref().map_or_else(
            || "made by hand".to_owned(),
            |system| format!("of {}", system.name),
        );
        format!("component {instance} {of} on {}", self.node)
    }
}
