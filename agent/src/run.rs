//! Start and end of an agent.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use rts_host::files;
use rts_host::identity::Identity;
use rts_http::server::serve_at;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::oneshot;
use tokio::task::{JoinHandle, JoinSet};
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};

use crate::agent::{Agent, StartError};
use crate::config::Config;
use crate::folders::Folders;
use crate::launch::{Launcher, ProcessLauncher};
use crate::managers::{adopt_all, adopt_round, bury_orphans};
use crate::node_lock::NodeLock;
use crate::{api, heal, session};

/// How often the managers are asked without a reason: one that hangs tells nobody.
const SLOW_TICK: Duration = Duration::from_secs(1);
/// Slow ticks from one look for what managers without a run folder left behind to the next.
const ORPHANS: u64 = 30;
/// Shortest time between two rounds of questions.
const QUICK: Duration = Duration::from_millis(10);
/// Open files that are enough for any node.
const MAX_FILES: u64 = 65_536;
/// How long open requests may take when the agent ends.
const LAST_REQUESTS: Duration = Duration::from_secs(1);

/// An agent that failed.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// It did not start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// Its lock was removed, and another agent has taken the node.
    #[error("the lock of this agent was removed, and the node is no longer its own")]
    Taken(#[source] StartError),
    /// The runtime, a signal or the socket failed.
    #[error("the agent failed")]
    Io(#[from] io::Error),
}

/// An agent that serves. Dropping it leaves its socket behind; use [`Running::stop`].
pub struct Running {
    agent: Arc<Agent>,
    /// Told when another agent has taken the node; closed when the agent no longer looks.
    lost: oneshot::Receiver<StartError>,
    server: JoinHandle<io::Result<()>>,
    stop: oneshot::Sender<()>,
    background: JoinSet<()>,
}

/// The description of the HTTP API, as JSON text.
pub fn openapi() -> String {
    // A document that was just built can be written.
    api::openapi().to_pretty_json().unwrap_or_default()
}

/// Runs an agent until SIGTERM or SIGINT. Prints one line of JSON when it serves, or why it does not.
pub fn run(config: Config) -> Result<(), RunError> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    let launcher = Arc::new(ProcessLauncher::new(&config.manager_program));
    raise_file_limit();
    let result = runtime.block_on(async {
        let mut term = signal(SignalKind::terminate())?;
        let mut interrupt = signal(SignalKind::interrupt())?;
        let mut running = start(config, launcher).await?;
        announce(&serde_json::json!({ "ready": true }));
        let ended = tokio::select! {
            _ = term.recv() => Ok(()),
            _ = interrupt.recv() => Ok(()),
            taken = running.lost() => Err(RunError::Taken(taken)),
        };
        tracing::info!("stopping; managers go on");
        running.stop().await;
        ended
    });
    // A blocking task, such as hashing a module, must not hold up the end.
    runtime.shutdown_background();
    if let Err(e @ RunError::Start(_)) = &result {
        announce(&serde_json::json!({ "ready": false, "error": chain(e) }));
    }
    result
}

/// A node with many managers needs many files; the usual soft limit of 1024 is meant for programs that use `select`.
fn raise_file_limit() {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let limit = getrlimit(Resource::Nofile);
    let wanted = limit.maximum.unwrap_or(MAX_FILES).min(MAX_FILES);
    if limit.current.is_none_or(|current| current >= wanted) {
        return;
    }
    let raised = Rlimit {
        current: Some(wanted),
        maximum: limit.maximum,
    };
    if let Err(e) = setrlimit(Resource::Nofile, raised) {
        tracing::warn!("cannot raise the limit of open files to {wanted}: {e}");
    }
}

fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(error) = source {
        text.push_str(&format!(": {error}"));
        source = error.source();
    }
    text
}

fn announce(line: &serde_json::Value) {
    // Whoever started us may be gone already.
    let _ = writeln!(io::stdout().lock(), "{line}");
}

