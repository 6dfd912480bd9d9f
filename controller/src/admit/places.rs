//! Where the components of a system are: settled when it is admitted.

use std::collections::BTreeMap;

use rts_plan::Placed;
use rts_schemas::system::{ComponentSpec, SystemSpec};

use crate::core::Core;
use crate::store::SystemRecord;

/// Places that stay: of components whose host means no node now, as long as it is the host that it was.
pub fn kept(core: &Core, stored: &SystemRecord, spec: &SystemSpec) -> BTreeMap<String, String> {
    let records = core.registry().systems.clone();
    let hosts = rts_plan::Hosts::new(&core.facts(&records), &core.local_node);
    let old = stored.spec.components.iter();
    let old: BTreeMap<&str, &ComponentSpec> = old.map(|c| (c.instance.as_str(), c)).collect();
    let stays = |component: &&ComponentSpec| {
        let placement = &component.placement;
        let (None, Some(host)) = (&placement.node, &placement.host) else {
            return false;
        };
        let same = old.get(component.instance.as_str()).is_some_and(|old| {
            (&old.placement.node, &old.placement.host) == (&placement.node, &placement.host)
        });
        same && hosts.node(host).is_none()
    };
    let components = spec.components.iter().filter(stays);
    components
        .filter_map(|c| stored.places.get_key_value(&c.instance))
        .map(|(instance, node)| (instance.clone(), node.clone()))
        .collect()
}

/// Places of a record of an older program, which kept none, once every host that it names is known.
pub fn places_of_old(
    core: &Core,
    placed: &Placed,
    record: &SystemRecord,
) -> Option<BTreeMap<String, String>> {
    if !record.places.is_empty() || record.deleted.is_some() {
        return None;
    }
    let hosts = rts_plan::Hosts::new(&core.facts(&BTreeMap::new()), &core.local_node);
    let known = |component: &ComponentSpec| {
        let placement = &component.placement;
        let host = placement.host.as_ref().filter(|_| placement.node.is_none());
        host.is_none_or(|host| hosts.node(host).is_some())
    };
    let all = record.spec.components.iter().all(known);
    all.then(|| places(placed, &record.uid))
        .filter(|places| !places.is_empty())
}

/// Instance → node of one system.
pub fn places(placed: &Placed, uid: &str) -> BTreeMap<String, String> {
    let nodes = placed.desired.nodes.iter();
    let parts = nodes.flat_map(|(node, spec)| spec.systems.iter().map(move |part| (node, part)));
    parts
        .filter(|(_, part)| part.system.uid == uid)
        .flat_map(|(node, part)| part.components.iter().map(move |c| (node, c)))
        .map(|(node, component)| (component.spec.instance.clone(), node.clone()))
        .collect()
}
