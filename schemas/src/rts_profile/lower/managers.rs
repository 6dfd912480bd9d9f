//! Which components shared a process when the profile was saved, and a name for each such process.

use std::collections::{BTreeMap, BTreeSet};

use crate::names::manager_name;
use crate::rts_profile::ior::{self, Endpoint};
use crate::rts_profile::model::{self, Component};

/// Processes as the references show them: same host and port, same process.
pub(super) struct Managers {
    names: BTreeMap<Endpoint, String>,
}

impl Managers {
    /// Names each process by its smallest instance name, so that a re-save in another order, or a restart on other
    /// ports, changes nothing. `m-` keeps it apart from the process of an isolated component and from `main`.
    pub(super) fn of(components: &[Component]) -> Self {
        let mut groups: BTreeMap<Endpoint, &str> = BTreeMap::new();
        for component in components {
            let instance = component.instance_name.as_ref().map(|name| name.trimmed());
            if let (Some(endpoint), Some(instance)) = (endpoint(component), instance) {
                let smallest = groups.entry(endpoint).or_insert(instance);
                *smallest = (*smallest).min(instance);
            }
        }
        let mut by_name: Vec<_> = groups.into_iter().map(|(at, name)| (name, at)).collect();
        by_name.sort();
        let mut used = BTreeSet::new();
        let names = by_name.into_iter().map(|(instance, endpoint)| {
            let name = unused(&group_name(instance), &used);
            used.insert(name.clone());
            (endpoint, name)
        });
        Self {
            names: names.collect(),
        }
    }

    /// The name of a process; one process alone is the default manager.
    pub(super) fn name(&self, endpoint: &Endpoint) -> Option<String> {
        if self.names.len() < 2 {
            return None;
        }
        self.names.get(endpoint).cloned()
    }
}

/// Where the process of a component ran when the profile was saved.
pub(super) fn endpoint(component: &Component) -> Option<Endpoint> {
    let ior = model::property_value(&component.properties, "IOR")?;
    ior::endpoint(&ior.value)
}

/// Longest name before a number that tells it from its namesakes.
const LENGTH: usize = 55;

fn group_name(instance: &str) -> String {
    let clean = manager_name(&instance.to_lowercase()).unwrap_or_default();
    let clean: String = clean.chars().take(LENGTH).collect();
    let name = manager_name(&format!("m-{clean}"));
    name.unwrap_or_else(|| "m".to_owned())
}

/// The name itself, or with `-2`, `-3`, … when another process has it.
fn unused(name: &str, used: &BTreeSet<String>) -> String {
    let mut unused = name.to_owned();
    let mut count = 1;
    while used.contains(&unused) {
        count += 1;
        unused = format!("{name}-{count}");
    }
    unused
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::names::is_manager_name;
    use crate::rts_profile::model::Property;
    use crate::span::{Span, Text};

    fn component(name: &str, port: u16) -> Component {
        // Little-endian, no type id, one IIOP 1.0 profile for host `h`.
        let [low, high] = port.to_le_bytes();
        let ior = format!(
            "IOR:01000000010000000000000001000000000000000c00000001010000020000006800{low:02x}{high:02x}"
        );
        let text = |text: &str| Some(Text::new(text, Span::default()));
        Component {
            instance_name: text(name),
            properties: vec![Property {
                name: text("IOR"),
                value: text(&ior),
                ..Property::default()
            }],
            ..Component::default()
        }
    }

    fn names(components: &[(&str, u16)]) -> BTreeMap<String, String> {
        let components: Vec<_> = components.iter().map(|(n, p)| component(n, *p)).collect();
        let managers = Managers::of(&components);
        let name = |c: &Component| {
            let instance = c.instance_name.as_ref().unwrap().value.clone();
            Some((instance, managers.name(&endpoint(c).unwrap())?))
        };
        components.iter().filter_map(name).collect()
    }

    #[test]
    fn another_order_in_the_file_changes_no_name() {
        let one = names(&[("Sine0", 1), ("Arm0", 2), ("Filter0", 1), ("Leg0", 2)]);
        let other = names(&[("Leg0", 7), ("Filter0", 9), ("Arm0", 7), ("Sine0", 9)]);
        assert_eq!(one, other);
        assert_eq!(one["Sine0"], "m-filter0");
        assert_eq!(one["Leg0"], "m-arm0");
    }

    #[test]
    fn one_process_alone_is_the_default_manager() {
        assert!(names(&[("Sine0", 1), ("Filter0", 1)]).is_empty());
    }

    #[test]
    fn odd_names_give_names_that_can_be_used_and_differ() {
        let long = "x".repeat(128);
        let found = names(&[("左腕", 1), ("右腕", 2), ("A b", 3), ("a.b", 4), (&long, 5)]);
        let all: BTreeSet<_> = found.values().collect();
        assert_eq!(all.len(), 5, "{found:?}");
        assert!(all.iter().all(|name| is_manager_name(name)), "{found:?}");
    }
}
