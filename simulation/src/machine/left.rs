//! What there still is on the machine, as nobody but the simulation can see it.

use std::path::PathBuf;

use rts_manager_api::control::ManagerInventory;
use rts_plan::desired::ManagerKey;

use super::SimMachine;
use super::state::{Process, Run};

/// Everything that still exists on a node.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LeftOver {
    /// Managers whose process lives.
    pub processes: Vec<ManagerKey>,
    /// Managers of which something lives that they started.
    pub grandchildren: Vec<ManagerKey>,
    /// Run folders.
    pub folders: Vec<PathBuf>,
    /// Components by instance name.
    pub components: Vec<String>,
    /// Connectors at their out-port ends, and bindings, by connector.
    pub connectors: Vec<String>,
}

impl LeftOver {
    /// True when nothing is left.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// One process as it really is.
#[derive(Debug, Clone, PartialEq)]
pub struct Really {
    /// Which manager.
    pub key: ManagerKey,
    /// Incarnation of the process.
    pub incarnation: String,
    /// It serves, and answers.
    pub answers: bool,
    /// What is in it.
    pub inventory: ManagerInventory,
}

impl SimMachine {
    /// All that exists.
    pub fn left_over(&self) -> LeftOver {
        self.0.change(|state| {
            let mut left = LeftOver {
                folders: state.folders.keys().cloned().collect(),
                ..LeftOver::default()
            };
            for process in state.processes.values() {
                left.add(process);
            }
            left
        })
    }

    /// The processes that live, as they really are.
    pub fn really(&self) -> Vec<Really> {
        self.0.change(|state| {
            let living = state.processes.values().filter(|p| p.lives());
            let really = living.map(|process| Really {
                key: process.key.clone(),
                incarnation: process.hello.incarnation.clone(),
                answers: process.serves && *process.run.borrow() == Run::Runs,
                inventory: process.inventory(),
            });
            really.collect()
        })
    }
}

impl LeftOver {
    fn add(&mut self, process: &Process) {
        if process.lives() {
            self.processes.push(process.key.clone());
        }
        if process.grandchildren > 0 {
            self.grandchildren.push(process.key.clone());
        }
        self.components.extend(process.components.keys().cloned());
        let connectors = process
            .components
            .values()
            .flat_map(|c| c.connectors.keys());
        self.connectors.extend(connectors.cloned());
        self.connectors.extend(process.ends.keys().cloned());
    }
}
