//! The end of a deletion: a system is forgotten once every node it ever ran on has said that nothing of it is left.

use std::collections::BTreeSet;
use std::sync::Arc;

use rts_host::timing::TARGET;
use rts_plan::desired::SystemRef;
use rts_plan::observed::{Inventory, NodeObserved, Observed};

use tracing::{Instrument, info_span};

use super::node_specs::NodeSpecs;
use crate::core::Core;
use crate::node_numbers;
use crate::store::{StoreError, SystemRecord, Write};
use crate::view::Happening;

/// Forgets systems that are gone. True when there was one: the nodes' specs change once more.
///
/// Systems with a run are left out: what was seen of them is older than what their steps have done.
pub async fn finish(core: &Core, specs: &NodeSpecs, busy: &BTreeSet<String>) -> bool {
    let observed = core.world().observed.clone();
    let systems = core.registry().systems.clone();
    let mut any = false;
    let pending = core.registry().pending.clone();
    let ending =
        |record: &&Arc<SystemRecord>| record.deleted.is_some() && !pending.contains(record.name());
    for record in systems.values().filter(ending) {
        if busy.contains(&record.uid) || !is_gone(core, specs, &observed, record) {
            continue;
        }
        let name = record.name().to_owned();
        match remove(core, record).await {
            Ok(true) => {}
            Ok(false) => continue,
            Err(e) => {
                tracing::error!(system = name, error = %rts_host::error::chain(&e), "a system cannot be removed");
                continue;
            }
        }
        core.backoff().forget_system(&name);
        let event = Happening::normal("Deleted", &format!("system/{name}"), "nothing of it runs");
        core.record(event.of(Some(&name)));
        any = true;
    }
    if any {
        core.publish();
    }
    any
}

/// Removes a system, and gives its nodes the numbers that they are told so with. False when it was changed meanwhile.
async fn remove(core: &Core, record: &Arc<SystemRecord>) -> Result<bool, StoreError> {
    let _admission = core.admission.lock().await;
    let name = record.name();
    let mut records = core.registry().systems.clone();
    if records.remove(name).as_ref() != Some(record) {
        return Ok(false);
    }
    let placed = core.place_all(&records);
    let numbers = core.next_numbers(&core.registry(), &placed);
    let mut writes = vec![Write::RemoveSystem(name.to_owned())];
    writes.extend(node_numbers::writes(&numbers));
    let span = info_span!(target: TARGET, "store", of = format!("end of system/{name}"));
    core.store.write(writes).instrument(span).await?;
    let mut registry = core.registry();
    registry.systems.remove(name);
    registry.numbered(&numbers);
    Ok(true)
}

fn is_gone(core: &Core, specs: &NodeSpecs, observed: &Observed, record: &SystemRecord) -> bool {
    let asked = record.nodes.difference(&record.forgotten);
    asked.into_iter().all(|node| {
        let stored = core
            .sessions
            .get(node)
            .is_some_and(|entry| specs.acked(node, &entry.session.id).is_some());
        let empty = match observed.nodes.get(node) {
            Some(NodeObserved::Known(inventory)) => is_free_of(inventory, &record.uid),
            _ => false,
        };
        stored && empty
    })
}

/// True when nothing of a system is left on a node.
pub fn is_free_of(inventory: &Inventory, uid: &str) -> bool {
    let of = |system: &Option<SystemRef>| system.as_ref().is_some_and(|s| s.uid == uid);
    inventory.managers.iter().all(|manager| {
        !of(&manager.key.system) && !manager.components.iter().any(|c| of(&c.system))
    })
}
