//! The page of a node.

use rts_controller_api::objects::Node;

use super::Scene;
use super::page::Page;
use crate::show::age::age;
use crate::show::table::Table;

pub(super) fn node(node: &Node, scene: &Scene) -> Page {
    let mut page = Page::of(&node.metadata, None, scene);
    let (name, status) = (&node.metadata.name, &node.status);
    page.line("Endpoint", &node.spec.endpoint);
    page.line("Aliases", node.spec.aliases.join(", "));
    page.line("State", &status.state);
    page.line("Reason", status.reason.clone().unwrap_or_default());
    page.line("Message", status.message.clone().unwrap_or_default());
    page.line("Help", help(name, scene).unwrap_or_default());
    page.line(
        "Last seen",
        format!("{} ago", age(status.last_seen, scene.now)),
    );
    page.line(
        "Agent",
        format!("version {}, session {}", status.version, status.session),
    );
    let target = format!("node/{name}");
    let waiting = scene.systems.iter().flat_map(|s| &s.status.waiting_on);
    page.waiting(waiting.filter(|w| w.target == target), scene.now);
    let mut managers = Table::new(&["NAME", "PID", "STATE", "COMPONENTS"]);
    for manager in scene.managers.iter().filter(|m| m.status.node == *name) {
        managers.row([
            manager.metadata.name.clone(),
            manager.status.pid.to_string(),
            manager.status.state.clone(),
            manager.status.components.join(","),
        ]);
    }
    page.table("Managers", &managers);
    page.events(scene, |event| event.spec.object == target);
    page
}

/// What brings a node's agent back; none while it is there.
pub(super) fn help(name: &str, scene: &Scene) -> Option<String> {
    if scene.lacking.iter().any(|node| node == name) {
        return Some(format!(
            "the agent of node {name} does not run: `rtsctl up` starts it again"
        ));
    }
    let node = scene.nodes.iter().find(|node| node.metadata.name == name)?;
    (node.status.state == "Unknown").then(|| {
        format!("the agent of node {name} gives no sign of life: start it again on its machine")
    })
}
