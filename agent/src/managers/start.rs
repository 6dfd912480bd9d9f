//! Starting a manager, once per key.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use rts_host::timing::TARGET;
use rts_plan::desired::ManagerKey;
use tokio::time::{Instant, sleep, timeout};
use tracing::{Instrument, info_span};

use super::adopt::{Settled, settle};
use super::{Identity, Manager};
use crate::agent::Agent;
use crate::events::{lock, of_manager};
use crate::launch::{Exit, LaunchError, Start};
use crate::machine::{DESCRIBE, GROUP_END, Launched};

/// How long a manager may take to say Hello.
pub(crate) const HELLO: Duration = Duration::from_secs(5);
/// How long the one before may take to end: as long as a stop takes at most.
const LAST_END: Duration = Duration::from_secs(20);
/// Pause between two looks at a folder that somebody holds.
const PAUSE: Duration = Duration::from_millis(50);
/// Lines of its log that an error shows.
const LOG_LINES: usize = 5;

/// A manager that cannot be started.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StartManagerError {
    /// The process cannot be made.
    #[error("{0}: {source}", source = .0.source)]
    Launch(#[from] LaunchError),
    /// Its folder cannot be made.
    #[error("cannot make the run folder {folder}: {source}")]
    Folder {
        /// The folder.
        folder: String,
        /// Why.
        source: io::Error,
    },
    /// A process that is not known here holds the folder.
    #[error(
        "a process that this agent does not know holds {folder}/lock; stop it, or run `rtsctl down`"
    )]
    Held {
        /// The folder.
        folder: String,
    },
    /// The one before does not end.
    #[error(
        "the manager {manager} that ran, or what it started, does not end, so no new one can start; look at its processes with `ps`"
    )]
    Ending {
        /// Display name.
        manager: String,
    },
    /// It cannot be spoken to.
    #[error(transparent)]
    Link(#[from] crate::manager_link::LinkError),
    /// It ended before it was ready.
    #[error(
        "manager {manager} ended before it was ready ({exit}){}",
        last_lines(log)
    )]
    Ended {
        /// Display name.
        manager: String,
        /// How.
        exit: Exit,
        /// Last lines of its log.
        log: String,
    },
    /// It did not say Hello.
    #[error("manager {manager} was not ready within {} s{}", HELLO.as_secs(), last_lines(log))]
    Late {
        /// Display name.
        manager: String,
        /// Last lines of its log.
        log: String,
    },
    /// Our own fault.
    #[error("starting manager {manager} failed: {reason}")]
    Internal {
        /// Display name.
        manager: String,
        /// Why.
        reason: String,
    },
}

fn last_lines(log: &str) -> String {
    if log.is_empty() {
        "; it wrote nothing".to_owned()
    } else {
        format!("; it wrote: {}", log.trim_end().replace('\n', " / "))
    }
}

impl Agent {
    /// The live manager with this key; started when there is none. Goes on when the caller gives up.
    pub async fn ensure_manager(
        self: &Arc<Self>,
        key: &ManagerKey,
    ) -> Result<Arc<Manager>, StartManagerError> {
        let (agent, key) = (self.clone(), key.clone());
        let manager = key.display_name();
        let work = async move { agent.ensure_once(key).await };
        tokio::spawn(work.in_current_span())
            .await
            .unwrap_or_else(|e| {
                let reason = e.to_string();
                Err(StartManagerError::Internal { manager, reason })
            })
    }

    async fn ensure_once(
        self: Arc<Self>,
        key: ManagerKey,
    ) -> Result<Arc<Manager>, StartManagerError> {
        let gate = lock(&self.managers.starting)
            .entry(key.clone())
            .or_default()
            .clone();
        let result = {
            let _one_at_a_time = gate.lock().await;
            self.reuse_or_start(&key).await
        };
        let mut starting = lock(&self.managers.starting);
        // Ours and the map's: nobody else waits.
        if Arc::strong_count(&gate) == 2 {
            starting.remove(&key);
        }
        result
    }

