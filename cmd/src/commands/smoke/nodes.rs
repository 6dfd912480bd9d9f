//! Which agents a system needs: one for each host that its profile names, and for each node that it names outright.

use std::collections::{BTreeMap, BTreeSet};

use rts_schemas::names::dns_label;
use rts_schemas::system::SystemSpec;

use crate::error::CliError;
use crate::local::LOCAL_NODE;
use crate::local::nodes::NodeSetup;

/// Most agents of one smoke test.
const MAX_NODES: usize = 16;
/// Longest name that is made of a host's: sockets lie below a folder of that name.
const MAX_NAME: usize = 32;

/// The nodes of a system; the first one takes what names neither a node nor a host.
pub fn of(spec: &SystemSpec) -> Result<Vec<NodeSetup>, CliError> {
    let placements = || spec.components.iter().map(|c| &c.placement);
    let named: BTreeSet<&str> = placements().filter_map(|p| p.node.as_deref()).collect();
    for name in &named {
        name.parse::<NodeSetup>().map_err(CliError::usage)?;
    }
    let homeless = placements().any(|p| p.node.is_none() && p.host.is_none());
    let mut nodes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    nodes.extend(named.iter().map(|name| ((*name).to_owned(), Vec::new())));
    let hosts: BTreeSet<String> = placements()
        .filter(|p| p.node.is_none())
        .filter_map(|p| p.host.as_deref())
        .map(plain)
        .collect();
    for host in hosts {
        if !nodes.keys().any(|name| plain(name) == host) {
            let name = name_for(&host, &nodes);
            nodes.insert(name, vec![host]);
        }
    }
    let local = nodes.remove(LOCAL_NODE);
    let mut all: Vec<NodeSetup> = Vec::new();
    if local.is_some() || homeless || nodes.is_empty() {
        all.push(NodeSetup::named(LOCAL_NODE));
    }
    all.extend(nodes.into_iter().map(|(name, hosts)| NodeSetup {
        name,
        aliases: Some(hosts),
        ssh: None,
    }));
    if all.len() > MAX_NODES {
        return Err(CliError::usage_help(
            format!("the system is spread over {} nodes", all.len()),
            format!(
                "a smoke test starts {MAX_NODES} agents at most: put some on one node in an overlay"
            ),
        ));
    }
    Ok(all)
}

/// A host in the form in which two spellings of one are the same.
fn plain(host: &str) -> String {
    host.trim_end_matches('.').to_ascii_lowercase()
}

/// A short name that no other node has.
fn name_for(host: &str, nodes: &BTreeMap<String, Vec<String>>) -> String {
    let label = dns_label(host).unwrap_or_else(|| "host".to_owned());
    let mut short: String = label.chars().take(MAX_NAME).collect();
    short.truncate(short.trim_end_matches('-').len());
    let numbered = (2..).map(|n| format!("{short}-{n}"));
    let mut names = std::iter::once(short.clone()).chain(numbered);
    let free = names.find(|name| name != LOCAL_NODE && !nodes.contains_key(name));
    free.unwrap_or(short)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rts_schemas::system::{ComponentSpec, Placement};

    fn component(node: Option<&str>, host: Option<&str>) -> ComponentSpec {
        ComponentSpec {
            placement: Placement {
                node: node.map(str::to_owned),
                host: host.map(str::to_owned),
                ..Placement::default()
            },
            ..ComponentSpec::default()
        }
    }

    fn nodes(components: &[(Option<&str>, Option<&str>)]) -> Vec<String> {
        let spec = SystemSpec {
            composites: Vec::new(),
            name: "s".to_owned(),
            full_id: String::new(),
            components: components.iter().map(|(n, h)| component(*n, *h)).collect(),
            connectors: Vec::new(),
            orders: Default::default(),
        };
        let all = of(&spec).unwrap().into_iter();
        all.map(|node| format!("{}={}", node.name, node.hosts().join(",")))
            .collect()
    }

    #[test]
    fn a_system_without_hosts_needs_the_local_node_alone() {
        assert_eq!(nodes(&[(None, None)]), ["local="]);
        assert_eq!(nodes(&[]), ["local="]);
    }

    #[test]
    fn each_host_and_each_node_that_is_named_gets_an_agent() {
        assert_eq!(
            nodes(&[
                (None, Some("Robot1.local")),
                (None, Some("robot1.local.")),
                (None, Some("192.168.0.7")),
                (Some("arm"), Some("elsewhere")),
            ]),
            [
                "192-168-0-7=192.168.0.7",
                "arm=",
                "robot1-local=robot1.local"
            ]
        );
        assert_eq!(
            nodes(&[(Some("arm"), None), (None, None)]),
            ["local=", "arm="]
        );
        assert_eq!(nodes(&[(Some("Arm"), None), (None, Some("arm"))]), ["Arm="]);
        assert_eq!(nodes(&[(Some("local"), None)]), ["local="]);
    }

    #[test]
    fn names_that_are_made_of_hosts_are_short_and_differ() {
        let long = "a".repeat(40);
        let (one, two) = (format!("{long}1"), format!("{long}2"));
        let short = "a".repeat(32);
        assert_eq!(
            nodes(&[(None, Some(&one)), (None, Some(&two))]),
            [format!("{short}={one}"), format!("{short}-2={two}")]
        );
    }

    #[test]
    fn too_many_are_refused() {
        let hosts: Vec<String> = (0..17).map(|n| format!("h{n}")).collect();
        let spec = SystemSpec {
            composites: Vec::new(),
            name: "s".to_owned(),
            full_id: String::new(),
            components: hosts.iter().map(|h| component(None, Some(h))).collect(),
            connectors: Vec::new(),
            orders: Default::default(),
        };
        assert_eq!(of(&spec).unwrap_err().exit().code(), 2);
    }
}
