//! What differs in a component that can stay: configuration values, active set, rate.

use rts_schemas::system::{ComponentSpec, Configuration};

use crate::observed::ComponentObserved;
use crate::plan::FieldChange;

/// What changes in a component that stays.
#[derive(Debug)]
pub(crate) struct InPlace {
    pub fields: Vec<FieldChange>,
    pub configuration: Configuration,
    pub rate: Option<f64>,
    pub reason: String,
}

/// Compares configuration, active set and rate; only what the spec names. None when nothing differs.
pub(crate) fn in_place(spec: &ComponentSpec, live: &ComponentObserved) -> Option<InPlace> {
    let mut change = InPlace {
        fields: Vec::new(),
        configuration: Configuration::default(),
        rate: None,
        reason: String::new(),
    };
    let mut reasons = Vec::new();
    let mut field = |path: String, name: &str, old: Option<String>, new: String| {
        reasons.push(match &old {
            Some(old) => format!("{name} changed from {old} to {new}"),
            None => format!("{name} is now {new}"),
        });
        change.fields.push(FieldChange {
            field: path,
            old,
            new: Some(new),
        });
    };
    if let Some(active) = &spec.configuration.active {
        let old = live.configuration.active.as_deref().unwrap_or("default");
        if old != active {
            let path = "configuration.active".to_owned();
            field(path, "the active set", Some(old.to_owned()), active.clone());
            change.configuration.active = Some(active.clone());
        }
    }
    for (set, values) in &spec.configuration.sets {
        for (name, new) in values {
            let old = live.configuration.sets.get(set).and_then(|s| s.get(name));
            if old.is_some_and(|old| same_value(old, new)) {
                continue;
            }
            let path = format!("configuration.{set}.{name}");
            field(path, name, old.cloned(), new.clone());
            let sets = &mut change.configuration.sets;
            sets.entry(set.clone())
                .or_default()
                .insert(name.clone(), new.clone());
        }
    }
    if let Some(rate) = spec.execution_context.rate
        && !same_rate(rate, live.rate)
    {
        let old = Some(live.rate.to_string());
        field("rate".to_owned(), "rate", old, rate.to_string());
        change.rate = Some(rate);
    }
    if reasons.is_empty() {
        return None;
    }
    change.reason = format!("{}: set in place", reasons.join(", "));
    Some(change)
}

/// Equal as text, or equal as numbers.
fn same_value(one: &str, other: &str) -> bool {
    if one == other {
        return true;
    }
    match (one.trim().parse::<i128>(), other.trim().parse::<i128>()) {
        (Ok(one), Ok(other)) => one == other,
        _ => match (one.trim().parse::<f64>(), other.trim().parse::<f64>()) {
            (Ok(one), Ok(other)) => one == other,
            _ => false,
        },
    }
}

/// A period is kept in whole nanoseconds, so that a rate may come back a little off.
fn same_rate(one: f64, other: f64) -> bool {
    one == other || (one - other).abs() <= 1e-6 * one.abs().max(other.abs())
}

#[cfg(test)]
mod tests {
    use super::{same_rate, same_value};

    #[test]
    fn numbers_are_compared_as_numbers() {
        for (one, other) in [
            ("1.0", "1"),
            ("1e3", " 1000 "),
            ("-0", "0.0"),
            ("a", "a"),
            ("nan", "nan"),
        ] {
            assert!(same_value(one, other), "{one} {other}");
        }
        let big = ("9007199254740993", "9007199254740992");
        for (one, other) in [("1.0", "1.1"), ("a", "b"), ("", "0"), ("1,2", "1,3"), big] {
            assert!(!same_value(one, other), "{one} {other}");
        }
    }

    #[test]
    fn rates_may_be_rounded_to_a_period() {
        assert!(same_rate(300.0, 1e9 / 3_333_333.0));
        assert!(!same_rate(300.0, 301.0));
    }
}
