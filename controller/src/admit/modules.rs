//! Asks the nodes' agents for the modules of a system: one that is missing refuses it before anything is disturbed,
//! unless only optional components need it.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use futures_util::future::join_all;
use rts_agent_api::messages::{ModuleDescription, ModuleResolution};
use rts_controller_api::{Problem, ProblemError};
use rts_plan::observed::{NodeObserved, Observed};
use rts_schemas::system::{StandIn, SystemSpec};

use super::check;
use super::placed::Types;
use crate::core::Core;
use crate::ledger::Standing;
use crate::sessions::{Lost, Session};
use crate::store::SystemRecord;

/// What one node must have: type → components that need it, and whether those are required.
type OfNode = BTreeMap<String, BTreeMap<String, bool>>;

/// Instance → when a stand-in takes its place.
type Policies<'a> = BTreeMap<&'a str, StandIn>;

/// Time that an agent has to answer. It may have to ask a module that hangs, for 5 s; it remembers that.
const DEADLINE: Duration = Duration::from_secs(9);
/// Files that were looked for and are listed.
const SEARCHED: usize = 12;

/// Modules that were found.
#[derive(Debug, Default)]
pub struct Found {
    /// Type name → SHA-256.
    pub digests: BTreeMap<String, String>,
    /// Instances whose place a stand-in takes.
    pub stand_ins: BTreeSet<String>,
    /// Optional components on nodes that could not be asked: what was decided of them before stays.
    undecided: BTreeSet<String>,
    /// Types of optional components that were not found, or not asked for, on some node.
    pub unseen: BTreeSet<String>,
    /// Node → type name → what the module says of itself, when it can be opened.
    pub described: BTreeMap<String, BTreeMap<String, ModuleDescription>>,
    /// A fault for each required component whose module is not there.
    pub missing: Vec<ProblemError>,
    /// Remarks.
    pub notes: Vec<String>,
    /// Types of which nodes have different files.
    differ: BTreeSet<String>,
    /// Why a node is away that only optional components need.
    away: Option<Problem>,
}

/// Resolves the types that each node needs. A node that only optional components need may be away.
pub async fn resolve(core: &Core, spec: &SystemSpec, types: &Types) -> Result<Found, Problem> {
    let mut found = Found::default();
    let asked = agents(core, types, &mut found)?;
    let asked = asked.into_iter().map(|(node, session)| async move {
        let answer = ask(core, &node, &session, &types[&node]).await;
        (node, answer)
    });
    let components = spec.components.iter();
    let policies = components.map(|c| (c.instance.as_str(), c.stand_in.policy()));
    let policies: Policies<'_> = policies.collect();
    let mut answered = false;
    for (node, answer) in join_all(asked).await {
        match answer {
            Ok(answer) => {
                answered = true;
                found.take(spec, &policies, &node, &types[&node], &answer);
            }
            Err(problem) => found.without(&node, &types[&node], problem)?,
        }
    }
    // Nothing at all could be brought up now: its agents may be about to come.
    if let (false, Some(problem)) = (answered, found.away.take()) {
        return Err(problem);
    }
    // One digest stands for a type on all nodes: where nodes differ (two architectures), none is pinned.
    for type_name in std::mem::take(&mut found.differ) {
        found.digests.remove(&type_name);
        found.unseen.remove(&type_name);
        found.notes.push(format!(
            "nodes have different module files of {type_name}; none is pinned"
        ));
    }
    Ok(found)
}

async fn ask(
    core: &Core,
    node: &str,
    session: &Session,
    types: &OfNode,
) -> Result<Vec<ModuleResolution>, Problem> {
    let wanted: Vec<String> = types.keys().cloned().collect();
    let answer = session.agent.resolve_modules(&wanted);
    let answer = tokio::time::timeout(DEADLINE, answer);
    match core.sessions.while_live(node, &session.id, answer).await {
        Ok(Ok(Ok(answer))) => Ok(answer),
        Ok(Ok(Err(e))) => Err(not_ready(node, &format!("its agent failed: {e}"))),
        Ok(Err(_)) => Err(not_ready(node, "its agent did not answer in time")),
        Err(Lost) => Err(not_ready(node, "its agent was lost")),
    }
}

impl Found {
    /// The digests to store. What could not be seen now keeps the one that it has: it may run, and is not made again
    /// for that. What came up without one is not made again to get one.
    pub fn pinned(
        &self,
        stored: Option<&SystemRecord>,
        observed: &Observed,
    ) -> BTreeMap<String, String> {
        let mut digests = self.digests.clone();
        if let Some(stored) = stored {
            let runs = running(observed, &stored.uid);
            digests.retain(|name, _| {
                stored.digests.contains_key(name) || !runs.contains(name.as_str())
            });
        }
        let old = stored.into_iter().flat_map(|stored| &stored.digests);
        for (type_name, digest) in old.filter(|(name, _)| self.unseen.contains(*name)) {
            let digest = || digest.clone();
            digests.entry(type_name.clone()).or_insert_with(digest);
        }
        digests
    }

    /// The stand-ins to store.
    pub fn stand_ins(&self, stored: Option<&SystemRecord>) -> BTreeSet<String> {
        let before = stored
            .into_iter()
            .flat_map(|stored| stored.stand_ins.keys());
        let kept = before.filter(|instance| self.undecided.contains(*instance));
        kept.chain(&self.stand_ins).cloned().collect()
    }

