//! What differs in a component that can stay: configuration values, active set, rate, what it does without a peer.

use std::collections::BTreeMap;

use rts_schemas::system::{ComponentSpec, Configuration, DriftPolicy, OnDisconnect};

use crate::desired::PlacedComponent;
use crate::mark::{self, Mark};
use crate::observed::ComponentObserved;
use crate::plan::FieldChange;
use crate::render::names::value;

/// Why a value that nobody wrote changes.
pub(crate) const GONE: &str = " (no longer in the profile, back to its default)";

/// What changes in a component that stays.
#[derive(Debug, Default)]
pub(crate) struct InPlace {
    pub fields: Vec<FieldChange>,
    pub configuration: Configuration,
    pub rate: Option<f64>,
    pub on_disconnect: Option<OnDisconnect>,
    pub order: Option<i32>,
    pub reason: String,
}

/// A configuration value, or the active set, that is not as desired.
pub(crate) struct Setting<'a> {
    /// Set and parameter; none for the active set.
    value: Option<(&'a str, &'a str)>,
    found: Option<&'a str>,
    desired: &'a str,
    /// Nobody wrote it: the module's default.
    default: bool,
}

impl Setting<'_> {
    /// Name of the field, as changes and drifts have it.
    pub fn path(&self) -> String {
        match self.value {
            Some((set, name)) => mark::path(set, name),
            None => mark::ACTIVE.to_owned(),
        }
    }

    /// True when a person changed it, and the same is desired as then.
    pub fn is_drift(&self, mark: &Mark) -> bool {
        !mark.is_empty() && mark.covers(&self.path(), self.desired)
    }

    /// The difference, from what was desired to what is found.
    pub fn drift(&self) -> FieldChange {
        FieldChange {
            field: self.path(),
            old: Some(self.desired.to_owned()),
            new: self.found.map(str::to_owned),
        }
    }

    fn change(&self) -> FieldChange {
        FieldChange {
            field: self.path(),
            old: self.found.map(str::to_owned),
            new: Some(self.desired.to_owned()),
        }
    }

    fn name(&self) -> &str {
        self.value.map_or("the active set", |(_, name)| name)
    }

    fn reason(&self) -> String {
        let why = if self.default { GONE } else { "" };
        let (name, desired) = (self.name(), value(self.desired));
        match self.found.map(value) {
            Some(found) => format!("{name}{why} changed from {found} to {desired}"),
            None => format!("{name}{why} is now {desired}"),
        }
    }

    fn by_hand(&self) -> String {
        let (name, desired) = (self.name(), value(self.desired));
        match self.found.map(value) {
            Some(found) => format!("{name} was changed by hand from {desired} to {found}"),
            None => format!("{name} was {desired} and was taken away by hand"),
        }
    }

    fn add_to(&self, configuration: &mut Configuration) {
        let desired = self.desired.to_owned();
        match self.value {
            Some((set, name)) => {
                let set = configuration.sets.entry(set.to_owned()).or_default();
                set.insert(name.to_owned(), desired);
            }
            None => configuration.active = Some(desired),
        }
    }
}

/// What has to change in place; none when nothing does. What a person changed is set back or left, as its policy says;
/// what else differs is set.
pub(crate) fn in_place(placed: &PlacedComponent, live: &ComponentObserved) -> Option<InPlace> {
    let spec = &placed.spec;
    let mark = Mark::of(live);
    let leaves = spec.policy.drift != DriftPolicy::Repair;
    let mut change = InPlace::default();
    let (mut reasons, mut back) = (Vec::new(), Vec::new());
    for setting in &settings(spec, live) {
        match setting.is_drift(&mark) {
            true if leaves => continue,
            true => back.push(setting.by_hand()),
            false => reasons.push(setting.reason()),
        }
        setting.add_to(&mut change.configuration);
        change.fields.push(setting.change());
    }
    if let Some((rate, field)) = rate(spec, live) {
        reasons.push(reason("rate", &field));
        change.fields.push(field);
        change.rate = Some(rate);
    }
    if let Some((policy, field)) = on_disconnect(spec, live) {
        reasons.push(reason("onDisconnect", &field));
        change.fields.push(field);
        change.on_disconnect = Some(policy);
    }
    if let Some((order, field)) = order(spec, live) {
        reasons.push(reason("the order in its execution context", &field));
        change.fields.push(field);
        change.order = Some(order);
    }
    let said = [(reasons, "set in place"), (back, "set back")];
    let said = said.into_iter().filter(|(reasons, _)| !reasons.is_empty());
    let said = said.map(|(reasons, what)| format!("{}: {what}", reasons.join(", ")));
    change.reason = said.collect::<Vec<_>>().join("; ");
    (!change.reason.is_empty()).then_some(change)
}

