//! What differs in a component that can stay: configuration values, active set, rate, what it does without a peer.

use std::collections::BTreeMap;

use rts_schemas::system::{ComponentSpec, Configuration, OnDisconnect};

use crate::observed::ComponentObserved;
use crate::plan::FieldChange;

/// Why a value that nobody wrote changes.
pub(crate) const GONE: &str = " (no longer in the profile, back to its default)";

/// What changes in a component that stays.
#[derive(Debug)]
pub(crate) struct InPlace {
    pub fields: Vec<FieldChange>,
    pub configuration: Configuration,
    pub rate: Option<f64>,
    pub on_disconnect: Option<OnDisconnect>,
    pub reason: String,
}

/// Compares configuration and active set with the spec and, where it is silent, with the defaults; the rate only with
/// the spec, and the policy without a peer always. Values are compared as text, as they are kept. None when nothing differs.
pub(crate) fn in_place(spec: &ComponentSpec, live: &ComponentObserved) -> Option<InPlace> {
    let mut change = InPlace {
        fields: Vec::new(),
        configuration: Configuration::default(),
        rate: None,
        on_disconnect: None,
        reason: String::new(),
    };
    let mut reasons = Vec::new();
    let mut field = |path: String, name: &str, old: Option<String>, new: String, why: &str| {
        reasons.push(match &old {
            Some(old) => format!("{name}{why} changed from {old} to {new}"),
            None => format!("{name}{why} is now {new}"),
        });
        change.fields.push(FieldChange {
            field: path,
            old,
            new: Some(new),
        });
    };
    let old = live.configuration.active.as_deref().unwrap_or("default");
    let active = spec.configuration.active.as_deref().unwrap_or("default");
    if old != active {
        let path = "configuration.active".to_owned();
        field(
            path,
            "the active set",
            Some(old.to_owned()),
            active.to_owned(),
            "",
        );
        change.configuration.active = Some(active.to_owned());
    }
    for (set, values) in values(spec, live) {
        for (name, new) in values {
            let old = live.configuration.sets.get(set).and_then(|s| s.get(name));
            if old == Some(new) {
                continue;
            }
            let path = format!("configuration.{set}.{name}");
            let written = spec.configuration.sets.get(set);
            let written = written.is_some_and(|values| values.contains_key(name));
            let why = if written { "" } else { GONE };
            field(path, name, old.cloned(), new.clone(), why);
            let sets = &mut change.configuration.sets;
            sets.entry(set.to_owned())
                .or_default()
                .insert(name.to_owned(), new.clone());
        }
    }
    if let Some(rate) = spec.execution_context.rate
        && !same_rate(rate, live.rate)
    {
        let old = Some(live.rate.to_string());
        field("rate".to_owned(), "rate", old, rate.to_string(), "");
        change.rate = Some(rate);
    }
    let policy = spec.policy.on_disconnect;
    if policy != live.on_disconnect {
        let (name, old) = ("onDisconnect", live.on_disconnect.as_str());
        let (old, new) = (Some(old.to_owned()), policy.as_str().to_owned());
        field(name.to_owned(), name, old, new, "");
        change.on_disconnect = Some(policy);
    }
    if reasons.is_empty() {
        return None;
    }
    change.reason = format!("{}: set in place", reasons.join(", "));
    Some(change)
}

/// Every value that a component is to have, by set and name: what the spec names; for the rest of what it has, the
/// module's default, where the module has one.
fn values<'a>(
    spec: &'a ComponentSpec,
    live: &'a ComponentObserved,
) -> BTreeMap<&'a str, BTreeMap<&'a str, &'a String>> {
    let mut all: BTreeMap<&str, BTreeMap<&str, &String>> = BTreeMap::new();
    for (set, has) in &live.configuration.sets {
        let known = has
            .keys()
            .filter_map(|name| live.defaults.get_key_value(name));
        let known = known.map(|(name, value)| (name.as_str(), value));
        all.entry(set).or_default().extend(known);
    }
    for (set, written) in &spec.configuration.sets {
        let written = written.iter().map(|(name, value)| (name.as_str(), value));
        all.entry(set).or_default().extend(written);
    }
    all
}

/// A period is kept in whole nanoseconds, so that a rate may come back a little off.
fn same_rate(one: f64, other: f64) -> bool {
    one == other || (one - other).abs() <= 1e-6 * one.abs().max(other.abs())
}

#[cfg(test)]
mod tests {
    use super::same_rate;

    #[test]
    fn rates_may_be_rounded_to_a_period() {
        assert!(same_rate(300.0, 1e9 / 3_333_333.0));
        assert!(!same_rate(300.0, 301.0));
    }
}
