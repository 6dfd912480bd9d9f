//! Forgetting a node that is no longer one: until then it is shown, though nobody will ever reach it.

use rts_controller_api::Problem;

use crate::core::Core;
use crate::view::Happening;

/// Forgets a node whose agent is away, or which is reached by a session of its own, when no system is or was on it. One
/// that greets again is there again.
pub fn forget(core: &Core, node: &str) -> Result<(), Problem> {
    let Some(entry) = core.sessions.get(node) else {
        return Err(Problem::not_found(format!("there is no node {node}")));
    };
    let systems = systems_of(core, node);
    if !systems.is_empty() {
        let detail = format!(
            "{} may still run on node {node}: take it down first",
            systems.join(", ")
        );
        return Err(Problem::conflict("systems-run", detail));
    }
    if !entry.lost && entry.session.transport.is_none() {
        let detail = format!("the agent of node {node} lives: end it first");
        return Err(Problem::conflict("node-lives", detail));
    }
    core.sessions.forget(node);
    let message = "it is not a node any more".to_owned();
    core.record(Happening::normal(
        "NodeForgotten",
        &format!("node/{node}"),
        message,
    ));
    core.publish();
    core.wake.notify_one();
    Ok(())
}

/// Systems that wait for the word of a node, or are placed there.
fn systems_of(core: &Core, node: &str) -> Vec<String> {
    let registry = core.registry();
    let records = registry.systems.values();
    let on_it = records.filter(|r| r.nodes.contains(node) && !r.forgotten.contains(node));
    on_it.map(|record| record.name().to_owned()).collect()
}
