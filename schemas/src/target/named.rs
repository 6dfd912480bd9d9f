//! Texts → the components and connectors that they name.

use std::collections::HashSet;

use crate::suggest;
use crate::system::SystemSpec;

/// A target that neither the stored system nor the file has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the system has no {what} `{name}`")]
pub struct UnknownTarget {
    /// The target as written (`component/Snie0`).
    pub target: String,
    /// What was looked for: `component`, `connector`, or one of both.
    pub what: &'static str,
    /// The name that was looked for.
    pub name: String,
    /// What there is instead.
    pub help: String,
}

/// The names of targets, by kind.
#[derive(Debug, Default)]
pub(super) struct Named<'a> {
    pub(super) components: HashSet<&'a str>,
    pub(super) connectors: HashSet<&'a str>,
}

impl<'a> Named<'a> {
    pub(super) fn resolve(
        targets: &'a [String],
        stored: &SystemSpec,
        new: &SystemSpec,
    ) -> Result<Self, UnknownTarget> {
        let known = Known::of(stored, new);
        let mut named = Self::default();
        for target in targets {
            let text = target.trim();
            match text.split_once('/') {
                Some(("component", name)) if known.components.contains(name) => {
                    named.components.insert(name);
                }
                Some(("connector", name)) if known.connectors.contains(name) => {
                    named.connectors.insert(name);
                }
                None if known.components.contains(text) => {
                    named.components.insert(text);
                }
                None if known.connectors.contains(text) => {
                    named.connectors.insert(text);
                }
                _ => return Err(known.unknown(target)),
            }
        }
        Ok(named)
    }
}

/// The names of both systems.
struct Known<'a> {
    components: HashSet<&'a str>,
    connectors: HashSet<&'a str>,
}

impl<'a> Known<'a> {
    fn of(stored: &'a SystemSpec, new: &'a SystemSpec) -> Self {
        let both = [stored, new];
        let components = both.iter().flat_map(|spec| &spec.components);
        let connectors = both.iter().flat_map(|spec| &spec.connectors);
        Self {
            components: components.map(|c| c.instance.as_str()).collect(),
            connectors: connectors.map(|c| c.name.as_str()).collect(),
        }
    }

    fn unknown(&self, target: &str) -> UnknownTarget {
        let text = target.trim();
        let (what, name) = match text.split_once('/') {
            Some(("component", name)) => ("component", name),
            Some(("connector", name)) => ("connector", name),
            _ => ("component or connector", text),
        };
        let mut names: Vec<&str> = Vec::new();
        if what != "connector" {
            names.extend(&self.components);
        }
        if what != "component" {
            names.extend(&self.connectors);
        }
        names.sort_unstable();
        let list = match what {
            "component" => "components",
            "connector" => "connectors",
            _ => "there are",
        };
        let help = if names.is_empty() {
            format!("neither the file nor the stored system has a {what}")
        } else {
            suggest::advice(name, list, &names)
        };
        UnknownTarget {
            target: target.to_owned(),
            what,
            name: name.to_owned(),
            help,
        }
    }
}
