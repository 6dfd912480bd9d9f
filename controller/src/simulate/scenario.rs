//! What a simulation begins with: what is stored, the nodes with their modules, and how all that differs from what is.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::Duration;

use futures_util::future::join_all;
use rts_agent_api::messages::ModuleResolution;
use rts_controller_api::objects::{Component, System};
use rts_controller_api::simulate::{DEFAULT_LIMIT, DEFAULT_SEED, SimulateRequest};
use rts_plan::desired::ManagerKey;

use crate::core::Core;
use crate::sessions::NodeEntry;
use crate::simulator::{Parts, Scenario, ScenarioNode, Stop};
use crate::store::{State, SystemRecord};

/// Time that an agent has to say which modules it finds.
const DEADLINE: Duration = Duration::from_secs(9);

/// Asks agents for their modules, and puts all together.
pub async fn gather(
    core: &Arc<Core>,
    candidate: &SystemRecord,
    request: &SimulateRequest,
) -> Scenario {
    let (before, mut notes) = before(core);
    let parts = parts(core, candidate);
    let nodes = nodes(core, &parts).await;
    notes.extend(of_nodes(core, &nodes));
    Scenario {
        before,
        request: request.apply(),
        local_node: core.local_node.clone(),
        nodes,
        faults: request.faults.clone(),
        seed: request.seed.unwrap_or(DEFAULT_SEED),
        limit: Duration::from_secs(request.limit_seconds.unwrap_or(DEFAULT_LIMIT)),
        notes,
        stop: Stop::default(),
    }
}

/// What is stored, without what is being taken down, and where it is not so now.
fn before(core: &Core) -> (State, Vec<String>) {
    let mut records = core.registry().systems.clone();
    let mut notes = Vec::new();
    records.retain(|name, record| {
        if record.deleted.is_some() {
            notes.push(format!(
                "system/{name} is being taken down now; in the simulation it is gone"
            ));
        }
        if !record.left.is_empty() {
            Arc::make_mut(record).left.clear();
        }
        record.deleted.is_none()
    });
    for system in core.view.list::<System>().items {
        let (name, status) = (&system.metadata.name, &system.status);
        if records.contains_key(name) && !(status.synced && status.healthy) {
            notes.push(format!(
                "system/{name} is {:?} now; the simulation begins as if all of it ran",
                status.phase
            ));
        }
    }
    for component in core.view.list::<Component>().items {
        let (name, status) = (&component.metadata.name, &component.status);
        if status.drift {
            notes.push(format!(
                "component/{name} was made or changed by hand; the simulation begins without that"
            ));
        }
    }
    let state = State {
        cluster_uid: "simulation".to_owned(),
        epoch: 1,
        indexes: records.values().map(|r| r.index).max().unwrap_or(0),
        systems: records,
        ..State::default()
    };
    (state, notes)
}

/// Node → what it is to have, before or after the apply.
fn parts(core: &Core, candidate: &SystemRecord) -> BTreeMap<String, Parts> {
    let mut parts: BTreeMap<String, Parts> = BTreeMap::new();
    for placed in [core.place(None), core.place(Some(candidate))] {
        for (node, spec) in &placed.desired.nodes {
            let parts = parts.entry(node.clone()).or_default();
            for system in &spec.systems {
                for component in &system.components {
                    let manager = ManagerKey {
                        system: Some(system.system.clone()),
                        name: component.manager.clone(),
                    };
                    parts.managers.insert(manager.display_name());
                    parts.instances.insert(component.spec.instance.clone());
                    parts.types.insert(component.spec.type_name.clone());
                }
            }
        }
    }
    parts
}

async fn nodes(core: &Core, parts: &BTreeMap<String, Parts>) -> Vec<ScenarioNode> {
    let sessions = core.sessions.all();
    let told = core.registry().nodes.clone();
    let names: BTreeSet<&String> = sessions
        .keys()
        .chain(told.keys())
        .chain(parts.keys())
        .chain([&core.local_node])
        .collect();
    let none = Parts::default();
    let asked = names.into_iter().map(|name| {
        let (entry, parts) = (sessions.get(name), parts.get(name).unwrap_or(&none));
        async move {
            ScenarioNode {
                name: name.clone(),
                aliases: entry.map_or_else(Vec::new, |e| e.session.aliases.clone()),
                parts: parts.clone(),
                modules: match entry.filter(|entry| !entry.lost) {
                    Some(entry) => ask(core, name, entry, &parts.types).await,
                    None => None,
                },
            }
        }
    });
    join_all(asked).await
}

async fn ask(
    core: &Core,
    node: &str,
    entry: &NodeEntry,
    types: &BTreeSet<String>,
) -> Option<Vec<ModuleResolution>> {
    let wanted: Vec<String> = types.iter().cloned().collect();
    let answer = entry.session.agent.resolve_modules(&wanted);
    let answer = tokio::time::timeout(DEADLINE, answer);
    let answer = core.sessions.while_live(node, &entry.session.id, answer);
    answer.await.ok()?.ok()?.ok()
}

fn of_nodes(core: &Core, nodes: &[ScenarioNode]) -> Vec<String> {
    let mut notes = Vec::new();
    for node in nodes {
        let name = &node.name;
        let state = core.sessions.get(name).map_or("Unknown", |e| e.state());
        if state != "Ready" {
            notes.push(format!(
                "node/{name} is {state} now; the simulation begins with it up"
            ));
        }
        if node.modules.is_none() {
            notes.push(format!(
                "the agent of node {name} was not asked for its modules; the simulation takes them to be there"
            ));
        }
    }
    notes
}
