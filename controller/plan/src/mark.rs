//! The mark of a configuration that was changed by hand ([`ByHand::configured`](crate::observed::ByHand)): which
//! values, and over which wishes.
//!
//! To a manager it is a text without a meaning. Agents make it, planners read it. It is JSON, an object from the path
//! of a value, as [`FieldChange`](crate::plan::FieldChange) has it, to the values that were, or counted as, desired
//! while it was changed by hand, the newest last:
//!
//! ```json
//! {"configuration.default.gain":["1.0","2.0","3.0"]}
//! ```
//!
//! A value that differs is drift as long as one of them is desired. Where changes by hand are adopted, each value that a
//! person sets is one of them: adopted, it is desired, and what the person sets meanwhile is drift all the same.

use std::collections::BTreeMap;

use rts_schemas::system::{Configuration, DriftPolicy};
use serde::{Deserialize, Serialize};

use crate::desired::PlacedComponent;
use crate::in_place::settings;
use crate::observed::ComponentObserved;

/// Path of the active configuration set.
pub const ACTIVE: &str = "configuration.active";
/// Most values that are kept of one path: the first and the newest.
const MOST: usize = 16;
/// Longest value that is kept as it is, in bytes; of a longer one its digest is kept.
const LONGEST: usize = 128;

/// Path of a configuration value.
pub fn path(set: &str, name: &str) -> String {
    format!("configuration.{set}.{name}")
}

/// What was changed by hand in a component's configuration.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Mark {
    values: BTreeMap<String, Vec<String>>,
}

/// A change of one value by hand.
#[derive(Debug, Clone, Copy)]
pub struct Change<'a> {
    /// What is desired now.
    pub desired: &'a str,
    /// What is set now; none where nothing is.
    pub before: Option<&'a str>,
    /// What a person sets.
    pub value: &'a str,
    /// What becomes of it.
    pub policy: DriftPolicy,
}

impl Mark {
    /// The mark that a manager keeps of a component. Text that is none covers nothing.
    pub fn of(live: &ComponentObserved) -> Self {
        let text = live.by_hand.configured.as_deref();
        text.map(Self::parse).unwrap_or_default()
    }

    /// Reads a mark. Text that is none covers nothing.
    pub fn parse(text: &str) -> Self {
        serde_json::from_str(text).unwrap_or_default()
    }

    /// The text that a manager is to keep.
    pub fn encode(&self) -> String {
        // A map of texts is always written.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// True when it covers nothing.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// True when this value was changed by hand, and what is desired was desired, or counted so, at that time.
    pub fn covers(&self, path: &str, desired: &str) -> bool {
        let values = self.values.get(path);
        values.is_some_and(|values| values.contains(&kept(desired)))
    }

    /// Takes in a change by hand. Where it will be adopted, what is set and what was set may be what is desired next.
    /// Elsewhere only what is desired now counts, so that a person who then writes such a value in the profile gets it.
    pub fn change(&mut self, path: String, change: &Change<'_>) {
        let adopts = change.policy == DriftPolicy::Adopt;
        if !adopts && change.value == change.desired {
            self.values.remove(&path);
            return;
        }
        let known = self.covers(&path, change.desired);
        let values = self.values.entry(path).or_default();
        if !known {
            *values = vec![kept(change.desired)];
        }
        let set = change.before.into_iter().chain([change.value]);
        for value in set.filter(|_| adopts).map(kept) {
            if values.last() != Some(&value) {
                values.push(value);
            }
        }
        if values.len() > MOST {
            // The first one is what was desired before a person did anything.
            values.drain(1..=values.len() - MOST);
        }
    }

    /// Ends it for what a plan sets.
    pub fn set(&mut self, configuration: &Configuration) {
        for (set, values) in &configuration.sets {
            for name in values.keys() {
                self.values.remove(&path(set, name));
            }
        }
        if configuration.active.is_some() {
            self.values.remove(ACTIVE);
        }
    }

    /// Ends it for what is not drift: what is as desired, and what something else is desired for.
    pub fn settle(&mut self, placed: &PlacedComponent, live: &ComponentObserved) {
        let settings = settings(&placed.spec, live);
        let drift = settings.iter().filter(|setting| setting.is_drift(self));
        let drift: Vec<String> = drift.map(crate::in_place::Setting::path).collect();
        self.values.retain(|path, _| drift.contains(path));
    }
}

/// What is desired of a value of a component that is there: what the profile writes, else the module's default. None
/// for what nobody desires, which a plan never sets.
pub fn desired<'a>(
    placed: &'a PlacedComponent,
    live: &'a ComponentObserved,
    set: &str,
    name: &str,
) -> Option<&'a str> {
    let sets = &placed.spec.configuration.sets;
    let written = sets.get(set).and_then(|values| values.get(name));
    written
        .or_else(|| live.defaults.get(name))
        .map(String::as_str)
}

