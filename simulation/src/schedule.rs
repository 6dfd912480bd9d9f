//! What is done in a run, and what goes wrong in it: data that follows from a seed, can be read, and can be made smaller.
//!
//! Each item has a name by which it is left out. All else that happens by chance comes from streams of its own, so that
//! what is left stays what it was.

mod random;
mod text;

use std::collections::BTreeSet;
use std::time::Duration;

use rts_agent_api::messages::Act;
use rts_schemas::system::SystemSpec;
use serde::{Deserialize, Serialize};

use crate::faults::Timed;
use crate::seed::Seed;
use crate::workload::{self, Change};

/// A run, before it is run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Schedule {
    /// All other chance follows from it.
    pub seed: u64,
    /// Number of nodes, of [`workload::NODES`].
    pub nodes: usize,
    /// Systems as they are first applied.
    pub systems: Vec<SystemSpec>,
    /// What users do, in order of time.
    pub deeds: Vec<Deed>,
    /// What goes wrong, by name.
    pub faults: Vec<Named>,
    /// When everything ends that goes wrong, and users do no more.
    pub quiet: Duration,
}

/// A fault and its name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Named {
    /// Its name (`f0`).
    pub name: String,
    /// The fault.
    pub fault: Timed,
}

/// Something that a user does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Deed {
    /// Its name (`d0`).
    pub name: String,
    /// When; later where the one before takes so long.
    pub at: Duration,
    /// What.
    pub what: What,
}

/// What a user does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", rename_all_fields = "camelCase")]
pub enum What {
    /// Changes a system and applies it.
    Apply {
        /// Its name.
        system: String,
        /// What is changed since the last time.
        change: Change,
    },
    /// Takes a system down.
    Delete {
        /// Its name.
        system: String,
    },
    /// Puts another module of a type in its place, on all nodes. It counts from the next apply on.
    Module {
        /// Type name.
        type_name: String,
        /// Its number.
        version: u32,
    },
    /// Changes by hand what runs.
    Act(Act),
}

impl Schedule {
    /// The schedule of a seed.
    pub fn of(seed: Seed) -> Self {
        random::schedule(seed)
    }

    /// Names of all that can be left out: faults, deeds, components.
    pub fn names(&self) -> Vec<String> {
        let faults = self.faults.iter().map(|f| f.name.clone());
        let deeds = self.deeds.iter().map(|d| d.name.clone());
        let mut names: Vec<String> = faults.chain(deeds).collect();
        names.extend(self.components());
        names
    }

    /// Names of all components.
    pub fn components(&self) -> impl Iterator<Item = String> {
        let all = self.systems.iter().flat_map(|s| &s.components);
        all.map(|c| c.instance.clone())
    }

    /// The same without these. A system keeps one component.
    #[must_use]
    pub fn without(&self, names: &BTreeSet<String>) -> Self {
        let mut less = self.clone();
        less.faults.retain(|f| !names.contains(&f.name));
        less.deeds.retain(|d| !names.contains(&d.name));
        for system in &mut less.systems {
            for name in names {
                let here = workload::component(system, name).is_some();
                if here && system.components.len() > 1 {
                    *system = workload::without(system, name);
                }
            }
        }
        less
    }
}

#[cfg(test)]
mod tests;