/// Everything that differs, whoever changed it.
pub(crate) fn differences(spec: &ComponentSpec, live: &ComponentObserved) -> Vec<FieldChange> {
    let settings = settings(spec, live);
    let mut fields: Vec<_> = settings.iter().map(Setting::change).collect();
    fields.extend(rate(spec, live).map(|(_, field)| field));
    fields.extend(on_disconnect(spec, live).map(|(_, field)| field));
    fields.extend(order(spec, live).map(|(_, field)| field));
    fields
}

/// Compares configuration and active set with the spec and, where it is silent, with the defaults. Values are compared
/// as text, as they are kept.
pub(crate) fn settings<'a>(
    spec: &'a ComponentSpec,
    live: &'a ComponentObserved,
) -> Vec<Setting<'a>> {
    let found = live.configuration.active.as_deref().unwrap_or("default");
    let desired = spec.configuration.active.as_deref().unwrap_or("default");
    let active = (found != desired).then_some(Setting {
        value: None,
        found: Some(found),
        desired,
        default: false,
    });
    let mut all: Vec<_> = active.into_iter().collect();
    if spec.configuration.sets == live.configuration.sets {
        // Nothing is there that nobody wrote.
        return all;
    }
    for (set, values) in values(spec, live) {
        let own = live.configuration.sets.get(set);
        let written = spec.configuration.sets.get(set);
        for (name, desired) in values {
            let found = own.and_then(|own| own.get(name));
            if found != Some(desired) {
                all.push(Setting {
                    value: Some((set, name)),
                    found: found.map(String::as_str),
                    desired,
                    default: !written.is_some_and(|written| written.contains_key(name)),
                });
            }
        }
    }
    all
}

/// The rate, compared with the spec only.
fn rate(spec: &ComponentSpec, live: &ComponentObserved) -> Option<(f64, FieldChange)> {
    let rate = spec.execution_context.rate?;
    let field = || FieldChange {
        field: "rate".to_owned(),
        old: Some(live.rate.to_string()),
        new: Some(rate.to_string()),
    };
    (!same_rate(rate, live.rate)).then(|| (rate, field()))
}

/// The place among the components of its execution context, compared where it is in one and stays there.
fn order(spec: &ComponentSpec, live: &ComponentObserved) -> Option<(i32, FieldChange)> {
    let (wanted, shared) = (&spec.execution_context, live.execution_context.as_ref()?);
    let differs = wanted.name.as_ref() == Some(&shared.name) && wanted.order != shared.order;
    let field = || FieldChange {
        field: "executionContext.order".to_owned(),
        old: Some(shared.order.to_string()),
        new: Some(wanted.order.to_string()),
    };
    differs.then(|| (wanted.order, field()))
}

/// The policy without a peer, compared always.
fn on_disconnect(
    spec: &ComponentSpec,
    live: &ComponentObserved,
) -> Option<(OnDisconnect, FieldChange)> {
    let policy = spec.policy.on_disconnect;
    let field = || FieldChange {
        field: "onDisconnect".to_owned(),
        old: Some(live.on_disconnect.as_str().to_owned()),
        new: Some(policy.as_str().to_owned()),
    };
    (policy != live.on_disconnect).then(|| (policy, field()))
}

fn reason(name: &str, field: &FieldChange) -> String {
    let text = |value: &Option<String>| value.clone().unwrap_or_default();
    let (old, new) = (text(&field.old), text(&field.new));
    format!("{name} changed from {old} to {new}")
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
