//! What the user said of a node whose ledger is another store's: adopt what runs there, or put our set in its place.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use rts_agent_api::messages::LedgerFence;
use rts_controller_api::Problem;
use rts_controller_api::requests::{NodeClaimed, TakeOver};

use super::import::{self, Import, Refused};
use super::{Standing, fence, settle};
use crate::apply::{of_store, to_its_end};
use crate::core::Core;
use crate::sessions::NodeEntry;

/// Time for the node to store the first spec of this store.
const DEADLINE: Duration = Duration::from_secs(15);

/// What runs on the node goes on, and its systems are this controller's.
pub async fn adopt(core: &Arc<Core>, node: &str) -> Result<NodeClaimed, Problem> {
    let (core, node) = (Arc::clone(core), node.to_owned());
    to_its_end(async move { adopt_now(&core, &node).await }).await
}

/// This controller's set replaces what the node has.
pub async fn take_over(
    core: &Arc<Core>,
    node: &str,
    request: TakeOver,
) -> Result<NodeClaimed, Problem> {
    let (core, node) = (Arc::clone(core), node.to_owned());
    to_its_end(async move { take_over_now(&core, &node, &request.confirm).await }).await
}

async fn adopt_now(core: &Arc<Core>, node: &str) -> Result<NodeClaimed, Problem> {
    let entry = live(core, node)?;
    let Some(ledger) = foreign(core, node)? else {
        return Ok(claimed(node, None, Vec::new()));
    };
    let envelope = settle::fetch(core, node, &entry).await;
    let envelope = envelope.map_err(|why| refused(node, &why))?;
    if fence(&envelope) != ledger {
        let session = &entry.session.id;
        core.sessions.stored(node, session, fence(&envelope));
        return Err(changed(node));
    }
    {
        let _admission = core.admission.lock().await;
        let stored = core.registry().systems.clone();
        let import = import::add(&stored, &envelope.spec, core.clock.now());
        let import = import.map_err(|why| not_added(node, &why))?;
        fits(core, node, &import, &envelope.spec)?;
        let committed = settle::commit(core, node, import, Vec::new()).await;
        committed.map_err(|e| of_store(&e))?;
        core.sessions.claim(node, &entry.session.id, ledger.clone());
    }
    let parts = envelope.spec.systems.into_iter();
    let systems = parts.map(|part| part.system.name).collect();
    ours(core, node, &entry.session.id).await?;
    Ok(claimed(node, Some(ledger), systems))
}

async fn take_over_now(
    core: &Arc<Core>,
    node: &str,
    confirm: &LedgerFence,
) -> Result<NodeClaimed, Problem> {
    let entry = live(core, node)?;
    let Some(ledger) = foreign(core, node)? else {
        return Ok(claimed(node, None, Vec::new()));
    };
    if ledger != *confirm {
        return Err(changed(node));
    }
    core.sessions.claim(node, &entry.session.id, ledger.clone());
    core.desired_changed();
    ours(core, node, &entry.session.id).await?;
    Ok(claimed(node, Some(ledger), Vec::new()))
}

fn claimed(node: &str, ledger: Option<LedgerFence>, systems: Vec<String>) -> NodeClaimed {
    NodeClaimed {
        node: node.to_owned(),
        changed: ledger.is_some(),
        ledger,
        systems,
    }
}

fn live(core: &Core, node: &str) -> Result<NodeEntry, Problem> {
    let entry = core.sessions.get(node);
    let entry = entry.ok_or_else(|| Problem::not_found(format!("there is no node {node}")))?;
    if entry.lost {
        let detail = format!("node {node} is unknown: its agent sends no heartbeats");
        return Err(Problem::unavailable("agent-unreachable", detail));
    }
    Ok(entry)
}

/// The ledger of another store; none when the node is this one's already.
fn foreign(core: &Core, node: &str) -> Result<Option<LedgerFence>, Problem> {
    let standing = Standing::get(core, node);
    match &standing {
        Standing::Agreed => Ok(None),
        Standing::Foreign(ledger) => Ok(Some(ledger.clone())),
        other => {
            let detail = other.message(core, node).unwrap_or_default();
            Err(Problem::conflict("stale-controller", detail))
        }
    }
}

/// Refuses what would restart something, or clash with what is here.
fn fits(
    core: &Core,
    node: &str,
    import: &Import,
    spec: &rts_plan::desired::NodeSpec,
) -> Result<(), Problem> {
    let placed = core.place_all(&import.records);
    let clash = placed.problems.iter().find_map(|problem| match problem {
        rts_plan::PlaceError::InstanceClash { node: at, .. } if at == node => {
            Some(problem.to_string())
        }
        _ => None,
    });
    if let Some(clash) = clash {
        return Err(Problem::conflict("instance-clash", clash));
    }
    let disturbed = import::disturbed(import, &placed, spec);
    if disturbed.is_empty() {
        return Ok(());
    }
    let detail = format!(
        "node {node} cannot be adopted without a restart of {}; tear those systems down where they belong, or use take-over",
        disturbed.join(", ")
    );
    Err(Problem::conflict("would-restart", detail))
}

/// Waits until the agent has stored this store's spec. What was not done in time is not done later.
async fn ours(core: &Core, node: &str, session: &str) -> Result<(), Problem> {
    let done = becomes_ours(core, node, session).await;
    if done.is_err() {
        core.sessions.unclaim(node, session);
    }
    done
}

async fn becomes_ours(core: &Core, node: &str, session: &str) -> Result<(), Problem> {
    let mut changes = core.sessions.subscribe();
    core.wake.notify_one();
    let wait = async {
        loop {
            match core.sessions.get(node) {
                Some(entry) if entry.session.id == session && !entry.lost => {
                    let ledger = entry.session.ledger;
                    if ledger.is_some_and(|ledger| ledger.cluster_uid == core.cluster_uid) {
                        return Ok(());
                    }
                }
                _ => return Err(refused(node, "its agent was lost")),
            }
            if changes.changed().await.is_err() {
                return Err(refused(node, "the controller ends"));
            }
        }
    };
    match tokio::time::timeout(DEADLINE, wait).await {
        Ok(result) => result,
        Err(_) => {
            let fault = core.world().faults.get(node).map(|f| f.reason.clone());
            let why =
                fault.unwrap_or_else(|| "its agent did not store the spec in time".to_owned());
            Err(refused(node, &why))
        }
    }
}

fn refused(node: &str, why: &str) -> Problem {
    Problem::unavailable("node-not-ready", format!("node {node}: {why}"))
}

fn changed(node: &str) -> Problem {
    Problem::conflict(
        "ledger-changed",
        format!(
            "the ledger of node {node} is another by now; look again (`rtsctl get nodes -o json`) and decide anew"
        ),
    )
}

fn not_added(node: &str, why: &Refused) -> Problem {
    let list = |names: &BTreeSet<String>| names.iter().cloned().collect::<Vec<_>>().join(", ");
    match why {
        Refused::Taken(names) => Problem::conflict(
            "name-taken",
            format!(
                "node {node} runs {}, and other systems have that name here; tear those down (`rtsctl teardown`), or use take-over",
                list(names)
            ),
        ),
        Refused::Ending(names) => Problem::conflict(
            "terminating",
            format!(
                "node {node} takes down its part of {}, which lives here: to adopt it would end all of it; wait until that part is gone, or use take-over to have it run here",
                list(names)
            ),
        ),
    }
}
