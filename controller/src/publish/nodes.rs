//! Node objects.

use rts_controller_api::objects::{Kind, Metadata, Node, NodeSpecView, NodeStatus};

use super::{Scene, object};
use crate::sessions::NodeEntry;

/// Nodes that greeted, and those that stored systems ran on.
pub fn nodes(scene: &Scene<'_>) -> Vec<Node> {
    let ran = scene.systems.values().flat_map(|r| &r.nodes);
    let silent = ran
        .filter(|node| !scene.nodes.contains_key(*node))
        .map(|node| unknown(node));
    let greeted = scene
        .nodes
        .iter()
        .map(|(name, entry)| known(scene, name, entry));
    greeted.chain(silent).collect()
}

fn known(scene: &Scene<'_>, name: &str, entry: &NodeEntry) -> Node {
    let managers = scene
        .inventories
        .get(name)
        .map_or(&[][..], |(inventory, _)| &inventory.managers[..]);
    let fenced = scene.fenced.get(name).filter(|_| !entry.lost);
    let state = match fenced {
        Some(_) => "NotReady",
        None => entry.state(),
    };
    let silent = entry.silent.as_ref().filter(|_| !entry.lost);
    let components: usize = managers.iter().map(|m| m.components.len()).sum();
    object(
        Kind::Node,
        Metadata {
            name: name.to_owned(),
            uid: entry.uid.clone(),
            creation_timestamp: Some(entry.created),
            ..Metadata::default()
        },
        NodeSpecView {
            endpoint: entry.session.endpoint.clone(),
            aliases: entry.session.aliases.clone(),
            transport: entry.session.transport.clone(),
        },
        NodeStatus {
            state: state.to_owned(),
            last_seen: Some(entry.session.seen),
            version: entry.session.version.clone(),
            session: entry.session.id.clone(),
            managers: u32::try_from(managers.len()).unwrap_or(u32::MAX),
            components: u32::try_from(components).unwrap_or(u32::MAX),
            reason: match fenced {
                Some(fenced) => Some(fenced.reason.to_owned()),
                None if entry.sleeps() => Some("OnDemand".to_owned()),
                None => silent.map(|_| "Silent".to_owned()),
            },
            message: fenced
                .map(|fenced| fenced.message.clone())
                .or(silent.cloned())
                .or_else(|| by_session(entry)),
            ledger: fenced.and_then(|fenced| fenced.ledger.clone()),
        },
    )
}

/// What a person must know of a node that is reached by a session.
fn by_session(entry: &NodeEntry) -> Option<String> {
    let transport = entry.session.transport.as_ref()?;
    let healing = match transport.resident {
        true => "its own agent heals it meanwhile",
        false => "between commands nothing there is healed",
    };
    let (kind, who) = (&transport.kind, &transport.destination);
    Some(match entry.sleeps() {
        true => format!(
            "reached by {kind} ({who}) when a command needs it; what is shown was seen last; {healing}"
        ),
        false => format!("reached by {kind} ({who}) while a command needs it; {healing}"),
    })
}

fn unknown(name: &str) -> Node {
    let metadata = Metadata {
        name: name.to_owned(),
        ..Metadata::default()
    };
    let status = NodeStatus {
        state: "Unknown".to_owned(),
        ..NodeStatus::default()
    };
    object(Kind::Node, metadata, NodeSpecView::default(), status)
}
