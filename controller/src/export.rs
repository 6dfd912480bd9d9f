//! A system as it runs, as a spec that may be applied.

use std::collections::BTreeSet;
use std::sync::Arc;

use rts_controller_api::Problem;
use rts_controller_api::requests::Exported;
use rts_plan::observed::{NodeObserved, Observed};

use crate::apply::missing;
use crate::core::Core;
use crate::store::SystemRecord;

/// The stored system with what was changed by hand, as of now, and remarks on what could not be seen.
pub async fn export(core: &Arc<Core>, name: &str) -> Result<Exported, Problem> {
    stored(core, name)?;
    let observed = core.observe().await;
    // What may be taken back is told to nobody.
    core.durable(name).await;
    // Without an await between them, the record is the one that is placed.
    let record = stored(core, name)?;
    let drift = rts_plan::drift(&core.place(None).desired, &observed);
    let (spec, folded) = rts_plan::with_drift(&record.spec, &drift, |_| true);
    let mut notes = unseen(&record, &observed);
    notes.extend(folded);
    Ok(Exported { spec, notes })
}

fn stored(core: &Core, name: &str) -> Result<Arc<SystemRecord>, Problem> {
    let record = core.registry().systems.get(name).cloned();
    let record = record.ok_or_else(|| missing(name))?;
    if record.deleted.is_some() {
        let detail = format!("system {name} is being taken down: what is left of it is no system");
        return Err(Problem::conflict("terminating", detail));
    }
    Ok(record)
}

/// What is written as it was applied, since nobody sees how it is.
fn unseen(record: &SystemRecord, observed: &Observed) -> Vec<String> {
    let mut notes = Vec::new();
    let mut seen = BTreeSet::new();
    let mut dark = BTreeSet::new();
    for (node, answer) in &observed.nodes {
        let NodeObserved::Known(inventory) = answer else {
            dark.insert(node);
            continue;
        };
        let live = inventory.managers.iter().filter(|m| m.responsive);
        let all = live.flat_map(|manager| &manager.components);
        let own = all.filter(|c| c.system.as_ref().is_some_and(|s| s.uid == record.uid));
        seen.extend(own.map(|component| component.instance.as_str()));
    }
    for component in &record.spec.components {
        let instance = &component.instance;
        if seen.contains(instance.as_str()) {
            continue;
        }
        let node = record
            .places
            .get(instance)
            .filter(|node| dark.contains(node));
        let why = match node {
            Some(node) => format!("cannot be seen (node {node} is unknown)"),
            None => "does not run, or does not answer".to_owned(),
        };
        notes.push(format!(
            "component/{instance} {why}: it is written as applied"
        ));
    }
    notes
}