/// Starts an agent within the present runtime; it serves when this returns.
pub async fn start(config: Config, launcher: Arc<dyn Launcher>) -> Result<Running, StartError> {
    let folders = Folders::new(&config.home, &config.node)?;
    folders.make()?;
    let lock = NodeLock::take(&folders, &config.node).await?;
    let agent = Arc::new(Agent::new(config, folders, launcher)?);
    adopt_all(&agent).await;
    agent.observe().await;
    let (stop, stopped) = oneshot::channel();
    let socket = agent.folders.agent_socket();
    let stopped = async {
        let _ = stopped.await;
    };
    let server =
        serve_at(&socket, api::router(agent.clone()), stopped).map_err(in_file(&socket))?;
    let server = tokio::spawn(server);
    describe(&agent)?;
    let mut background = JoinSet::new();
    let (lose, lost) = oneshot::channel();
    background.spawn(watch(agent.clone(), lock, lose));
    background.spawn(heal::keep(agent.clone()));
    if let Some(controller) = session::client(&agent).map_err(StartError::Client)? {
        background.spawn(session::keep(agent.clone(), controller));
    }
    tracing::info!(
        node = agent.config.node,
        session = agent.session,
        managers = agent.managers.all().len(),
        "agent serves on {}",
        agent.folders.agent_socket().display()
    );
    Ok(Running {
        agent,
        lost,
        server,
        stop,
        background,
    })
}

impl Running {
    /// The socket on which it serves.
    pub fn socket(&self) -> PathBuf {
        self.agent.folders.agent_socket()
    }

    /// Waits until another agent has taken the node: this one must end, and has stopped healing.
    pub async fn lost(&mut self) -> StartError {
        match (&mut self.lost).await {
            Ok(why) => why,
            // Nobody looks any more: it is just being stopped.
            Err(_) => std::future::pending().await,
        }
    }

    /// Ends it. Managers go on.
    pub async fn stop(mut self) {
        self.background.shutdown().await;
        self.agent.restarts.save().await;
        // One that another agent has written stays.
        let description = description(&self.agent);
        if Identity::read(&description).is_some_and(|i| i.pid == std::process::id()) {
            let _ = fs::remove_file(description);
        }
        // The socket is removed by the server.
        let _ = self.stop.send(());
        if timeout(LAST_REQUESTS, &mut self.server).await.is_err() {
            // Streams of batches that run.
            self.server.abort();
        }
    }
}

/// Asks the managers whenever something may have changed, and now and then without a reason. Holds the lock of the
/// node, and ends when another agent has it.
async fn watch(agent: Arc<Agent>, mut lock: NodeLock, lose: oneshot::Sender<StartError>) {
    let mut slow = interval(SLOW_TICK);
    slow.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut ticks = 0_u64;
    loop {
        tokio::select! {
            () = agent.dirty.notified() => {}
            _ = slow.tick() => {
                if let Err(e) = keep_folders(&agent, &mut lock) {
                    agent.lease.superseded();
                    agent.batches.cancel_all("another agent has taken the node");
                    tracing::error!("{}", chain(&e));
                    let _ = lose.send(e);
                    return;
                }
                adopt_round(&agent).await;
                // Not at once: a manager makes its folder anew when somebody removed it.
                if ticks % ORPHANS == ORPHANS / 10 {
                    bury_orphans(&agent).await;
                }
                ticks = ticks.wrapping_add(1);
            }
        }
        agent.observe().await;
        sleep(QUICK).await;
    }
}

/// Makes anew what somebody has removed of the node's folders; an error when another agent has the node by now.
fn keep_folders(agent: &Agent, lock: &mut NodeLock) -> Result<(), StartError> {
    let made = agent.folders.make().map_err(StartError::from);
    match made.and_then(|()| lock.keep()) {
        Ok(()) => {}
        Err(e @ StartError::Running { .. }) => return Err(e),
        // It may do better the next time.
        Err(e) => tracing::warn!("{}", chain(&e)),
    }
    if !description(agent).exists()
        && let Err(e) = describe(agent)
    {
        tracing::warn!("{}", chain(&e));
    }
    Ok(())
}

/// Describes the process beside its socket.
fn describe(agent: &Agent) -> Result<(), StartError> {
    let path = description(agent);
    let own = Identity::own(env!("CARGO_PKG_VERSION"));
    serde_json::to_vec(&own)
        .map_err(io::Error::from)
        .and_then(|text| files::replace(&path, &text))
        .map_err(in_file(&path))
}

fn description(agent: &Agent) -> PathBuf {
    agent.folders.run.join("agent.json")
}

fn in_file(path: &Path) -> impl FnOnce(io::Error) -> StartError {
    let path = path.to_owned();
    move |source| StartError::File { path, source }
}
