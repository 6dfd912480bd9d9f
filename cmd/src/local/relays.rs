//! Nodes that are reached by SSH: the relay of each is started when a command needs it, and held awake until the command ends.

mod standing;
mod wake;

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::time::Duration;

use futures_util::future::join_all;
use rts_controller_api::objects::{Component, Kind};

use self::standing::holds;
pub use self::standing::{
    Patience, away, because, despite_loss, given_up, is_away, needed, on_demand,
};
use self::wake::Waker;
use super::home::Home;
use super::nodes::{NodeSetup, Nodes};
use super::up::{agents, beside, module_path};
use super::{LocalError, plural};
use crate::error::CliError;
use crate::session::Session;

/// Longest wait for a session that is being opened again of a node that a command is about.
const SESSION: Duration = Duration::from_secs(130);
/// The same of any other node: what needs it waits until the deadline of its command.
const LOOK: Duration = Duration::from_secs(3);
/// Longest wait for what the controller knows.
const ASK: Duration = Duration::from_secs(10);
/// Longest orderly end of a relay, and of one that was killed.
const END: Duration = Duration::from_secs(5);

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
    let is_wanted = |node: &NodeSetup| wanted.iter().any(|wanted| wanted.name == node.name);
    let program = &beside("rts-relay")?;
    let asleep = nodes.by_ssh().filter(|node| !holds(&node.name));
    let reaching = asleep.map(|node| async move {
        let waker = Waker {
            home: session.home.clone(),
            out: session.out,
            node: node.clone(),
            program: program.clone(),
            module_path: path.cloned(),
            patience: if is_wanted(node) { SESSION } else { LOOK },
        };
        (node, waker.wake().await)
    });
    let mut reached = Reached {
        woken: false,
        nodes: nodes.clone(),
    };
    let mut on_demand = Vec::new();
    for (node, woken) in join_all(reaching).await {
        match woken {
            Ok(woken) => {
                reached.woken |= woken.started;
                if !woken.resident {
                    on_demand.push(node.name.as_str());
                }
            }
            Err(e) if is_wanted(node) => return Err(e),
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
    if let Some(notice) = notice(&on_demand) {
        session.out.say(&notice);
    }
    Ok(reached)
}

/// What is said of all nodes that nothing heals between commands.
fn notice(nodes: &[&str]) -> Option<String> {
    let who = match nodes {
        [] => return None,
        [node] => format!("node {node} is"),
        nodes => format!("nodes {} are", nodes.join(", ")),
    };
    Some(format!(
        "rtsctl: {who} reached by SSH: between commands nothing there is healed"
    ))
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
        agents::wait_for(session, &reached.nodes, &[], &[]).await?;
    }
    Ok(())
}

/// Ends the relay of a node, if it has one.
pub fn stop(home: &Home, node: &str) {
    use rts_host::{identity::Identity, process::Process};
    use rustix::process::Signal;
    let description = home.node_run(node).join("relay.json");
    if let Some(process) = Identity::read(&description).and_then(|i| Process::identified(&i)) {
        process.signal(Signal::TERM);
        // One that hangs does not end by itself.
        if !process.ended(END) {
            process.signal(Signal::KILL);
            process.ended(END);
        }
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
            .local(ASK)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_line_tells_of_all_nodes_that_nothing_heals() {
        assert_eq!(notice(&[]), None);
        assert!(notice(&["arm"]).unwrap().contains("node arm is reached"));
        assert!(
            notice(&["arm", "leg"])
                .unwrap()
                .contains("nodes arm, leg are reached")
        );
    }
}