/// A value as a mark keeps it.
fn kept(value: &str) -> String {
    match value.len() > LONGEST {
        true => format!("sha256:{}", crate::place::digest_of(&value)),
        false => value.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAIN: &str = "configuration.default.gain";

    fn changed(policy: DriftPolicy, desired: &str, values: &[&str]) -> Mark {
        let mut mark = Mark::default();
        let mut before = desired.to_owned();
        for value in values {
            let change = Change {
                desired,
                before: Some(&before),
                value,
                policy,
            };
            mark.change(path("default", "gain"), &change);
            before = (*value).to_owned();
        }
        mark
    }

    #[test]
    fn what_may_be_adopted_counts_as_desired() {
        let mark = changed(DriftPolicy::Adopt, "1", &["2", "3", "3"]);
        assert_eq!(
            mark.encode(),
            r#"{"configuration.default.gain":["1","2","3"]}"#
        );
        assert_eq!(Mark::parse(&mark.encode()), mark);
        assert!(["1", "2", "3"].iter().all(|value| mark.covers(GAIN, value)));
        assert!(!mark.covers(GAIN, "4") && !mark.covers(ACTIVE, "1"));
        // Back to what it was, while the first change is perhaps being adopted.
        assert!(changed(DriftPolicy::Adopt, "1", &["2", "1"]).covers(GAIN, "2"));
    }

    #[test]
    fn elsewhere_only_what_is_desired_counts() {
        for policy in [DriftPolicy::Repair, DriftPolicy::Ignore] {
            let mark = changed(policy, "1", &["2", "3"]);
            assert!(mark.covers(GAIN, "1") && !mark.covers(GAIN, "2"));
            assert!(changed(policy, "1", &["2", "1"]).is_empty());
        }
        // Left under one policy, changed again under another: what is found first may be adopted meanwhile.
        let mut mark = changed(DriftPolicy::Ignore, "1", &["2"]);
        let change = Change {
            desired: "1",
            before: Some("2"),
            value: "3",
            policy: DriftPolicy::Adopt,
        };
        mark.change(GAIN.to_owned(), &change);
        assert!(mark.covers(GAIN, "2"));
    }

    #[test]
    fn another_wish_begins_anew() {
        let mut mark = changed(DriftPolicy::Adopt, "1", &["2"]);
        let change = Change {
            desired: "9",
            before: None,
            value: "3",
            policy: DriftPolicy::Adopt,
        };
        mark.change(GAIN.to_owned(), &change);
        assert_eq!(mark.encode(), format!(r#"{{"{GAIN}":["9","3"]}}"#));
    }

    #[test]
    fn it_is_bounded() {
        let values: Vec<String> = (1..100).map(|n| n.to_string()).collect();
        let values: Vec<&str> = values.iter().map(String::as_str).collect();
        let mark = changed(DriftPolicy::Adopt, "0", &values);
        assert_eq!(mark.values[GAIN].len(), MOST);
        assert!(mark.covers(GAIN, "0") && mark.covers(GAIN, "99") && mark.covers(GAIN, "85"));
        assert!(!mark.covers(GAIN, "1") && !mark.covers(GAIN, "84"));
        let long = "x".repeat(100_000);
        let mark = changed(DriftPolicy::Adopt, "0", &[&long]);
        assert!(mark.covers(GAIN, &long) && !mark.covers(GAIN, &long[1..]));
        assert!(mark.encode().len() < 256);
    }

    #[test]
    fn what_a_plan_sets_ends() {
        let mut mark = changed(DriftPolicy::Adopt, "1", &["2"]);
        mark.values
            .insert(ACTIVE.to_owned(), vec!["default".to_owned()]);
        let mut set = Configuration::default();
        mark.set(&set);
        set.active = Some("default".to_owned());
        mark.set(&set);
        assert!(mark.covers(GAIN, "1") && !mark.covers(ACTIVE, "default"));
        let values = [("gain".to_owned(), "1".to_owned())].into();
        set.sets.insert("default".to_owned(), values);
        mark.set(&set);
        assert!(mark.is_empty());
    }

    #[test]
    fn another_text_covers_nothing() {
        for text in ["", "9f86d081884c7d65", "[]", r#"{"a":"b"}"#, "{"] {
            assert!(Mark::parse(text).is_empty(), "{text}");
        }
    }
}
