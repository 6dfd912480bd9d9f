//! Configuration sets of a component: which parameter has which value in force.

use std::collections::BTreeMap;

use rts_schemas::check::Limits;

use crate::failure::list;

/// Name of the set that every component has.
const DEFAULT: &str = "default";

/// Sets and the active one. The set `default` has all parameters of the module.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Configuration {
    /// Set → parameter → value.
    pub sets: BTreeMap<String, BTreeMap<String, String>>,
    /// Name of the active set.
    pub active: String,
    /// Default of each parameter whose type has no empty text.
    defaults: BTreeMap<String, String>,
}

/// Values to set.
pub type Sets = BTreeMap<String, BTreeMap<String, String>>;

impl Configuration {
    /// The module's defaults.
    pub fn new(defaults: &BTreeMap<String, String>, limits: &BTreeMap<String, Limits>) -> Self {
        let needs_text = |name| limits.get(name).is_some_and(Limits::needs_text);
        Self {
            defaults: defaults
                .iter()
                .filter(|(name, _)| needs_text(*name))
                .map(|(name, default)| (name.clone(), default.clone()))
                .collect(),
            sets: BTreeMap::from([(DEFAULT.to_owned(), defaults.clone())]),
            active: DEFAULT.to_owned(),
        }
    }

    /// With values and perhaps another active set; what is not named stays. An unknown name is refused, and so is a value
    /// that the module does not allow, in whichever set it is.
    pub fn updated(
        &self,
        sets: &Sets,
        active: Option<&str>,
        limits: &BTreeMap<String, Limits>,
    ) -> Result<Self, String> {
        let mut updated = self.clone();
        let known = &self.sets[DEFAULT];
        for (set, values) in sets {
            if let Some(unknown) = values.keys().find(|name| !known.contains_key(*name)) {
                return Err(format!(
                    "there is no parameter `{unknown}`; the parameters are: {}",
                    list(known.keys().map(String::as_str))
                ));
            }
            for (name, value) in values {
                if let Some(problem) = limits.get(name).and_then(|limits| limits.problem(value)) {
                    return Err(format!(
                        "parameter `{name}` = `{value}` of the set `{set}`: {problem}"
                    ));
                }
            }
            let target = updated.sets.entry(set.clone()).or_default();
            target.extend(values.iter().map(|(k, v)| (k.clone(), v.clone())));
        }
        if let Some(active) = active {
            if !updated.sets.contains_key(active) {
                return Err(format!(
                    "there is no configuration set `{active}`; the sets are: {}",
                    list(updated.sets.keys().map(String::as_str))
                ));
            }
            active.clone_into(&mut updated.active);
        }
        Ok(updated)
    }

    /// Value in force of each parameter: the active set's, else that of `default`. An empty text stands for the module's
    /// default where the type has none, and when that is empty too the module is told nothing.
    pub fn effective(&self) -> BTreeMap<&str, &str> {
        [DEFAULT, &self.active]
            .into_iter()
            .filter_map(|set| self.sets.get(set))
            .flatten()
            .map(|(name, value)| (name.as_str(), self.told(name, value)))
            .collect::<BTreeMap<_, _>>()
            .into_iter()
            .filter_map(|(name, value)| Some((name, value?)))
            .collect()
    }
}

impl Configuration {
    /// What the module is told for a value.
    fn told<'a>(&'a self, name: &str, value: &'a str) -> Option<&'a str> {
        match self.defaults.get(name) {
            Some(default) if value.trim().is_empty() => {
                Some(default.as_str()).filter(|default| !default.trim().is_empty())
            }
            _ => Some(value),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> BTreeMap<String, String> {
        text.split_whitespace()
            .filter_map(|pair| pair.split_once('='))
            .map(|(k, v)| (k.to_owned(), v.to_owned()))
            .collect()
    }

    fn sets(set: &str, text: &str) -> Sets {
        BTreeMap::from([(set.to_owned(), values(text))])
    }

    const NONE: &BTreeMap<String, Limits> = &BTreeMap::new();

    #[test]
    fn an_empty_text_stands_for_the_default_of_a_number() {
        let limits = |kind| Limits::read(kind, "").unwrap();
        let limits = BTreeMap::from([
            ("a".to_owned(), limits("int")),
            ("b".to_owned(), limits("string")),
            ("c".to_owned(), limits("double")),
        ]);
        let made = Configuration::new(&values("a=1 b=2 c="), &limits)
            .updated(&sets("default", "a=5"), None, &limits)
            .unwrap()
            .updated(&sets("bare", "a= b="), Some("bare"), &limits)
            .unwrap();
        // Not the 5 of the other set, and what has no default at all is not set.
        assert_eq!(made.effective(), BTreeMap::from([("a", "1"), ("b", "")]));
        assert_eq!(made.sets["bare"]["a"], "", "as it was said");
    }

    #[test]
    fn a_value_that_the_module_does_not_allow_is_refused_in_any_set() {
        let made = Configuration::new(&values("a=1 b=2"), NONE);
        let limits = BTreeMap::from([("a".to_owned(), Limits::read("int", "x<5").unwrap())]);
        let refused = |text| {
            made.updated(&sets("fast", text), None, &limits)
                .unwrap_err()
        };
        assert_eq!(
            refused("a=5"),
            "parameter `a` = `5` of the set `fast`: allowed: x < 5"
        );
        assert_eq!(
            refused("a=x"),
            "parameter `a` = `x` of the set `fast`: it is no `int`"
        );
        assert!(
            made.updated(&sets("fast", "a=4 b=x"), None, &limits)
                .is_ok()
        );
    }

    #[test]
    fn the_active_set_lies_over_the_default_one() {
        let made = Configuration::new(&values("a=1 b=2"), NONE)
            .updated(&sets("default", "b=3"), None, NONE)
            .unwrap()
            .updated(&sets("fast", "a=9"), Some("fast"), NONE)
            .unwrap();
        assert_eq!(made.effective(), BTreeMap::from([("a", "9"), ("b", "3")]));
        let back = made.updated(&Sets::new(), Some("default"), NONE).unwrap();
        assert_eq!(back.effective(), BTreeMap::from([("a", "1"), ("b", "3")]));
        assert_eq!(back.sets["fast"], values("a=9"));
    }

    #[test]
    fn unknown_names_are_refused_with_those_that_exist() {
        let made = Configuration::new(&values("a=1 b=2"), NONE);
        assert_eq!(
            made.updated(&sets("default", "c=1"), None, NONE)
                .unwrap_err(),
            "there is no parameter `c`; the parameters are: a, b"
        );
        assert_eq!(
            made.updated(&Sets::new(), Some("fast"), NONE).unwrap_err(),
            "there is no configuration set `fast`; the sets are: default"
        );
    }
}
