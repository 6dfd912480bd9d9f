//! Which node each component goes to: the one that is named outright, then the one that was settled, then the one that its
//! host means, then the local one.

use std::collections::{BTreeMap, BTreeSet};

use super::{NodeFacts, PlaceError, Placed, Settled, StoredSystem};

/// Which node a host means: host name, alias or node name, in lower case → node name.
#[derive(Debug)]
pub struct Hosts(BTreeMap<String, String>);

impl Hosts {
    /// Of these nodes and the local one.
    pub fn new(nodes: &[NodeFacts], local: &str) -> Self {
        let mut hosts = BTreeMap::from([(lower(local), local.to_owned())]);
        for node in nodes {
            for alias in &node.aliases {
                hosts
                    .entry(lower(alias))
                    .or_insert_with(|| node.name.clone());
            }
        }
        // Names last: a name beats another node's alias.
        for node in nodes {
            hosts.insert(lower(&node.name), node.name.clone());
        }
        Self(hosts)
    }

    /// The node that a host means, when there is one.
    pub fn node(&self, host: &str) -> Option<&String> {
        self.0.get(&lower(host))
    }
}

fn lower(host: &str) -> String {
    host.trim_end_matches('.').to_ascii_lowercase()
}

/// Instance → node.
pub(super) fn choose_nodes<'a>(
    placed: &mut Placed,
    system: &'a StoredSystem,
    settled: &Settled,
    hosts: &Hosts,
    local: &str,
) -> BTreeMap<&'a str, String> {
    let known: BTreeSet<&String> = hosts.0.values().collect();
    let mut hinted: BTreeMap<(&str, String), Vec<&str>> = BTreeMap::new();
    let mut chosen = BTreeMap::new();
    for component in &system.spec.components {
        let placement = &component.placement;
        let node = match (&placement.node, &placement.host) {
            (Some(node), _) => {
                if !known.contains(node) && !system.deleting {
                    placed.problems.push(PlaceError::UnknownNode {
                        system: system.reference.name.clone(),
                        component: component.instance.clone(),
                        node: node.clone(),
                        known: known.iter().copied().cloned().collect(),
                    });
                }
                node.clone()
            }
            (None, host) => {
                let settled = settled.places.get(&component.instance);
                let meant = || hosts.node(host.as_ref()?);
                let node = settled.or_else(meant).map_or(local, String::as_str);
                if let Some(host) = host {
                    let named = hinted.entry((host, node.to_owned())).or_default();
                    named.push(&component.instance);
                }
                node.to_owned()
            }
        };
        chosen.insert(component.instance.as_str(), node);
    }
    if !system.deleting && !hinted.is_empty() {
        let notes = hinted
            .into_iter()
            .map(|((host, node), instances)| host_note(host, &node, &instances, hosts, local))
            .collect();
        placed.notes.insert(system.reference.name.clone(), notes);
    }
    chosen
}

fn host_note(host: &str, node: &str, instances: &[&str], hosts: &Hosts, local: &str) -> String {
    let instances = instances.join(", ");
    match hosts.node(host) {
        Some(meant) if meant != node => format!(
            "host {host} is node {meant} by now; apply again to move there what is on node {node}: {instances}"
        ),
        None if node == local => {
            format!("host {host} is no known node, so node {local} takes its place: {instances}")
        }
        _ => format!("host {host} is node {node}: {instances}"),
    }
}
