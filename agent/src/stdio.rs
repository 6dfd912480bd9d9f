//! An agent that lives as long as the connection by which its machine is reached: it serves over its standard input and output.
//!
//! It is the same agent, with the same ledger and the same run folder: it serves its socket `run/<node>/agent.sock`, and
//! streams of the near side are joined to that. Its controller is `run/<node>/controller.sock`, whose connections are
//! joined to streams towards near. Where an agent lives on its own and keeps the node, this process only joins streams.

mod pipes;
mod seat;

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rts_bridge::{Kind, Link, LinkError, Opener, join, pulse};
use rts_host::error::chain;
use rts_http::server::bind;
use tokio::io::copy_bidirectional;
use tokio::net::{UnixListener, UnixStream};
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;
use tokio::task::JoinSet;

use crate::agent::StartError;
use crate::config::Config;
use crate::folders::Folders;
use seat::Seat;

/// Pause after a connection could not be accepted (no file descriptor is left).
const PAUSE: Duration = Duration::from_millis(100);

/// An agent that failed.
#[derive(Debug, thiserror::Error)]
pub enum StdioError {
    /// It did not start.
    #[error(transparent)]
    Start(#[from] StartError),
    /// There was no connection.
    #[error("there is no connection with whoever started this program")]
    Link(#[from] LinkError),
    /// The runtime, a signal or a pipe failed.
    #[error("the agent failed")]
    Io(#[from] io::Error),
}

/// Runs an agent over standard input and output until they are closed. What it has to tell goes to standard error.
pub fn run_stdio(config: Config) -> Result<(), StdioError> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    rts_host::limits::raise_open_files();
    let result = runtime.block_on(serve(config));
    // A blocking task, such as hashing a module, must not hold up the end.
    runtime.shutdown_background();
    result
}

async fn serve(config: Config) -> Result<(), StdioError> {
    let (from, to) = pipes::own()?;
    let far = rts_bridge::far(from, to, env!("CARGO_PKG_VERSION")).await?;
    let (seat, listener) = match take(config).await {
        Ok(taken) => taken,
        Err(e) => {
            far.fails(chain(&e)).await?;
            return Err(e.into());
        }
    };
    let link = far.serves(seat.is_resident()).await?;
    let result = keep(&seat, link, listener).await;
    tracing::info!("stopping; managers go on");
    seat.leave().await;
    result
}

/// Takes the node, and the socket on which its agent finds the controller.
async fn take(config: Config) -> Result<(Seat, UnixListener), StartError> {
    let folders = Folders::new(&config.home, &config.node)?;
    folders.make()?;
    let seat = Seat::take(config, &folders).await?;
    let path = folders.controller_socket();
    match bind(&path) {
        Ok(listener) => Ok((seat, listener)),
        Err(source) => {
            seat.leave().await;
            Err(StartError::File { path, source })
        }
    }
}

/// Joins streams until the connection ends, or somebody ends this process.
async fn keep(seat: &Seat, mut link: Link, listener: UnixListener) -> Result<(), StdioError> {
    let mut term = signal(SignalKind::terminate())?;
    let mut interrupt = signal(SignalKind::interrupt())?;
    seat.connected(&link.opener);
    let (tell, told) = watch::channel(false);
    let (mut streams, mut pulses) = (JoinSet::new(), JoinSet::new());
    streams.spawn(towards_near(listener, link.opener.clone()));
    let first_sign = tokio::time::sleep(pulse::PATIENCE);
    tokio::pin!(first_sign);
    let mut seen = false;
    loop {
        tokio::select! {
            stream = link.incoming.next() => match stream {
                Some(mut stream) => {
                    let (socket, mut told) = (seat.agent_socket().to_owned(), told.clone());
                    // What a stream is for is said at once by whoever opens it.
                    match Kind::read(&mut stream).await {
                        Some(Kind::Agent) => drop(streams.spawn(towards_agent(stream, socket))),
                        Some(Kind::Pulse) if pulses.is_empty() => {
                            seen = true;
                            let told = async move { drop(told.wait_for(|told| *told).await) };
                            pulses.spawn(pulse::far(stream, told));
                        }
                        _ => {}
                    }
                }
                None => {
                    tracing::info!("the connection has ended: {}", link.ended().await);
                    return Ok(());
                }
            },
            Some(_) = pulses.join_next() => {
                tracing::info!("the connection carries nothing any more");
                return Ok(());
            }
            () = &mut first_sign, if !seen => {
                tracing::info!("the near side gives no sign of life");
                return Ok(());
            }
            _ = term.recv() => break,
            _ = interrupt.recv() => break,
            Some(_) = streams.join_next() => {}
        }
    }
    // Near is told, so that it does not come again at once.
    tell.send_replace(true);
    let _ = tokio::time::timeout(pulse::EVERY, pulses.join_next()).await;
    Ok(())
}

/// Joins a stream of near to the agent.
async fn towards_agent(stream: rts_bridge::Stream, socket: PathBuf) {
    if let Err(e) = join(stream, &socket).await {
        tracing::debug!("a stream to the agent has failed: {e}");
    }
}

/// Joins what the agent tells its controller to streams towards near.
async fn towards_near(listener: UnixListener, near: Opener) {
    let mut joined = JoinSet::new();
    loop {
        tokio::select! {
            accepted = listener.accept() => match accepted {
                Ok((socket, _)) => drop(joined.spawn(to_controller(socket, near.clone()))),
                Err(e) => {
                    tracing::warn!("cannot accept a connection to the controller: {e}");
                    tokio::time::sleep(PAUSE).await;
                }
            },
            Some(_) = joined.join_next() => {}
        }
    }
}

async fn to_controller(mut socket: UnixStream, near: Opener) {
    if let Ok(mut stream) = near.open(Kind::Controller).await
        && let Err(e) = copy_bidirectional(&mut socket, &mut stream).await
    {
        tracing::debug!("a stream to the controller has failed: {e}");
    }
}

/// The socket of a node's controller where it is reached by a connection.
pub(crate) fn controller_socket(run: &Path) -> PathBuf {
    run.join("controller.sock")
}
