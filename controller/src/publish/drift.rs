//! What was changed by hand, in words.

use std::collections::BTreeMap;

use rts_plan::plan::{Drift, DriftKind, FieldChange};
use rts_schemas::system::DriftPolicy;

use super::Scene;
use crate::store::SystemRecord;

/// Drifts by system and target.
pub type Drifts<'a> = BTreeMap<(&'a str, &'a str), &'a Drift>;

/// What the last plan found, to be looked up.
pub fn by_target(found: &[Drift]) -> Drifts<'_> {
    found
        .iter()
        .map(|drift| ((drift.system.as_str(), drift.target.as_str()), drift))
        .collect()
}

/// Those of one system, by target.
pub fn of_system<'a>(drifts: &Drifts<'a>, system: &str) -> Vec<&'a Drift> {
    let own = drifts.iter().filter(|((owner, _), _)| *owner == system);
    own.map(|(_, drift)| *drift).collect()
}

/// The whole of it: target, what was done, what differs, what becomes of it. Why it is not adopted where that was
/// `refused`.
pub fn text(drift: &Drift, refused: Option<&str>) -> String {
    let (target, reason, fields) = (&drift.target, &drift.reason, shown(drift));
    match refused.filter(|_| drift.policy == DriftPolicy::Adopt) {
        None => format!("{target} {}", told(drift)),
        Some(why) => format!("{target} {reason}{fields}; it could not be adopted yet: {why}"),
    }
}

/// The same without its target.
pub fn told(drift: &Drift) -> String {
    let (reason, fields) = (&drift.reason, shown(drift));
    format!("{reason}{fields}; it {}", fate(drift.policy))
}

/// What becomes of it.
pub fn fate(policy: DriftPolicy) -> &'static str {
    match policy {
        DriftPolicy::Repair => "is put back (rtsctl.drift: repair)",
        // Also what is to be adopted and cannot be.
        DriftPolicy::Ignore => "is left so (see rtsctl.drift)",
        DriftPolicy::Adopt => "becomes part of the stored system (rtsctl.drift: adopt)",
    }
}

/// Longest value that is shown, in characters.
const LONG: usize = 200;

/// A value as it is shown: a long one is cut.
pub fn short(text: &str) -> String {
    match text.char_indices().nth(LONG) {
        None => text.to_owned(),
        Some((end, _)) => format!("{}…", &text[..end]),
    }
}

/// What differs, one text for each field.
pub fn fields(drift: &Drift) -> Vec<String> {
    if drift.kind != DriftKind::Changed {
        return vec![drift.reason.clone()];
    }
    let field = |change: &FieldChange| {
        let text = |value: &Option<String>| short(value.as_deref().unwrap_or("none"));
        let (old, new) = (text(&change.old), text(&change.new));
        format!("{}: {old} -> {new}", change.field)
    };
    drift.fields.iter().map(field).collect()
}

/// Why a system is not healthy with a drift that is left: what it took away is missing.
pub fn misses(drift: &Drift) -> Option<String> {
    let away = drift.kind == DriftKind::Missing || drift.fields.iter().any(|f| f.field == "state");
    let left = drift.policy != DriftPolicy::Repair;
    (away && left).then(|| format!("{} and {}", drift.reason, fate(drift.policy)))
}

fn shown(drift: &Drift) -> String {
    match drift.kind {
        DriftKind::Changed if !drift.fields.is_empty() => {
            format!(" ({})", fields(drift).join(", "))
        }
        _ => String::new(),
    }
}

/// What runs in this system's managers or on its nodes and is in no spec.
pub fn made_by_hand(scene: &Scene<'_>, record: &SystemRecord) -> Vec<String> {
    let mut drift = Vec::new();
    for (node, (inventory, _)) in &scene.inventories {
        for manager in &inventory.managers {
            let mine = manager
                .key
                .system
                .as_ref()
                .is_some_and(|s| s.uid == record.uid);
            for component in manager
                .components
                .iter()
                .filter(|c| mine && c.system.is_none())
            {
                drift.push(format!(
                    "{} ({}) was made by hand in manager {} on node {node}",
                    component.instance,
                    component.type_name,
                    manager.key.display_name()
                ));
            }
        }
    }
    drift
}
