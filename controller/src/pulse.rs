//! Whether the reconcile loop goes on. Agents keep away from their node while this controller accepts their heartbeats;
//! a loop that is stuck must not keep them away.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use rts_controller_api::Problem;
use tokio::time::Instant;

/// No round, and no rest between two, takes so long: a round waits 5 s for agents to store a spec and 2.5 s for what
/// they have, a rest is 5 s at most.
const STUCK: Duration = Duration::from_secs(15);

/// When the loop last began or completed a round.
#[derive(Debug)]
pub struct Pulse(Mutex<Instant>);

impl Default for Pulse {
    fn default() -> Self {
        Self(Mutex::new(Instant::now()))
    }
}

impl Pulse {
    /// A round begins, or is complete.
    pub fn beat(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }

    /// Fails when the loop is stuck.
    pub fn check(&self) -> Result<(), Problem> {
        let last = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let silent = last.elapsed();
        if silent < STUCK {
            return Ok(());
        }
        let detail = format!(
            "the controller's reconcile loop has completed no round for {} s; agents heal their nodes by themselves",
            silent.as_secs()
        );
        Err(Problem::unavailable("reconcile-stuck", detail))
    }
}