    async fn reuse_or_start(
        self: &Arc<Self>,
        key: &ManagerKey,
    ) -> Result<Arc<Manager>, StartManagerError> {
        let present = lock(&self.managers.live).get(key).cloned();
        if let Some(manager) = present {
            if manager.lives() && !manager.is_stopping() {
                return Ok(manager);
            }
            // Never start the next one before the last one has freed its folder.
            if !matches!(timeout(LAST_END, manager.ended_or_stuck()).await, Ok(true)) {
                let manager = key.display_name();
                return Err(StartManagerError::Ending { manager });
            }
        }
        let start = Start {
            key: key.clone(),
            incarnation: self.inputs.chance.uuid(),
            folder: self.folders.manager(key),
            log: self.folders.manager_log(key),
        };
        let prepared = self.prepare(&start);
        let span = info_span!(target: TARGET, "folder");
        if let Some(manager) = prepared.instrument(span).await? {
            // A manager that an earlier agent had started. Should it say nothing, the steps that ask it say so.
            let _ = timeout(HELLO, manager.link.ready()).await;
            return Ok(manager);
        }
        let started = self.start(&start).await;
        if started.is_err() {
            self.inputs.machine.remove_folder(&start.folder).await;
        }
        started
    }

    /// Makes an empty run folder, unless its manager lives: then gives that one.
    async fn prepare(
        self: &Arc<Self>,
        start: &Start,
    ) -> Result<Option<Arc<Manager>>, StartManagerError> {
        let folder = start.folder.as_path();
        let end = Instant::now() + DESCRIBE + PAUSE;
        let failed = |source| StartManagerError::Folder {
            folder: folder.display().to_string(),
            source,
        };
        loop {
            {
                let _folders = self.managers.folders.lock().await;
                // Most often nobody was there before.
                let claimed = self.inputs.machine.claim_folder(folder).await;
                if claimed.map_err(failed)? {
                    return Ok(None);
                }
                match settle(self, folder).await.map_err(failed)? {
                    Settled::Adopted(manager) => return Ok(Some(manager)),
                    Settled::Free => {
                        let made = self.inputs.machine.make_folder(folder).await;
                        made.map_err(failed)?;
                        return Ok(None);
                    }
                    Settled::Undying => {
                        let manager = start.key.display_name();
                        return Err(StartManagerError::Ending { manager });
                    }
                    Settled::Held if Instant::now() < end => {}
                    Settled::Held => {
                        let folder = folder.display().to_string();
                        return Err(StartManagerError::Held { folder });
                    }
                }
            }
            sleep(PAUSE).await;
        }
    }

    async fn start(self: &Arc<Self>, start: &Start) -> Result<Arc<Manager>, StartManagerError> {
        let launched = self.inputs.machine.launch(start);
        let span = info_span!(target: TARGET, "launch");
        let launched = launched
            .instrument(span)
            .await
            .map_err(|e| match e.is_ending() {
                true => StartManagerError::Ending {
                    manager: start.key.display_name(),
                },
                false => e.into(),
            })?;
        let greeted = self.greet(start, launched);
        let span = info_span!(target: TARGET, "ready");
        greeted.instrument(span).await
    }

    /// Waits for the Hello of a manager that was launched; ends it when that does not come.
    async fn greet(
        self: &Arc<Self>,
        start: &Start,
        launched: Launched,
    ) -> Result<Arc<Manager>, StartManagerError> {
        let Launched {
            family,
            control,
            mut exit,
            log_start,
        } = launched;
        let manager = start.key.display_name();
        let log = || self.inputs.machine.log_end(start, log_start, LOG_LINES);
        let identity = Identity {
            key: start.key.clone(),
            incarnation: start.incarnation.clone(),
            family,
            folder: start.folder.clone(),
        };
        let started = Manager::new(self, identity, Some(control));
        let (pid, family) = (started.pid, &started.family);
        let ready = async {
            tokio::select! {
                biased;
                hello = started.link.ready() => Ok(hello),
                exit = &mut exit => Err(exit),
            }
        };
        match timeout(HELLO, ready).await {
            Ok(Ok(Err(refused))) => {
                family.end(GROUP_END).await;
                // Reaps it; killed as it is, this cannot take long.
                let _ = timeout(GROUP_END, exit).await;
                Err(refused.into())
            }
            Ok(Ok(Ok(hello))) => {
                let _ = started.started.set(hello.started);
                let message = format!("process {pid} started");
                self.events
                    .push(of_manager("Normal", "ManagerStarted", &start.key, message));
                self.register(started.clone(), exit);
                Ok(started)
            }
            Ok(Err(exit)) => {
                family.end(GROUP_END).await;
                let log = log().await;
                Err(StartManagerError::Ended { manager, exit, log })
            }
            Err(_) => {
                family.end(GROUP_END).await;
                // Reaps it; killed as it is, this cannot take long.
                let _ = timeout(GROUP_END, exit).await;
                let log = log().await;
                Err(StartManagerError::Late { manager, log })
            }
        }
    }
}
