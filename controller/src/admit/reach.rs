//! Interface types of connectors that do not reach from one end to the other.

use rts_controller_api::ProblemError;
use rts_plan::Placed;
use rts_plan::desired::EndPlace;
use rts_schemas::connector::{Distance, read};
use rts_schemas::system::SystemSpec;

use super::check::Faults;
use crate::store::SystemRecord;

/// A fault for each connector of a candidate that can never be made where its components were placed.
pub fn reach(placed: &Placed, candidate: &SystemRecord) -> Vec<ProblemError> {
    let mut faults = Faults::default();
    let parts = placed.desired.nodes.iter();
    let parts = parts.flat_map(|(node, spec)| spec.systems.iter().map(move |part| (node, part)));
    for (node, part) in parts.filter(|(_, part)| part.system.uid == candidate.uid) {
        // It stands on the nodes of both of its ends.
        for connector in part.connectors.iter().filter(|c| c.source.node == *node) {
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
