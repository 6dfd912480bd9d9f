//! The program of an agent: it serves until a signal ends it.

use std::io::{self, Write};

use rts_host::error::chain;
use rts_host::memory;
use tokio::signal::unix::{SignalKind, signal};

use crate::agent::StartError;
use crate::api;
use crate::config::Config;
use crate::serve::serve;

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

/// The description of the HTTP API, as JSON text.
pub fn openapi() -> String {
    // A document that was just built can be written.
    api::openapi().to_pretty_json().unwrap_or_default()
}

/// Runs an agent until SIGTERM or SIGINT. Prints one line of JSON when it serves, or why it does not.
pub fn run(config: Config) -> Result<(), RunError> {
    memory::few_heaps();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    rts_host::limits::raise_open_files();
    let result = runtime.block_on(async {
        let mut term = signal(SignalKind::terminate())?;
        let mut interrupt = signal(SignalKind::interrupt())?;
        let mut serving = serve(config).await?;
        announce(&serde_json::json!({ "ready": true }));
        tokio::spawn(memory::keep_small());
        let ended = tokio::select! {
            _ = term.recv() => Ok(()),
            _ = interrupt.recv() => Ok(()),
            taken = serving.lost() => Err(RunError::Taken(taken)),
        };
        tracing::info!("stopping; managers go on");
        serving.stop().await;
        ended
    });
    // A blocking task, such as hashing a module, must not hold up the end.
    runtime.shutdown_background();
    if let Err(e @ RunError::Start(_)) = &result {
        announce(&serde_json::json!({ "ready": false, "error": chain(e) }));
    }
    result
}

fn announce(line: &serde_json::Value) {
    // Whoever started us may be gone already.
    let _ = writeln!(io::stdout().lock(), "{line}");
}
