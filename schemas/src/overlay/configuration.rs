//! Configuration that an overlay says, held against what the profile has: the component itself may know more.

use std::collections::BTreeMap;

use super::DeploymentSpec;
use super::select::{self, Chosen};
use crate::diagnostic::Finding;
use crate::placement::ConfigurationSettings;
use crate::span::{Span, Text};
use crate::suggest;
use crate::system::{ComponentSpec, SystemSpec};
use crate::yaml_type::Faults;

/// Warns of sets and parameters that components do not have before it is laid over them. One warning for a line.
pub(super) fn check_before(spec: &SystemSpec, chosen: &Chosen<'_>, faults: &mut Faults) {
    let Some(said) = chosen.said.configuration.get() else {
        return;
    };
    let components = chosen.components.iter();
    let mut unknown = Unknown::default();
    for component in components.filter_map(|index| spec.components.get(*index)) {
        check(component, said, &mut unknown);
    }
    unknown.tell(faults);
}

fn check<'a>(
    component: &'a ComponentSpec,
    said: &'a ConfigurationSettings,
    unknown: &mut Unknown<'a>,
) {
    let sets = &component.configuration.sets;
    // A profile without sets says nothing of what the component knows.
    let Some(map) = said.sets.get().filter(|_| !sets.is_empty()) else {
        return;
    };
    for (name, values) in map.iter() {
        let Some(set) = sets.get(name.trimmed()) else {
            unknown.add(name, None, component);
            continue;
        };
        let values = values.get().into_iter().flat_map(|values| values.iter());
        for (parameter, _) in values {
            if !set.contains_key(parameter.trimmed()) {
                unknown.add(parameter, Some(name), component);
            }
        }
    }
}

/// Sets and parameters that are not there, by where they stand.
#[derive(Default)]
struct Unknown<'a>(BTreeMap<(u32, &'a str), Missing<'a>>);

/// One of them, with the first component that has it not.
struct Missing<'a> {
    name: &'a Text,
    /// Of a parameter.
    set: Option<&'a Text>,
    component: &'a ComponentSpec,
    /// Components that have it not.
    count: usize,
}

impl<'a> Unknown<'a> {
    fn add(&mut self, name: &'a Text, set: Option<&'a Text>, component: &'a ComponentSpec) {
        let key = (name.span.start, name.value.as_str());
        let missing = self.0.entry(key).or_insert(Missing {
            name,
            set,
            component,
            count: 0,
        });
        missing.count += 1;
    }

    fn tell(self, faults: &mut Faults) {
        for missing in self.0.into_values() {
            faults.push(missing.finding(), missing.name.span);
        }
    }
}

impl Missing<'_> {
    fn finding(&self) -> Finding {
        let instance = &self.component.instance;
        let sets = &self.component.configuration.sets;
        let name = self.name.trimmed();
        let others = match self.count {
            1 => String::new(),
            count => format!(" (nor {} more)", count - 1),
        };
        let Some(set) = self.set.map(Text::trimmed) else {
            let known: Vec<&str> = sets.keys().map(String::as_str).collect();
            let message = format!("`{instance}` has no configuration set `{name}`{others}");
            return Finding::warning("unknown-configuration-set", message)
                .help(suggest::advice(name, "sets", &known));
        };
        let known = sets.get(set).into_iter().flat_map(BTreeMap::keys);
        let known: Vec<&str> = known.map(String::as_str).collect();
        let message = format!("set `{set}` of `{instance}` has no parameter `{name}`{others}");
        let help = match known.is_empty() {
            true => "the profile has no parameter in this set".to_owned(),
            false => suggest::advice(name, "parameters", &known),
        };
        Finding::warning("unknown-parameter", message).help(help)
    }
}

/// Warns of active sets that are not there once all is laid.
pub(super) fn check_active(spec: &SystemSpec, said: &DeploymentSpec, faults: &mut Faults) {
    let mut seen: Vec<Span> = Vec::new();
    let mut spans = BTreeMap::new();
    for settings in select::all_settings(said) {
        let active = settings.configuration.get().map(|said| &said.active);
        if let Some((name, active)) = active.and_then(|active| Some((active.get()?, active))) {
            spans.entry(name.0.as_str()).or_insert(active.span());
        }
    }
    for component in &spec.components {
        let configuration = &component.configuration;
        let Some(active) = configuration.active.as_deref() else {
            continue;
        };
        let Some(span) = spans.get(active).filter(|span| !seen.contains(span)) else {
            continue;
        };
        let sets = &configuration.sets;
        if sets.contains_key(active) || (sets.is_empty() && active == "default") {
            continue;
        }
        let instance = &component.instance;
        let message = format!(
            "the active configuration set `{active}` of `{instance}` is not in the profile"
        );
        let known: Vec<&str> = sets.keys().map(String::as_str).collect();
        let help = match known.is_empty() {
            true => {
                "the profile has no set of it; the component must know the set itself".to_owned()
            }
            false => suggest::advice(active, "sets", &known),
        };
        seen.push(*span);
        faults.push(
            Finding::warning("unknown-configuration-set", message).help(help),
            *span,
        );
    }
}
