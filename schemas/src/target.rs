//! A part of a system: the named components and connectors as a file has them, everything else as it is stored.

mod conditions;
mod merge;
mod named;

pub use named::UnknownTarget;

use std::collections::{HashMap, HashSet};

use crate::composite;
use crate::system::{ComponentSpec, ConnectorSpec, PortRef, SystemSpec};
use merge::merged;
use named::Named;

/// The stored system in which the targets are as in `new`: `component/NAME`, `connector/NAME`, or a bare name, which is
/// a component's before it is a connector's. Without a stored system nothing but the targets is there.
///
/// A target that `new` does not have is removed, a component with its connectors. What targets cannot be without comes
/// along: a connector brings those of its components that are not stored; a component that is new or changed brings
/// those of `new`'s connectors that are not stored and whose other end is there. Conditions of orders go with the
/// component that waits.
///
/// # Errors
/// A target that neither system has.
pub fn narrow(
    stored: Option<&SystemSpec>,
    new: &SystemSpec,
    targets: &[String],
) -> Result<SystemSpec, UnknownTarget> {
    let empty = SystemSpec {
        name: new.name.clone(),
        full_id: new.full_id.clone(),
        components: Vec::new(),
        composites: Vec::new(),
        connectors: Vec::new(),
        orders: crate::system::Orders::default(),
    };
    let stored = stored.unwrap_or(&empty);
    let named = Named::resolve(targets, stored, new)?;
    let taken = taken_components(stored, new, &named);
    let components = merged(&stored.components, &new.components, &taken, |component| {
        &component.instance
    });
    let there: HashSet<&str> = components.iter().map(|c| c.instance.as_str()).collect();
    let connectors = connectors(stored, new, &named, &there);
    let orders = conditions::orders(&stored.orders, &new.orders, &taken, &there);
    let composites = composite::of_part(
        stored,
        new,
        |instance| taken.contains(instance),
        |instance| there.contains(instance),
    );
    Ok(SystemSpec {
        composites,
        name: stored.name.clone(),
        full_id: stored.full_id.clone(),
        connectors,
        orders,
        components,
    })
}

/// The components that are as in `new`: the targets, and the ends of targeted connectors that are not stored.
fn taken_components<'a>(
    stored: &'a SystemSpec,
    new: &'a SystemSpec,
    named: &Named<'a>,
) -> HashSet<&'a str> {
    let known = by_instance(stored);
    let connectors = new.connectors.iter();
    let targeted = connectors.filter(|c| named.connectors.contains(c.name.as_str()));
    let ends = targeted.flat_map(|c| [c.source.instance.as_str(), c.target.instance.as_str()]);
    let missing = ends.filter(|instance| !known.contains_key(instance));
    named.components.iter().copied().chain(missing).collect()
}

fn connectors(
    stored: &SystemSpec,
    new: &SystemSpec,
    named: &Named<'_>,
    there: &HashSet<&str>,
) -> Vec<ConnectorSpec> {
    let changed = changed(stored, new, named);
    let known: HashSet<&str> = stored.connectors.iter().map(|c| c.name.as_str()).collect();
    let comes = |connector: &&ConnectorSpec| {
        let ends = [&connector.source, &connector.target];
        let brought = ends
            .iter()
            .any(|end| changed.contains_key(end.instance.as_str()));
        brought && !known.contains(connector.name.as_str())
    };
    let brought = new.connectors.iter().filter(comes);
    let taken: HashSet<&str> = named
        .connectors
        .iter()
        .copied()
        .chain(brought.map(|connector| connector.name.as_str()))
        .collect();
    let mut all = merged(&stored.connectors, &new.connectors, &taken, |connector| {
        &connector.name
    });
    all.retain(|connector| {
        let is_taken = taken.contains(connector.name.as_str());
        let ends = [&connector.source, &connector.target];
        ends.iter().all(|end| {
            let lost = changed.get(end.instance.as_str());
            there.contains(end.instance.as_str())
                && (is_taken || lost.is_none_or(|change| !change.loses(end)))
        })
    });
    all
}

/// A targeted component before and after; `None` before when it is new.
struct Change<'a> {
    before: Option<&'a ComponentSpec>,
    after: &'a ComponentSpec,
}

impl Change<'_> {
    /// True for a port that was declared and no longer is: what was connected to it cannot be any more.
    fn loses(&self, end: &PortRef) -> bool {
        let has = |component: &ComponentSpec| component.ports.iter().any(|p| p.name == end.port);
        self.before.is_some_and(has) && !has(self.after)
    }
}

/// The targeted components that are new or not as they were.
fn changed<'a>(
    stored: &'a SystemSpec,
    new: &'a SystemSpec,
    named: &Named<'_>,
) -> HashMap<&'a str, Change<'a>> {
    let known = by_instance(stored);
    let targeted = new.components.iter();
    let targeted = targeted.filter(|c| named.components.contains(c.instance.as_str()));
    let changes = targeted.filter_map(|after| {
        let before = known.get(after.instance.as_str()).copied();
        (before != Some(after)).then_some((after.instance.as_str(), Change { before, after }))
    });
    changes.collect()
}

fn by_instance(spec: &SystemSpec) -> HashMap<&str, &ComponentSpec> {
    let components = spec.components.iter();
    components.map(|c| (c.instance.as_str(), c)).collect()
}
