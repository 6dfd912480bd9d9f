//! Asks the nodes' agents for the modules of a system: one that is missing refuses it before anything is disturbed.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use futures_util::future::join_all;
use rts_agent_api::messages::{ModuleDescription, ModuleResolution};
use rts_controller_api::{Problem, ProblemError};
use rts_schemas::system::SystemSpec;

use super::check;
use crate::core::Core;
use crate::ledger::Standing;
use crate::sessions::{Lost, Session};

/// Time that an agent has to answer. It may have to ask a module that hangs, for 5 s; it remembers that.
const DEADLINE: Duration = Duration::from_secs(9);
/// Files that were looked for and are listed.
const SEARCHED: usize = 12;

/// Modules that were found.
#[derive(Debug, Default)]
pub struct Found {
    /// Type name → SHA-256.
    pub digests: BTreeMap<String, String>,
    /// Node → type name → what the module says of itself, when it can be opened.
    pub described: BTreeMap<String, BTreeMap<String, ModuleDescription>>,
    /// A fault for each component whose module is not there.
    pub missing: Vec<ProblemError>,
    /// Remarks.
    pub notes: Vec<String>,
}

/// Resolves the types that each node needs.
pub async fn resolve(
    core: &Core,
    spec: &SystemSpec,
    types: &BTreeMap<String, BTreeSet<String>>,
) -> Result<Found, Problem> {
    let agents = agents(core, types)?;
    let asked = agents.into_iter().map(|(node, session)| async move {
        let wanted: Vec<String> = types[&node].iter().cloned().collect();
        let answer = session.agent.resolve_modules(&wanted);
        let answer = tokio::time::timeout(DEADLINE, answer);
        let answer = core.sessions.while_live(&node, &session.id, answer).await;
        (node, answer)
    });
    let mut found = Found::default();
    let mut differ = BTreeSet::new();
    for (node, answer) in join_all(asked).await {
        let answer = match answer {
            Ok(Ok(Ok(answer))) => answer,
            Ok(Ok(Err(e))) => return Err(not_ready(&node, &format!("its agent failed: {e}"))),
            Ok(Err(_)) => return Err(not_ready(&node, "its agent did not answer in time")),
            Err(Lost) => return Err(not_ready(&node, "its agent was lost")),
        };
        for wanted in &types[&node] {
            let resolution = answer.iter().find(|r| r.type_name == *wanted);
            match resolution.and_then(|r| r.module.as_ref()) {
                Some(module) => {
                    if let Some(description) = &module.description {
                        let of_node = found.described.entry(node.clone()).or_default();
                        of_node.insert(wanted.clone(), description.clone());
                    }
                    let digest = module.digest.clone();
                    let before = found.digests.insert(wanted.clone(), digest);
                    if before.is_some_and(|before| before != module.digest) {
                        differ.insert(wanted.clone());
                    }
                }
                None => found
                    .missing
                    .extend(missing(spec, &node, wanted, resolution)),
            }
        }
    }
    // One digest stands for a type on all nodes: where nodes differ (two architectures), none is pinned.
    for type_name in differ {
        found.digests.remove(&type_name);
        found.notes.push(format!(
            "nodes have different module files of {type_name}; none is pinned"
        ));
    }
    Ok(found)
}

/// The agents of all nodes that are needed.
fn agents(
    core: &Core,
    types: &BTreeMap<String, BTreeSet<String>>,
) -> Result<BTreeMap<String, Session>, Problem> {
    types
        .keys()
        .map(|node| {
            let entry = core
                .sessions
                .get(node)
                .ok_or_else(|| not_ready(node, "its agent has not greeted yet"))?;
            if entry.lost {
                return Err(not_ready(node, "its agent sends no heartbeats"));
            }
            if let Some(why) = Standing::get(core, node).message(core, node) {
                let mut problem = Problem::unavailable("node-not-ready", why);
                problem.retryable = false;
                return Err(problem);
            }
            Ok((node.clone(), entry.session))
        })
        .collect()
}

fn not_ready(node: &str, why: &str) -> Problem {
    Problem::unavailable(
        "node-not-ready",
        format!("node {node} is needed and not ready: {why}; try again once it is Ready"),
    )
}

/// One fault for each component of a type that a node does not have.
fn missing(
    spec: &SystemSpec,
    node: &str,
    type_name: &str,
    resolution: Option<&ModuleResolution>,
) -> Vec<ProblemError> {
    let searched = resolution.map_or(&[][..], |r| &r.searched[..]);
    let mut files = searched.iter().take(SEARCHED).cloned().collect::<Vec<_>>();
    if searched.len() > SEARCHED {
        files.push(format!("{} more", searched.len() - SEARCHED));
    }
    let files = if files.is_empty() {
        "no module path is set".to_owned()
    } else {
        format!("looked for {}", files.join(", "))
    };
    let components = spec.components.iter();
    components
        .filter(|component| component.type_name == type_name)
        .map(|component| {
            ProblemError {
            pointer: format!("{}/type", check::pointer(spec, &component.instance)),
            code: "module-not-found".to_owned(),
            detail: format!(
                "component {}: no module of type {type_name} on node {node}: {files}",
                component.instance
            ),
            help: Some(
                "build the component, or add its folder to RTSCTL_MODULE_PATH and restart the agent"
                    .to_owned(),
            ),
        }
        })
        .collect()
}
