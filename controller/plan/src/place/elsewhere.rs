//! Which components that the orders of a system name lie on other nodes, and which of a node's own may still run there.

use std::collections::{BTreeMap, BTreeSet};

use rts_schemas::system::{SystemSpec, WaitFor};

use crate::desired::{Elsewhere, NodeSystem};
use crate::order::all;

/// The components of a system that any of its orders names, with their nodes.
pub(super) fn named<'a>(
    spec: &'a SystemSpec,
    nodes: &BTreeMap<&str, String>,
) -> BTreeMap<&'a str, Elsewhere> {
    let lists = all(&spec.orders);
    let mut names: BTreeSet<&str> = BTreeSet::new();
    for condition in lists.iter().flat_map(|(_, list)| *list) {
        names.insert(&condition.target);
        if let Some(WaitFor::Preceding { components, .. }) = &condition.wait {
            names.extend(components.iter().map(String::as_str));
        }
    }
    let own = spec.components.iter();
    let own = own.filter(|component| names.contains(component.instance.as_str()));
    own.filter_map(|component| {
        let name = component.instance.as_str();
        let there = Elsewhere {
            node: nodes.get(name)?.clone(),
            required: component.required,
        };
        Some((name, there))
    })
    .collect()
}

/// Those of them that are not on this node.
pub(super) fn elsewhere(
    named: &BTreeMap<&str, Elsewhere>,
    node: &str,
) -> BTreeMap<String, Elsewhere> {
    let others = named.iter().filter(|(_, there)| there.node != node);
    others
        .map(|(name, there)| ((*name).to_owned(), there.clone()))
        .collect()
}

/// Says of a node's own components where else they may still run: of several places one, since each of them is enough.
pub(super) fn may_still_run(
    part: &mut NodeSystem,
    node: &str,
    left: &BTreeMap<String, BTreeSet<String>>,
) {
    for component in &part.components {
        let spec = &component.spec;
        let nodes = left.get(&spec.instance).into_iter().flatten();
        let Some(there) = nodes.into_iter().find(|there| *there != node) else {
            continue;
        };
        let there = Elsewhere {
            node: there.clone(),
            required: spec.required,
        };
        part.elsewhere.insert(spec.instance.clone(), there);
    }
}
