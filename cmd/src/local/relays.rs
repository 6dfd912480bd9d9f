//! Nodes that are reached by SSH: the relay of each is started when a command needs it, and held awake until the command ends.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Stdio;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use futures_util::future::join_all;
use rts_controller_api::objects::{Component, Kind};
use rts_host::files;
use rts_relay::State;
use serde::Deserialize;
use tokio::io::{AsyncBufReadExt, AsyncReadExt, BufReader};
use tokio::net::UnixStream;
use tokio::process::Command;

use super::home::Home;
use super::nodes::{NodeSetup, Nodes};
use super::up::{agents, beside, module_path, open_log};
use super::{LocalError, plural};
use crate::error::CliError;
use crate::exit::Exit;
use crate::output::Output;
use crate::session::Session;

/// Longest wait for a relay: it logs in, and the first time copies programs.
const READY: Duration = Duration::from_secs(300);
/// Longest wait for a session that is being opened again, or for the state of one.
const STATE: Duration = Duration::from_secs(130);
/// Longest line of a relay in bytes.
const MAX_LINE: u64 = 64 * 1024;
/// Time between two looks.
const PAUSE: Duration = Duration::from_millis(20);

/// Sockets of the relays that this process holds awake.
static HELD: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// What came of reaching the nodes of a home.
pub(super) struct Reached {
    /// One was not awake before.
    pub woken: bool,
    /// Those that are reached, and all others of the home.
    pub nodes: Nodes,
}

/// Reaches all nodes of a home that are reached by SSH, beside each other. One of the `wanted` must be reached; of others that are not, it is
/// told, and the controller says what that means.
pub(super) async fn wake_all(
    session: &Session,
    nodes: &Nodes,
    wanted: &[NodeSetup],
    path: Option<&OsString>,
) -> Result<Reached, LocalError> {
    let all = nodes.by_ssh();
    let reaching = all.map(|node| async move { (node, wake(session, node, path).await) });
    let mut reached = Reached {
        woken: false,
        nodes: nodes.clone(),
    };
    for (node, woken) in join_all(reaching).await {
        match woken {
            Ok(new) => reached.woken |= new,
            Err(e) if wanted.iter().any(|wanted| wanted.name == node.name) => return Err(e),
            Err(e) => {
                session
                    .out
                    .warn(&format!("{e}; what is shown of it was seen last"));
                if let Some(help) = e.help() {
                    session.out.say(&format!("  help: {help}"));
                }
                reached.nodes = reached.nodes.without(&node.name);
            }
        }
    }
    Ok(reached)
}

/// Reaches the nodes of a session's home for a command that only looks, or changes what runs: a node that is not reached is
/// told, and the rest is shown.
pub async fn wake_for(session: &Session) -> Result<(), CliError> {
    let nodes = Nodes::of(&session.home)?;
    if nodes.by_ssh().next().is_none() {
        return Ok(());
    }
    let path = module_path(None);
    let mut reached = wake_all(session, &nodes, &[], path.as_ref()).await?;
    for node in nodes.all().iter().filter(|node| node.ssh.is_none()) {
        reached.nodes = reached.nodes.without(&node.name);
    }
    if reached.woken && reached.nodes.by_ssh().next().is_some() {
        agents::wait_for(session, &reached.nodes, &[]).await?;
    }
    Ok(())
}

/// Holds the relay of a node awake until this process ends; it is started if need be. True when it was.
async fn wake(
    session: &Session,
    node: &NodeSetup,
    path: Option<&OsString>,
) -> Result<bool, LocalError> {
    let home = &session.home;
    let socket = home.relay_socket(&node.name);
    if held().contains(&socket) {
        return Ok(false);
    }
    let mut started = false;
    let end = Instant::now() + STATE;
    loop {
        if let Some((resident, lease)) = hold(home, node, session.out).await? {
            tokio::spawn(lease);
            held().insert(socket);
            if !resident {
                session.out.say(&format!(
                    "rtsctl: node {} is reached by SSH: between commands nothing there is healed",
                    node.name
                ));
            }
            return Ok(started);
        }
        if Instant::now() >= end {
            return Err(failed(
                home,
                &node.name,
                "its relay ends again and again".to_owned(),
            ));
        }
        // One process at a time starts it.
        super::lock::make_folders(home, &node.name)?;
        let run = home.node_run(&node.name);
        super::home::make_private(&run)?;
        let lock = run.join("relay.start");
        match files::lock(&lock).map_err(LocalError::file("lock", &lock))? {
            Some(_lock) if !socket.exists() || !answers(&socket).await => {
                start(session, node, path).await?;
                started = true;
            }
            _ => tokio::time::sleep(PAUSE).await,
        }
    }
}

fn held() -> std::sync::MutexGuard<'static, BTreeSet<PathBuf>> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

async fn answers(socket: &PathBuf) -> bool {
    UnixStream::connect(socket).await.is_ok()
}

