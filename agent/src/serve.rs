//! An agent of this computer, which serves its API on a socket.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use rts_agent_api::session::{ANSWERED_WITHIN, SessionApi, SessionClient};
use rts_host::clock::{SystemChance, SystemClock};
use rts_host::disk::FileDisk;
use rts_http::client::Client;
use rts_http::server::serve_at;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::timeout;

use crate::agent::StartError;
use crate::api;
use crate::config::Config;
use crate::inputs::Inputs;
use crate::machine::{Host, Pull};
use crate::peers::HomePeers;
use crate::start::{Running, begin, prepare};

/// How long open requests may take when the agent ends.
const LAST_REQUESTS: Duration = Duration::from_secs(1);

/// An agent that serves. Dropping it leaves its socket behind; use [`Serving::stop`].
pub struct Serving {
    running: Running,
    taken: Taken,
    socket: PathBuf,
    server: JoinHandle<io::Result<()>>,
    stop: oneshot::Sender<()>,
}

/// A node that is given back in the end, although links to its managers live on.
struct Taken(Arc<Host>);

impl Drop for Taken {
    fn drop(&mut self) {
        self.0.release();
    }
}

/// Starts an agent of this computer within the present runtime; it serves when this returns.
pub async fn serve(config: Config) -> Result<Serving, StartError> {
    serve_with(config, None).await
}

/// The same, with somebody from whom modules can be had.
pub(crate) async fn serve_with(config: Config, pull: Option<Pull>) -> Result<Serving, StartError> {
    let taken = Taken(Arc::new(Host::take(&config, pull).await?));
    let inputs = Inputs {
        clock: Arc::new(SystemClock),
        chance: Arc::new(SystemChance),
        disk: Arc::new(FileDisk),
        machine: taken.0.clone(),
        controller: controller(&config)?,
        peers: Arc::new(HomePeers::new(&config.home)),
    };
    let agent = prepare(config, inputs).await?;
    let (stop, stopped) = oneshot::channel();
    let socket = agent.folders.agent_socket();
    let stopped = async {
        let _ = stopped.await;
    };
    let server =
        serve_at(&socket, api::router(agent.clone()), stopped).map_err(in_file(&socket))?;
    let server = tokio::spawn(server);
    taken.0.describe_self()?;
    Ok(Serving {
        running: begin(agent),
        taken,
        socket,
        server,
        stop,
    })
}

impl Serving {
    /// The socket on which it serves.
    pub fn socket(&self) -> &Path {
        &self.socket
    }

    /// Waits until another agent has taken the node: this one must end, and has stopped healing.
    pub async fn lost(&mut self) -> StartError {
        self.running.lost().await
    }

    /// Ends it. Managers go on.
    pub async fn stop(mut self) {
        self.running.stop().await;
        self.taken.0.forget_self();
        // The socket is removed by the server.
        let _ = self.stop.send(());
        if timeout(LAST_REQUESTS, &mut self.server).await.is_err() {
            // Streams of batches that run.
            self.server.abort();
        }
    }
}

/// The controller, behind its socket; none when there is to be none.
fn controller(config: &Config) -> Result<Option<Arc<dyn SessionApi>>, StartError> {
    let Some(socket) = &config.controller_socket else {
        return Ok(None);
    };
    let http = Client::unix(socket, ANSWERED_WITHIN).map_err(StartError::Client)?;
    Ok(Some(Arc::new(SessionClient::new(http, &config.node))))
}

fn in_file(path: &Path) -> impl FnOnce(io::Error) -> StartError {
    let path = path.to_owned();
    move |source| StartError::File { path, source }
}
