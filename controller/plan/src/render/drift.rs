//! What a person changed by hand.

use rts_schemas::system::DriftPolicy;

use super::describe::side;
use super::names::{field, tame};
use crate::plan::{Drift, DriftKind};

/// `component/Filter0  gain: 1.0 -> 2.0 by hand (ignored)`.
pub fn drift(drift: &Drift) -> String {
    let fate = match drift.policy {
        DriftPolicy::Repair => "repaired",
        DriftPolicy::Ignore => "ignored",
        DriftPolicy::Adopt => "adopted",
    };
    let fields = drift.fields.iter().map(|f| {
        let (name, old, new) = (field(&f.field), side(f, &f.old), side(f, &f.new));
        format!("{}: {old} -> {new}", tame(&name))
    });
    let fields: Vec<String> = fields.collect();
    let what = match drift.kind {
        DriftKind::Changed if !fields.is_empty() => format!("{} by hand", fields.join(", ")),
        _ => tame(&drift.reason).into_owned(),
    };
    format!("{}  {what} ({fate})", tame(&drift.target))
}
