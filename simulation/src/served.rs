//! Real agents over simulated machines and disks, in real time, behind real sockets: a fleet for a real controller that
//! costs no process per manager. Several nodes share this process.

use std::fs::DirBuilder;
use std::io;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use rts_agent::peers::HomePeers;
use rts_agent::{Config, Inputs, Running, StartError};
use rts_agent_api::session::{ANSWERED_WITHIN, SessionClient};
use rts_host::clock::{SystemChance, SystemClock};
use rts_http::client::{Client, ClientError};
use rts_http::server::serve_at;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::{Instant, timeout};

use crate::clock::SimClock;
use crate::disk::SimDisk;
use crate::life::Life;
use crate::machine::SimMachine;
use crate::modules::SimModule;
use crate::seed::Seed;
use crate::truth::Truth;

/// Type of the one module that every node has: an in-port, an out-port and a parameter.
pub const TYPE: &str = "Part";
/// How long open requests may take in the end.
const LAST_REQUESTS: Duration = Duration::from_secs(1);

/// Which nodes, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Served {
    /// `RTSCTL_HOME`: sockets are made in its `run/`, and the controller's is expected there.
    pub home: PathBuf,
    /// Number of the first node; `n7` is its name.
    pub first: u32,
    /// How many.
    pub count: u32,
}

/// Agents that cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The runtime, a folder or a socket.
    #[error("cannot {what}")]
    Io {
        /// What was tried.
        what: String,
        /// Why not.
        source: io::Error,
    },
    /// An agent.
    #[error("the agent of node {node} does not start")]
    Agent {
        /// Its node.
        node: String,
        /// Why not.
        source: Box<StartError>,
    },
    /// The client of the controller.
    #[error("cannot make a client of the controller")]
    Client(#[from] ClientError),
}

/// An agent that serves.
struct Serving {
    running: Running,
    server: JoinHandle<io::Result<()>>,
    stop: oneshot::Sender<()>,
}

/// Serves until standard input is closed. `ready` is called when all sockets are there.
pub fn serve(served: &Served, ready: impl FnOnce()) -> Result<(), ServeError> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(failed("make the event loop"))?;
    let done = runtime.block_on(async {
        let (seed, truth) = (Seed(served.first.into()), Truth::new());
        let mut agents = Vec::new();
        for number in served.first..served.first.saturating_add(served.count) {
            let node = format!("n{number}");
            agents.push(start(&served.home, &node, seed, truth.clone()).await?);
        }
        ready();
        closed().await;
        for agent in agents {
            agent.stop().await;
        }
        Ok(())
    });
    runtime.shutdown_background();
    done
}

async fn start(home: &Path, node: &str, seed: Seed, truth: Truth) -> Result<Serving, ServeError> {
    let run = home.join("run").join(node);
    let made = DirBuilder::new().recursive(true).mode(0o700).create(&run);
    made.map_err(failed(&format!("make {}", run.display())))?;
    let machine = SimMachine::new(node, seed, SimClock::new(Instant::now()), truth);
    // What a process starts of its own is of no interest here.
    machine.grandchildren(0.0);
    let part = SimModule::new(TYPE)
        .port("in", "in", "TimedDouble")
        .port("out", "out", "TimedDouble")
        .parameter("gain", "1.0");
    machine.install(part);
    let life = Life::new(node, 1);
    let controller = Client::unix(home.join("run/controller.sock"), ANSWERED_WITHIN)?;
    let inputs = Inputs {
        clock: Arc::new(SystemClock),
        chance: Arc::new(SystemChance),
        disk: SimDisk::new(node, seed).grip(life.clone()),
        machine: machine.grip(life),
        controller: Some(Arc::new(SessionClient::new(controller, node))),
        peers: Arc::new(HomePeers::new(home)),
    };
    let config = Config {
        home: home.to_owned(),
        node: node.to_owned(),
        aliases: Vec::new(),
        module_path: Vec::new(),
        manager_program: PathBuf::from("rts-manager"),
        controller_socket: None,
        heal_after: Some(Config::HEAL_AFTER),
        idle_managers: None,
    };
    let running = rts_agent::start(config, inputs).await;
    let running = running.map_err(|source| ServeError::Agent {
        node: node.to_owned(),
        source: Box::new(source),
    })?;
    let socket = run.join("agent.sock");
    let (stop, stopped) = oneshot::channel();
    let stopped = async {
        let _ = stopped.await;
    };
    let server = serve_at(&socket, running.api().router(), stopped);
    let server = server.map_err(failed(&format!("bind {}", socket.display())))?;
    Ok(Serving {
        running,
        server: tokio::spawn(server),
        stop,
    })
}

impl Serving {
    async fn stop(mut self) {
        self.running.stop().await;
        let _ = self.stop.send(());
        if timeout(LAST_REQUESTS, &mut self.server).await.is_err() {
            self.server.abort();
        }
    }
}

/// Waits until whoever started this has closed standard input, or has ended.
async fn closed() {
    let read = || io::copy(&mut io::stdin().lock(), &mut io::sink());
    // What is read, and how reading fails, does not matter.
    let _ = tokio::task::spawn_blocking(read).await;
}

fn failed(what: &str) -> impl FnOnce(io::Error) -> ServeError {
    let what = what.to_owned();
    move |source| ServeError::Io { what, source }
}
