//! Stopping a manager: ask, then SIGTERM, then SIGKILL, the last two for all that it started.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use rts_manager_api::control::RequestBody;
use tokio::time::timeout;

use super::Manager;
use crate::events::lock;
use crate::machine::Signal;

/// For the orderly end.
const ASK: Duration = Duration::from_secs(5);
/// The same for a manager that did not answer before.
const ASK_SILENT: Duration = Duration::from_millis(500);
/// From a good answer to the end of the process.
const LEAVE: Duration = Duration::from_secs(1);
/// After SIGTERM.
const TERM: Duration = Duration::from_secs(5);
/// After SIGKILL: the kernel's own time, and the clean-up.
const KILL: Duration = Duration::from_secs(5);

/// Both, for a manager in which something hangs: the others in it are deactivated by then.
const SHORT: Duration = Duration::from_secs(1);

/// How long a manager is asked before it is killed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Patience {
    /// As long as its components may need.
    Usual,
    /// Something in it hangs for longer than its policy allows.
    Short,
}

/// A manager that outlives SIGKILL.
#[derive(Debug, thiserror::Error)]
#[error(
    "process {pid} of manager {manager} still lives after SIGKILL; look at its state with `ps`"
)]
pub(crate) struct StopError {
    manager: String,
    pid: u32,
}

impl Manager {
    /// Stops it and waits until the process and all that it started are gone. Goes on when the caller gives up.
    pub async fn stop(self: &Arc<Self>, patience: Patience) -> Result<(), StopError> {
        self.stopping.store(true, Ordering::Relaxed);
        let manager = self.clone();
        let failed = || StopError {
            manager: self.key.display_name(),
            pid: self.pid,
        };
        tokio::spawn(async move { manager.stop_now(patience).await })
            .await
            .map_err(|_| failed())?
            .then_some(())
            .ok_or_else(failed)
    }

    async fn stop_now(&self, patience: Patience) -> bool {
        let silent = !lock(&self.seen).responsive;
        let (ask, term) = match patience {
            _ if silent => (ASK_SILENT, TERM),
            Patience::Usual => (ASK, TERM),
            Patience::Short => (SHORT, SHORT),
        };
        let asked = self.link.call_within(RequestBody::Shutdown, ask, ask);
        let answer = tokio::select! {
            biased;
            () = self.ended() => return true,
            answer = asked => answer,
        };
        match answer {
            Ok(_) => {
                if self.gone_within(LEAVE).await {
                    return true;
                }
            }
            Err(e) => tracing::info!(manager = self.key.display_name(), "no orderly end: {e}"),
        }
        self.family.signal(Signal::Term).await;
        // A stopped process sees no SIGTERM before it goes on.
        self.family.signal(Signal::Cont).await;
        if self.gone_within(term).await {
            return true;
        }
        self.family.signal(Signal::Kill).await;
        self.gone_within(KILL).await
    }

    async fn gone_within(&self, limit: Duration) -> bool {
        timeout(limit, self.ended()).await.is_ok()
    }
}