    /// Takes in what a node has.
    fn take(
        &mut self,
        spec: &SystemSpec,
        policies: &Policies<'_>,
        node: &str,
        types: &OfNode,
        answer: &[ModuleResolution],
    ) {
        for (wanted, components) in types {
            let resolution = answer.iter().find(|r| r.type_name == *wanted);
            let module = resolution.and_then(|r| r.module.as_ref());
            let (stand_ins, real): (Vec<_>, Vec<_>) = components
                .iter()
                .partition(|(instance, _)| stands_in(policies, instance, module.is_some()));
            let names = stand_ins.into_iter().map(|(instance, _)| instance.clone());
            self.stand_ins.extend(names);
            if real.is_empty() {
                continue;
            }
            let Some(module) = module else {
                let files = searched(resolution);
                for (instance, required) in real {
                    self.misses(spec, node, wanted, (instance, *required), &files);
                }
                continue;
            };
            if let Some(description) = &module.description {
                let of_node = self.described.entry(node.to_owned()).or_default();
                of_node.insert(wanted.clone(), description.clone());
            }
            let digest = module.digest.clone();
            let before = self.digests.insert(wanted.clone(), digest);
            if before.is_some_and(|before| before != module.digest) {
                self.differ.insert(wanted.clone());
            }
        }
    }

    /// A module is not there: a fault for what is required, a remark for what is optional.
    fn misses(
        &mut self,
        spec: &SystemSpec,
        node: &str,
        type_name: &str,
        (instance, required): (&str, bool),
        files: &str,
    ) {
        if !required {
            self.unseen.insert(type_name.to_owned());
            self.notes.push(format!(
                "component {instance} is optional and its module {type_name} was not found on node {node} ({files}): \
                 it is tried again, the rest runs"
            ));
            return;
        }
        let help =
            "build the component, or add its folder to RTSCTL_MODULE_PATH and restart the agent";
        self.missing.push(ProblemError {
            pointer: format!("{}/type", check::pointer(spec, instance)),
            code: "module-not-found".to_owned(),
            detail: format!(
                "component {instance}: no module of type {type_name} on node {node}: {files}"
            ),
            help: Some(help.to_owned()),
        });
    }

    /// Goes on without a node, when only optional components need it.
    fn without(&mut self, node: &str, types: &OfNode, problem: Problem) -> Result<(), Problem> {
        let components = || types.values().flatten();
        if components().any(|(_, required)| *required) {
            return Err(problem);
        }
        let names: Vec<&str> = components().map(|(name, _)| name.as_str()).collect();
        self.unseen.extend(types.keys().cloned());
        self.undecided
            .extend(components().map(|(name, _)| name.clone()));
        self.notes.push(format!(
            "node {node} is not ready, and only optional components need it ({}): they wait for it, the rest runs",
            names.join(", ")
        ));
        self.away.get_or_insert(problem);
        Ok(())
    }
}

/// Whether a stand-in takes the place of a component whose module is there, or not.
fn stands_in(policies: &Policies<'_>, instance: &str, is_there: bool) -> bool {
    match policies.get(instance) {
        Some(StandIn::Always) => true,
        Some(StandIn::Missing) => !is_there,
        Some(StandIn::Never) | None => false,
    }
}

/// Types of a system's components that are there with their own code.
fn running<'a>(observed: &'a Observed, uid: &str) -> BTreeSet<&'a str> {
    let known = observed.nodes.values().filter_map(|node| match node {
        NodeObserved::Known(inventory) => Some(&inventory.managers),
        NodeObserved::Unknown { .. } => None,
    });
    let all = known.flatten().flat_map(|manager| &manager.components);
    all.filter(|c| !c.stand_in && c.system.as_ref().is_some_and(|s| s.uid == uid))
        .map(|c| c.type_name.as_str())
        .collect()
}

/// The agents of all nodes that are needed.
fn agents(
    core: &Core,
    types: &Types,
    found: &mut Found,
) -> Result<BTreeMap<String, Session>, Problem> {
    let mut agents = BTreeMap::new();
    for (node, wanted) in types {
        match agent(core, node) {
            Ok(session) => drop(agents.insert(node.clone(), session)),
            Err(problem) => found.without(node, wanted, problem)?,
        }
    }
    Ok(agents)
}

fn agent(core: &Core, node: &str) -> Result<Session, Problem> {
    let entry = core
        .sessions
        .get(node)
        .ok_or_else(|| not_ready(node, "its agent has not greeted yet"))?;
    if entry.lost {
        return Err(not_ready(node, "its agent sends no heartbeats"));
    }
    if let Some(why) = Standing::get(core, node).message(core, node) {
        let mut problem = Problem::unavailable("node-not-ready", why).of_node(node);
        problem.retryable = false;
        return Err(problem);
    }
    Ok(entry.session)
}

fn not_ready(node: &str, why: &str) -> Problem {
    Problem::unavailable(
        "node-not-ready",
        format!("node {node} is needed and not ready: {why}; try again once it is Ready"),
    )
    .of_node(node)
}

/// Where a module was looked for.
fn searched(resolution: Option<&ModuleResolution>) -> String {
    let searched = resolution.map_or(&[][..], |r| &r.searched[..]);
    let mut files = searched.iter().take(SEARCHED).cloned().collect::<Vec<_>>();
    if searched.len() > SEARCHED {
        files.push(format!("{} more", searched.len() - SEARCHED));
    }
    if files.is_empty() {
        "no module path is set".to_owned()
    } else {
        format!("looked for {}", files.join(", "))
    }
}