/// Connects to a relay, and waits until the node is reached: what is left to do is to hold the connection, and to tell what
/// happens to the session. None when no relay runs.
async fn hold(
    home: &Home,
    node: &NodeSetup,
    out: Output,
) -> Result<Option<(bool, impl Future<Output = ()> + Send + 'static)>, LocalError> {
    let Ok(stream) = UnixStream::connect(home.relay_socket(&node.name)).await else {
        return Ok(None);
    };
    let mut states = States(BufReader::new(stream));
    let up = async {
        loop {
            match states.next().await {
                Some(State::Up { resident }) => return Ok(Some(resident)),
                Some(State::Lost { .. }) => {}
                Some(State::Failed { reason, help, exit }) => {
                    return Err(LocalError::Relay {
                        node: node.name.clone(),
                        reason,
                        help,
                        exit: Exit::of_code(exit),
                        log: home.agent_log(&node.name),
                    });
                }
                // It was just ending.
                None => return Ok(None),
            }
        }
    };
    let up = match tokio::time::timeout(STATE, up).await {
        Ok(up) => up?,
        Err(_) => {
            let reason = format!("its relay did not reach it within {} s", STATE.as_secs());
            return Err(failed(home, &node.name, reason));
        }
    };
    let name = node.name.clone();
    let Some(resident) = up else {
        return Ok(None);
    };
    let lease = async move {
        while let Some(state) = states.next().await {
            match state {
                State::Up { .. } => out.say(&format!("rtsctl: node {name} is reached again")),
                State::Lost { reason } => out.warn(&format!(
                    "the connection with node {name} was lost ({reason}); trying again"
                )),
                State::Failed { reason, .. } => {
                    out.warn(&format!("node {name} is not reached any more: {reason}"));
                }
            }
        }
    };
    Ok(Some((resident, lease)))
}

/// The lines of a relay.
struct States(BufReader<UnixStream>);

impl States {
    async fn next(&mut self) -> Option<State> {
        let mut line = Vec::new();
        let mut bounded = (&mut self.0).take(MAX_LINE);
        bounded.read_until(b'\n', &mut line).await.ok()?;
        serde_json::from_slice(&line).ok()
    }
}

/// The one line that a relay prints.
#[derive(Deserialize)]
struct Readiness {
    ready: bool,
    #[serde(default)]
    error: Option<String>,
    #[serde(default)]
    help: Option<String>,
    #[serde(default)]
    exit: Option<u8>,
}

/// Starts a relay in a process group of its own, and waits until it has reached the node.
async fn start(
    session: &Session,
    node: &NodeSetup,
    path: Option<&OsString>,
) -> Result<(), LocalError> {
    let home = &session.home;
    let Some(ssh) = &node.ssh else {
        return Err(failed(
            home,
            &node.name,
            "it is not reached by SSH".to_owned(),
        ));
    };
    let say = format!(
        "rtsctl: reaching node {} ({}) by SSH",
        node.name, ssh.destination
    );
    session.out.detail(&say);
    let program = beside("rts-relay")?;
    let mut command = Command::new(&program);
    command.arg("--home").arg(home.path());
    command.arg("--node").arg(&node.name);
    if let Some(path) = path {
        command.env("RTSCTL_MODULE_PATH", path);
    }
    let log = home.agent_log(&node.name);
    let mut child = command
        .current_dir("/")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(open_log(&log)?)
        .process_group(0)
        .spawn()
        .map_err(|source| LocalError::Spawn { program, source })?;
    let mut line = String::new();
    if let Some(stdout) = child.stdout.take() {
        let mut reader = BufReader::new(stdout.take(MAX_LINE));
        if tokio::time::timeout(READY, reader.read_line(&mut line))
            .await
            .is_err()
        {
            let _ = child.start_kill();
            let reason = format!("it was not reached within {} s", READY.as_secs());
            return Err(failed(home, &node.name, reason));
        }
    }
    match serde_json::from_str::<Readiness>(&line) {
        Ok(Readiness { ready: true, .. }) => Ok(()),
        Ok(said) => Err(LocalError::Relay {
            node: node.name.clone(),
            reason: said
                .error
                .unwrap_or_else(|| "its relay gave no reason".to_owned()),
            help: said.help,
            exit: said.exit.map_or(Exit::Unreachable, Exit::of_code),
            log,
        }),
        Err(_) => Err(failed(home, &node.name, format!("its relay said {line:?}"))),
    }
}

fn failed(home: &Home, node: &str, reason: String) -> LocalError {
    LocalError::Relay {
        node: node.to_owned(),
        reason,
        help: None,
        exit: Exit::Unreachable,
        log: home.agent_log(node),
    }
}

/// Ends the relay of a node, if it has one.
pub fn stop(home: &Home, node: &str) {
    use rts_host::{identity::Identity, process::Process};
    let description = home.node_run(node).join("relay.json");
    if let Some(process) = Identity::read(&description).and_then(|i| Process::identified(&i)) {
        process.signal(rustix::process::Signal::TERM);
        process.ended(Duration::from_secs(5));
    }
}

/// What runs on nodes that are reached by SSH, as the controller knows it: `hello (3 components on node arm)`.
pub async fn systems(session: &Session) -> Vec<String> {
    let by_ssh: BTreeSet<String> = match Nodes::of(&session.home) {
        Ok(nodes) => nodes.by_ssh().map(|node| node.name.clone()).collect(),
        Err(_) => return Vec::new(),
    };
    let asked = async {
        if by_ssh.is_empty() || !session.local_answers().await.ok()? {
            return None;
        }
        let list = session
            .local(STATE)
            .ok()?
            .list::<Component>(Kind::Component)
            .await;
        Some(list.ok()?.items)
    };
    let mut found: BTreeMap<(String, String), usize> = BTreeMap::new();
    for component in asked.await.unwrap_or_default() {
        if by_ssh.contains(&component.status.node) {
            let key = (component.spec.system, component.status.node);
            *found.entry(key).or_default() += 1;
        }
    }
    let words = |((system, node), count)| {
        format!("{system} ({} on node {node})", plural("component", count))
    };
    found.into_iter().map(words).collect()
}
