//! What a run came by: so that nobody takes a run in which nothing happened for a proof.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use crate::truth::{Happened, Witness};

/// Counts by what was counted. Clones are the same.
#[derive(Clone, Default)]
pub struct Coverage(Arc<Mutex<BTreeMap<String, u64>>>);

impl Coverage {
    /// Counts one.
    pub fn count(&self, what: &str) {
        self.add(what, 1);
    }

    /// Counts some.
    pub fn add(&self, what: &str, count: u64) {
        if count > 0 {
            let mut counts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            *counts.entry(what.to_owned()).or_default() += count;
        }
    }

    /// All counts.
    pub fn counts(&self) -> BTreeMap<String, u64> {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

impl Witness for Coverage {
    fn see(&mut self, _: Duration, what: &Happened) {
        match what {
            Happened::StepBegan { step, .. } => {
                let kind = step.split_once(' ').map_or(step.as_str(), |(kind, _)| kind);
                self.count(&format!("step {kind}"));
            }
            Happened::Crashed { host, .. } if host == "controller" => {
                self.count("crashes of the controller");
            }
            Happened::Crashed { .. } => self.count("crashes of agents"),
            Happened::DidNotStart { .. } => self.count("programs that did not come up"),
            Happened::Rebooted { .. } => self.count("losses of power"),
            Happened::ProcessStarted { .. } => self.count("processes started"),
            Happened::Created(_) => self.count("components created"),
            Happened::LedgerAcked { .. } => self.count("sets acknowledged"),
            _ => {}
        }
    }
}
