//! The program: from its home to a served socket, and to an orderly end.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use rts_host::memory;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;
use tokio::time::Instant;

use crate::clock::{Chance, SystemChance, SystemClock};
use crate::core::{Core, Inputs};
use crate::fleet::HttpFleet;
use crate::hearing::Hearing;
use crate::home::{Home, HomeError};
use crate::pace::publish_late;
use crate::reconcile::Reconciler;
use crate::simulator::Simulator;
use crate::store::{OffLoop, RedbStore, StoreError};
use crate::view::Happening;

/// Time that open requests have once the program is told to end.
const GRACE: Duration = Duration::from_secs(3);
/// How often it is looked whether the lock is still there.
const LOOK: Duration = Duration::from_secs(1);
/// How often heartbeats are checked when no node is alive.
const IDLE: Duration = Duration::from_secs(1);

/// Settings.
#[derive(Debug, Clone)]
pub struct Config {
    /// `RTSCTL_HOME`.
    pub home: PathBuf,
    /// Name of the local node.
    pub local_node: String,
}

/// The controller could not start or serve.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The home.
    #[error(transparent)]
    Home(#[from] HomeError),
    /// The store.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The runtime, a signal handler or the socket.
    #[error("cannot {what}")]
    Io {
        /// What was being tried.
        what: &'static str,
        /// Why.
        #[source]
        source: std::io::Error,
    },
}

/// Runs until SIGTERM or SIGINT. Prints one line about its readiness to stdout.
/// `simulator` plays changes through for whoever asks.
pub fn run(config: &Config, simulator: Arc<dyn Simulator>) -> Result<(), RunError> {
    let result = start(config, simulator);
    if let Err(Fail::BeforeReady(error)) = &result {
        say(&serde_json::json!({"ready": false, "error": rts_host::error::chain(error)}));
    }
    result.map_err(|fail| match fail {
        Fail::BeforeReady(error) | Fail::Later(error) => error,
    })
}

enum Fail {
    BeforeReady(RunError),
    Later(RunError),
}

fn start(config: &Config, simulator: Arc<dyn Simulator>) -> Result<(), Fail> {
    let before = |error: RunError| Fail::BeforeReady(error);
    // Each agent takes a connection each way.
    rts_host::limits::raise_open_files();
    memory::few_heaps();
    let mut home = Home::take(&config.home).map_err(|e| before(e.into()))?;
    let store =
        RedbStore::open(&home.store(), &SystemChance.uuid()).map_err(|e| before(e.into()))?;
    let inputs = Inputs {
        local_node: config.local_node.clone(),
        clock: Arc::new(SystemClock),
        rng: Arc::new(SystemChance),
        fleet: Arc::new(HttpFleet),
        store: Arc::new(OffLoop::new(store)),
        simulator,
    };
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|source| before(io("start the event loop", source)))?;
    let result = runtime.block_on(serve(&mut home, inputs));
    // A request that does not end in time must not keep the program.
    runtime.shutdown_timeout(GRACE);
    home.leave();
    result
}

async fn serve(home: &mut Home, inputs: Inputs) -> Result<(), Fail> {
    let loaded = Core::load(inputs).await;
    let core = loaded.map_err(|e| Fail::BeforeReady(e.into()))?;
    let before = |what| move |source| Fail::BeforeReady(io(what, source));
    let mut terminate = signal(SignalKind::terminate()).map_err(before("listen for SIGTERM"))?;
    let mut interrupt = signal(SignalKind::interrupt()).map_err(before("listen for SIGINT"))?;
    let (end, ending) = watch::channel(false);
    let router = crate::api::router(Arc::clone(&core), ending.clone());
    let mut told = ending;
    let shutdown = async move {
        let _ = told.wait_for(|end| *end).await;
    };
    // Binds anew when somebody deletes the socket: the lock says that it is ours.
    let server = rts_http::server::serve_at(&home.socket(), router, shutdown)
        .map_err(before("bind the socket"))?;
    home.announce().map_err(|e| Fail::BeforeReady(e.into()))?;
    tokio::spawn(Reconciler::new(Arc::clone(&core)).run());
    tokio::spawn(publish_late(Arc::clone(&core)));
    tokio::spawn(expire_sessions(core));
    tokio::spawn(memory::keep_small());
    let mut server = tokio::spawn(server);
    say(&serde_json::json!({"ready": true}));
    tracing::info!(version = env!("CARGO_PKG_VERSION"), "ready");
    tokio::select! {
        _ = terminate.recv() => {}
        _ = interrupt.recv() => {}
        error = keep(home) => return Err(Fail::Later(error.into())),
        ended = &mut server => {
            let source = match ended {
                Ok(Err(source)) => source,
                Ok(Ok(())) => std::io::Error::other("the server ended by itself"),
                Err(e) => std::io::Error::other(e),
            };
            return Err(Fail::Later(io("serve", source)));
        }
    }
    tracing::info!("ending");
    end.send_replace(true);
    if tokio::time::timeout(GRACE, server).await.is_err() {
        tracing::warn!("open requests were cut off");
    }
    Ok(())
}

/// Keeps the lock for as long as this is awaited; ends when another controller has it.
async fn keep(home: &mut Home) -> HomeError {
    let mut complaint = String::new();
    loop {
        tokio::time::sleep(LOOK).await;
        match home.keep() {
            Ok(()) => complaint.clear(),
            Err(error @ HomeError::Held { .. }) => return error,
            // It may do better the next time.
            Err(error) => {
                let error = rts_host::error::chain(&error);
                if error != complaint {
                    tracing::error!(error, "the lock of the home is lost");
                    complaint = error;
                }
            }
        }
    }
}

/// Marks nodes whose heartbeats stopped as unknown, for ever.
pub async fn expire_sessions(core: Arc<Core>) {
    let mut changed = core.sessions.subscribe();
    let mut hearing = Hearing::new();
    loop {
        let (lost, next) = core.sessions.expire(hearing.deaf());
        for node in &lost {
            let object = format!("node/{node}");
            if core.sessions.get(node).is_some_and(|entry| entry.sleeps()) {
                let message = "its session is closed: it is reached when a command needs it";
                core.record(Happening::normal("NodeLeft", &object, message));
                continue;
            }
            tracing::warn!(node, "no heartbeat: unknown");
            let message = "no heartbeat in time: its state is unknown";
            core.record(Happening::warning("NodeUnknown", &object, message));
        }
        if !lost.is_empty() {
            core.publish_soon();
            core.wake.notify_one();
        }
        let until = match next {
            Some(next) => next.min(hearing.next()),
            None => Instant::now() + IDLE,
        };
        tokio::select! {
            biased;
            () = tokio::time::sleep_until(until) => {}
            _ = changed.changed() => {}
        }
    }
}

fn io(what: &'static str, source: std::io::Error) -> RunError {
    RunError::Io { what, source }
}

/// One line of JSON to stdout. Whoever started us may have gone; that is no reason to stop.
fn say(line: &serde_json::Value) {
    let mut out = std::io::stdout().lock();
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}
