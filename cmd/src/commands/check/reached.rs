//! Connectors that no transport carries: one end is on a node of this home that is reached by SSH alone.

use std::collections::BTreeMap;

use rts_plan::desired::{PlacedConnector, SystemRef};
use rts_plan::{NodeFacts, StoredSystem, place};
use rts_schemas::check::System;
use rts_schemas::diagnostic::{Finding, Report};

use crate::local::nodes::{NodeSetup, Nodes};

/// Each of them, at the line of the connector, as an apply would refuse it with the nodes that the home knows now.
pub(super) fn cut_off(system: &System, nodes: &Nodes) -> Report {
    let mut report = Report::default();
    if nodes.by_ssh().next().is_none() {
        return report;
    }
    let facts = nodes.all().iter().map(|node| NodeFacts {
        name: node.name.clone(),
        aliases: node.hosts().to_vec(),
    });
    let facts: Vec<_> = facts.collect();
    let stored = StoredSystem {
        reference: SystemRef {
            name: system.spec.name.clone(),
            uid: String::new(),
        },
        spec: system.spec.clone(),
        module_digests: BTreeMap::new(),
        stand_ins: BTreeMap::new(),
        deleting: false,
    };
    let placed = place(&[stored], &facts, nodes.first());
    let parts = placed.desired.nodes.iter();
    // It stands on the nodes of both of its ends.
    let connectors = parts.flat_map(|(node, spec)| {
        let all = spec.systems.iter().flat_map(|part| &part.connectors);
        all.filter(move |connector| connector.source.node == *node)
    });
    for connector in connectors {
        let between = |node: &&NodeSetup| {
            let ends = [&connector.source.node, &connector.target.node];
            ends[0] != ends[1] && ends.contains(&&node.name)
        };
        if let Some(node) = nodes.by_ssh().find(between) {
            report.push(finding(system, connector, node));
        }
    }
    report
}

fn finding(system: &System, connector: &PlacedConnector, node: &NodeSetup) -> Finding {
    let (spec, name) = (&connector.spec, &node.name);
    let destination = node.ssh.as_ref().map(|ssh| ssh.destination.to_string());
    let message = format!(
        "`{}` and `{}` are on the nodes `{}` and `{}`, and no samples get to or from `{name}`: it is reached by ssh alone ({})",
        spec.source,
        spec.target,
        connector.source.node,
        connector.target.node,
        destination.unwrap_or_default(),
    );
    let index = system
        .spec
        .connectors
        .iter()
        .position(|c| c.name == spec.name);
    let pointer = index.map(|index| format!("/connectors/{index}"));
    let place = pointer.and_then(|pointer| system.places.find(&pointer).cloned());
    Finding::error("no-transport", message).at(place).help(format!(
        "place both components on the same node (`rtsctl.node`); node {name} carries commands through its session, and no samples"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::local::home::Home;
    use rts_schemas::overlay;

    const HELLO: &[u8] = include_bytes!("../../../../manifests/hello/system.xml");
    const SPREAD: &[u8] = include_bytes!("../../../../manifests/hello/nodes.yaml");

    fn found(nodes: &str) -> Vec<String> {
        let temp = tempfile::tempdir().unwrap();
        let home = Home::settle(Some(temp.path().to_owned())).unwrap();
        std::fs::create_dir(home.state()).unwrap();
        std::fs::write(home.state().join("nodes.json"), nodes).unwrap();
        let overlay = overlay::read_any("nodes.yaml", SPREAD).unwrap();
        let system = rts_schemas::check::system("system.xml", HELLO, None, &[overlay], None);
        let report = cut_off(&system.unwrap(), &Nodes::of(&home).unwrap());
        report.findings.iter().map(|f| format!("{f:?}")).collect()
    }

    #[test]
    fn a_connector_from_a_node_that_is_reached_by_ssh_is_found_at_its_line() {
        let local = r#"{"nodes": [{"name": "base"}, {"name": "arm"}]}"#;
        assert_eq!(found(local), [""; 0]);
        let by_ssh = local.replace(
            r#"{"name": "arm"}"#,
            r#"{"name": "arm", "ssh": {"destination": {"host": "robot"}}}"#,
        );
        let found = found(&by_ssh);
        // From arm to base, and back.
        assert_eq!(found.len(), 2, "{found:#?}");
        assert!(found[0].contains("no-transport") && found[0].contains("reached by ssh alone"));
        assert!(found.iter().all(|f| f.contains("system.xml")), "{found:#?}");
    }
}
