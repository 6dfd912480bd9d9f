//! Configuration sets of a component, as the real manager keeps them.

use std::collections::BTreeMap;

/// Name of the set that every component has.
const DEFAULT: &str = "default";

/// Set → parameter → value.
pub(super) type Sets = BTreeMap<String, BTreeMap<String, String>>;

/// Sets and the active one. The set `default` has all parameters of the module.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Configuration {
    pub sets: Sets,
    pub active: String,
    pub defaults: BTreeMap<String, String>,
}

impl Configuration {
    pub fn new(defaults: &BTreeMap<String, String>) -> Self {
        Self {
            sets: BTreeMap::from([(DEFAULT.to_owned(), defaults.clone())]),
            active: DEFAULT.to_owned(),
            defaults: defaults.clone(),
        }
    }

    /// With values and perhaps another active set; what is not named stays. An unknown name is refused.
    pub fn updated(&self, sets: &Sets, active: Option<&str>) -> Result<Self, String> {
        let mut updated = self.clone();
        for (set, values) in sets {
            let mut names = values.keys();
            if let Some(unknown) = names.find(|name| !self.defaults.contains_key(*name)) {
                return Err(format!("there is no parameter `{unknown}`"));
            }
            let target = updated.sets.entry(set.clone()).or_default();
            target.extend(values.iter().map(|(k, v)| (k.clone(), v.clone())));
        }
        if let Some(active) = active {
            if !updated.sets.contains_key(active) {
                return Err(format!("there is no configuration set `{active}`"));
            }
            active.clone_into(&mut updated.active);
        }
        Ok(updated)
    }
}
