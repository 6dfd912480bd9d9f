//! Connectors that do not reach from one end to the other: by their interface type, or because no transport leads there.

use std::collections::BTreeMap;

use rts_agent_api::session::Transport;
use rts_controller_api::ProblemError;
use rts_plan::Placed;
use rts_plan::desired::{EndPlace, PlacedConnector};
use rts_schemas::connector::{Distance, read};
use rts_schemas::system::SystemSpec;

use super::check::Faults;
use crate::store::SystemRecord;

/// A fault for each connector of a candidate that can never be made where its components were placed. `transports`: nodes that
/// are reached by a session, and how.
pub fn reach(
    placed: &Placed,
    candidate: &SystemRecord,
    transports: &BTreeMap<String, Transport>,
) -> Vec<ProblemError> {
    let mut faults = Faults::default();
    let parts = placed.desired.nodes.iter();
    let parts = parts.flat_map(|(node, spec)| spec.systems.iter().map(move |part| (node, part)));
    for (node, part) in parts.filter(|(_, part)| part.system.uid == candidate.uid) {
        // It stands on the nodes of both of its ends.
        for connector in part.connectors.iter().filter(|c| c.source.node == *node) {
            if let Some((node, transport)) = cut_off(connector, transports) {
                let detail = format!(
                    "`{}` and `{}` are on the nodes `{}` and `{}`, and no samples get to or from `{node}`: it is reached by {} alone ({})",
                    connector.spec.source,
                    connector.spec.target,
                    connector.source.node,
                    connector.target.node,
                    transport.kind,
                    transport.destination,
                );
                let help = format!(
                    "place both components on the same node (`rtsctl.node`); node {node} carries commands through its session, and no samples"
                );
                let pointer = pointer(&candidate.spec, &connector.spec.name);
                faults.advise(pointer, "no-transport", detail, help);
                continue;
            }
            let Ok(settings) = read(&connector.spec.properties) else {
                continue;
            };
            let distance = distance(&connector.source, &connector.target);
            let Some(fault) = settings.interface.out_of_reach(distance) else {
                continue;
            };
            let detail = format!(
                "`{}` and `{}` are joined by the interface type `{}`, which needs both {}: {} is {}, {} is {}",
                connector.spec.source,
                connector.spec.target,
                fault.word,
                fault.needs,
                connector.spec.source.instance,
                shown(&connector.source),
                connector.spec.target.instance,
                shown(&connector.target),
            );
            let pointer = pointer(&candidate.spec, &connector.spec.name);
            faults.advise(pointer, fault.code, detail, fault.help.to_owned());
        }
    }
    faults.list
}

/// The end of a connector between two nodes that is reached by a session alone.
fn cut_off<'a>(
    connector: &'a PlacedConnector,
    transports: &'a BTreeMap<String, Transport>,
) -> Option<(&'a str, &'a Transport)> {
    let ends = [&connector.source.node, &connector.target.node];
    if ends[0] == ends[1] {
        return None;
    }
    let reached = |node: &&'a String| Some((node.as_str(), transports.get(*node)?));
    ends.iter().find_map(reached)
}

fn distance(source: &EndPlace, target: &EndPlace) -> Distance {
    match (source.node == target.node, source.manager == target.manager) {
        (true, true) => Distance::Process,
        (true, false) => Distance::Node,
        (false, _) => Distance::Beyond,
    }
}

fn shown(end: &EndPlace) -> String {
    format!("in manager `{}` on `{}`", end.manager, end.node)
}

fn pointer(spec: &SystemSpec, connector: &str) -> String {
    let index = spec.connectors.iter().position(|c| c.name == connector);
    index.map_or_else(String::new, |index| format!("/spec/connectors/{index}"))
}
