//! The agents of a home: which do not run, their start, and the wait until the controller has met them.

use std::ffi::OsString;
use std::time::{Duration, Instant};

use rts_controller_api::objects::{Kind, Node};
use tokio::process::Command;

use super::{NODE_READY, PAUSE, READY, beside, start};
use crate::error::CliError;
use crate::local::LocalError;
use crate::local::home::Home;
use crate::local::lock::is_held;
use crate::local::nodes::{NodeSetup, Nodes};
use crate::local::relays;
use crate::local::restore::stop_agent;
use crate::local::strays::{self, Program};
use crate::session::Session;

/// Time until the first look at what was just started.
const SOON: Duration = Duration::from_millis(1);

/// Those to start: who does not run, and who runs and does not know its hosts, after it was ended. Managers go on.
pub(super) async fn to_start<'a>(
    home: &Home,
    nodes: &'a Nodes,
    before: &Nodes,
) -> Result<Vec<&'a NodeSetup>, LocalError> {
    let mut missing = Vec::new();
    for node in nodes.all().iter().filter(|node| node.ssh.is_none()) {
        let lives = lives(home, &node.name).await?;
        if lives && node.hosts() != before.hosts_of(&node.name) {
            stop_agent(home, &node.name)?;
        } else if lives {
            continue;
        }
        missing.push(node);
    }
    Ok(missing)
}

/// Starts an agent.
pub(super) async fn start_agent(
    home: &Home,
    node: &NodeSetup,
    module_path: Option<&OsString>,
) -> Result<(), LocalError> {
    let mut command = Command::new(beside("rts-agent")?);
    command.arg("--home").arg(home.path());
    command.arg("--node").arg(&node.name);
    command.arg("--controller").arg(home.controller_socket());
    // What a component starts can be told to be of this home, wherever it goes.
    command.env("RTSCTL_HOME", home.path());
    for host in node.hosts() {
        command.arg("--alias").arg(host);
    }
    if let Some(path) = module_path {
        command.env("RTSCTL_MODULE_PATH", path);
    }
    start("rts-agent", command, &home.agent_log(&node.name)).await
}

/// True when the agent holds its lock, which it may only be about to; false when none lives.
pub(super) async fn lives(home: &Home, node: &str) -> Result<bool, LocalError> {
    let lock = home.agent_lock(node);
    let end = Instant::now() + READY;
    while !is_held(&lock)? {
        let strays = strays::find(home, Program::Agent);
        if !strays.iter().any(|agent| agent.name == node) {
            return Ok(false);
        }
        if Instant::now() >= end {
            return Err(LocalError::NotReady {
                program: "rts-agent",
                reason: format!(
                    "it runs but does not hold {}; `rtsctl down` stops it",
                    lock.display()
                ),
                log: home.agent_log(node),
            });
        }
        tokio::time::sleep(PAUSE).await;
    }
    Ok(true)
}

/// Waits until the controller has met all agents, those that were started by the hosts that they have now. Of one that is reached by
/// SSH and is none of the `wanted`, it is only told when it does not come.
pub(in crate::local) async fn wait_for(
    session: &Session,
    nodes: &Nodes,
    started: &[String],
    wanted: &[NodeSetup],
) -> Result<(), CliError> {
    let controller = session.local(READY)?;
    let mut open: Vec<_> = nodes.all().iter().collect();
    let end = Instant::now() + NODE_READY;
    let mut pause = SOON;
    loop {
        let list = controller.list::<Node>(Kind::Node).await;
        let found = list.as_ref().map(|list| list.items.as_slice());
        let found = found.map_err(ToString::to_string);
        let late = Instant::now() >= end;
        let mut reasons = Vec::new();
        open.retain(|node| {
            let reason = match &found {
                Ok(items) => missing(session, node, items, started.contains(&node.name)),
                Err(e) => Some(e.clone()),
            };
            let Some(reason) = reason else { return false };
            let waits = !is_left(node, wanted, late);
            match waits {
                true => reasons.push(reason),
                false => session.out.warn(&reason),
            }
            waits
        });
        if open.is_empty() {
            return Ok(());
        }
        let names: Vec<String> = open.iter().map(|node| node.name.clone()).collect();
        if let Some(given_up) = relays::given_up(&names) {
            return Err(given_up.into());
        }
        // A session that was lost is made anew, or given up.
        let mut waited = names.iter().zip(reasons);
        if let Some((node, reason)) = waited.find(|(node, _)| late && !relays::is_away(node)) {
            return Err(LocalError::NotReady {
                program: "rts-agent",
                reason,
                log: session.home.agent_log(node),
            }
            .into());
        }
        tokio::time::sleep(pause).await;
        pause = (pause * 2).min(PAUSE);
    }
}

/// True for a node that is reached by SSH, that the command is not about, and that is not met in time or not reached any more.
fn is_left(node: &NodeSetup, wanted: &[NodeSetup], late: bool) -> bool {
    let about = wanted.iter().any(|wanted| wanted.name == node.name);
    node.ssh.is_some() && !about && (late || relays::is_away(&node.name))
}

/// Why a node is waited for; none when it is up, though it may wait for a word of the user, which is said.
fn missing(session: &Session, setup: &NodeSetup, nodes: &[Node], new: bool) -> Option<String> {
    let name = &setup.name;
    let Some(node) = nodes.iter().find(|n| n.metadata.name == *name) else {
        return Some(format!("node {name} has not reported to the controller"));
    };
    let status = &node.status;
    if new && node.spec.aliases != setup.hosts() {
        return Some(format!("node {name} has not greeted the controller anew"));
    }
    if status.state == "Ready" {
        return None;
    }
    if status.ledger.is_some() {
        let why = status.message.as_deref().unwrap_or(&status.state);
        session.out.warn(why);
        return None;
    }
    let why = status.message.as_deref().unwrap_or_default();
    Some(format!("node {name} is {} {why}", status.state))
}
