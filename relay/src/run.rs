//! The program of a relay.

use std::io::{self, Write};
use std::path::Path;
use std::time::Duration;

use rts_host::error::chain;
use rts_host::files;
use rts_host::identity::Identity;
use rts_http::server::bind;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;
use tokio::time::{Instant, sleep};

use crate::awake::{Commands, State, serve};
use crate::config::Config;
use crate::life::{give_up, live};
use crate::link::{Now, serve_agent};
use crate::reach::{ReachError, reach_first};

/// How long the relay before may take to end.
const PATIENCE: Duration = Duration::from_secs(5);
/// Exit code of a command that needs the node.
const UNREACHABLE: u8 = 4;
/// Between two tries for its lock.
const PAUSE: Duration = Duration::from_millis(20);

/// A relay that failed.
#[derive(Debug, thiserror::Error)]
enum RunError {
    #[error(transparent)]
    Reach(#[from] ReachError),
    #[error("another relay of node {0} runs already")]
    Running(String),
    #[error("cannot use {path}")]
    File { path: String, source: io::Error },
    #[error("the relay failed")]
    Io(#[from] io::Error),
}

/// Runs a relay until nobody needs it, or SIGTERM or SIGINT. Prints one line of JSON when the node is reached, or why it is not.
/// True when it served.
pub fn run(config: &Config) -> bool {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    let result = match runtime {
        Ok(runtime) => {
            let result = runtime.block_on(serve_node(config));
            runtime.shutdown_background();
            result
        }
        Err(e) => Err(e.into()),
    };
    match result {
        Ok(()) => true,
        Err(e) => {
            let error = chain(&e);
            tracing::error!("{error}");
            let (help, exit) = match &e {
                RunError::Reach(e) => (e.help(), Some(e.exit())),
                _ => (None, None),
            };
            say(&serde_json::json!({ "ready": false, "error": error, "help": help, "exit": exit }));
            false
        }
    }
}

async fn serve_node(config: &Config) -> Result<(), RunError> {
    let mut term = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    let run = config.home.join("run").join(&config.node);
    files::private_folder(&run).map_err(in_file(&run))?;
    let _lock = lock(config).await?;
    let description = config.description();
    let own = serde_json::to_vec(&Identity::own(env!("CARGO_PKG_VERSION")));
    let written = own
        .map_err(io::Error::from)
        .and_then(|own| files::replace(&description, &own));
    written.map_err(in_file(&description))?;
    let served = async {
        let first = tokio::select! {
            first = reach_first(config) => first?,
            _ = term.recv() => return Ok(()),
            _ = interrupt.recv() => return Ok(()),
        };
        let (agent, relay) = (config.agent_socket(), config.relay_socket());
        let agents = bind(&agent).map_err(in_file(&agent))?;
        let waiting = bind(&relay).map_err(in_file(&relay))?;
        let (now, commands) = (Now::default(), Commands::new());
        let (state, told) = watch::channel(State::Lost {
            reason: "it is just being reached".to_owned(),
        });
        tracing::info!(node = config.node, "reached {}", config.destination);
        say(&serde_json::json!({ "ready": true }));
        let life = async {
            tokio::select! {
                () = live(config, first, &now, &commands, &state) => return,
                _ = term.recv() => {}
                _ = interrupt.recv() => {}
            }
            tracing::info!("told to end");
            // Whoever holds it awake must not take it for one that was killed, and start another.
            if *commands.count().borrow() > 0 {
                let reason = "its relay on this machine was told to end".to_owned();
                give_up(&state, reason, None, UNREACHABLE).await;
            }
        };
        tokio::select! {
            () = life => {}
            () = serve_agent(agents, &now) => {}
            () = serve(waiting, commands.clone(), told) => {}
        }
        Ok(())
    };
    let served = served.await;
    for path in [config.agent_socket(), config.relay_socket(), description] {
        let _ = std::fs::remove_file(path);
    }
    served
}

/// One relay a node. The one before may just be ending.
async fn lock(config: &Config) -> Result<files::Lock, RunError> {
    let path = config.lock();
    let end = Instant::now() + PATIENCE;
    loop {
        if let Some(lock) = files::lock(&path).map_err(in_file(&path))? {
            return Ok(lock);
        }
        if Instant::now() >= end {
            return Err(RunError::Running(config.node.clone()));
        }
        sleep(PAUSE).await;
    }
}

fn in_file(path: &Path) -> impl FnOnce(io::Error) -> RunError {
    let path = path.display().to_string();
    move |source| RunError::File { path, source }
}

/// Whoever started us may be gone already.
fn say(line: &serde_json::Value) {
    let mut out = io::stdout().lock();
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}
