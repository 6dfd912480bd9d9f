//! Configuration that an overlay says, held against what the profile has: the component itself may know more.

use std::collections::{BTreeMap, BTreeSet};

use super::DeploymentSpec;
use super::select::{self, Chosen};
use crate::diagnostic::Finding;
use crate::placement::ConfigurationSettings;
use crate::span::{Span, Text};
use crate::suggest;
use crate::system::{ComponentSpec, SystemSpec};
use crate::yaml_type::Faults;

/// What is known of the parameters of components beside those in their sets, by instance.
pub type KnownParameters = BTreeMap<String, Parameters>;

/// Parameters of a component that are known beside those in its sets.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Parameters {
    /// Their names.
    pub names: BTreeSet<String>,
    /// The file that names all that there are, if one does.
    pub all_in: Option<String>,
}

/// Warns of sets and parameters that components do not have before it is laid over them. One warning for a line.
pub(super) fn check_before(
    spec: &SystemSpec,
    chosen: &Chosen<'_>,
    known: &KnownParameters,
    faults: &mut Faults,
) {
    let Some(said) = chosen.said.configuration.get() else {
        return;
    };
    let components = chosen.components.iter();
    let mut unknown = Unknown::default();
    for component in components.filter_map(|index| spec.components.get(*index)) {
        check(
            component,
            said,
            known.get(&component.instance),
            &mut unknown,
        );
    }
    unknown.tell(faults);
}

fn check<'a>(
    component: &'a ComponentSpec,
    said: &'a ConfigurationSettings,
    beside: Option<&'a Parameters>,
    unknown: &mut Unknown<'a>,
) {
    let sets = &component.configuration.sets;
    let all_in = beside.and_then(|beside| beside.all_in.as_deref());
    // A profile without sets says nothing of what the component knows.
    let Some(map) = said
        .sets
        .get()
        .filter(|_| !sets.is_empty() || all_in.is_some())
    else {
        return;
    };
    // Any set of a component may have any of its parameters.
    let own = sets
        .values()
        .flat_map(BTreeMap::keys)
        .filter(|_| all_in.is_none());
    let more = beside.into_iter().flat_map(|beside| &beside.names);
    let known: BTreeSet<&str> = own.chain(more).map(String::as_str).collect();
    for (name, values) in map.iter() {
        if !sets.is_empty() && !sets.contains_key(name.trimmed()) {
            unknown.add(name, || Missing::of(name, component));
        }
        let Some(values) = values.get() else { continue };
        let given: BTreeSet<&str> = values.iter().map(|(name, _)| name.trimmed()).collect();
        for (parameter, _) in values.iter() {
            if !known.contains(parameter.trimmed()) {
                unknown.add(parameter, || Missing {
                    is_parameter: true,
                    known: known.clone(),
                    given: given.clone(),
                    all_in,
                    ..Missing::of(parameter, component)
                });
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
    component: &'a ComponentSpec,
    /// A parameter, not a set.
    is_parameter: bool,
    /// Parameters that there are.
    known: BTreeSet<&'a str>,
    /// Parameters that stand beside it: none of them was meant.
    given: BTreeSet<&'a str>,
    /// The file that names all parameters.
    all_in: Option<&'a str>,
    /// Components that have it not.
    count: usize,
}

impl<'a> Unknown<'a> {
    fn add(&mut self, name: &'a Text, missing: impl FnOnce() -> Missing<'a>) {
        let key = (name.span.start, name.value.as_str());
        self.0.entry(key).or_insert_with(missing).count += 1;
    }

    fn tell(self, faults: &mut Faults) {
        for missing in self.0.into_values() {
            faults.push(missing.finding(), missing.name.span);
        }
    }
}

impl<'a> Missing<'a> {
    fn of(name: &'a Text, component: &'a ComponentSpec) -> Self {
        Self {
            name,
            component,
            is_parameter: false,
            known: BTreeSet::new(),
            given: BTreeSet::new(),
            all_in: None,
            count: 0,
        }
    }

    fn finding(&self) -> Finding {
        let instance = &self.component.instance;
        let sets = &self.component.configuration.sets;
        let name = self.name.trimmed();
        let others = match self.count {
            1 => String::new(),
            count => format!(" (nor {} more)", count - 1),
        };
        if !self.is_parameter {
            let known: Vec<&str> = sets.keys().map(String::as_str).collect();
            let message = format!("`{instance}` has no configuration set `{name}`{others}");
            return Finding::warning("unknown-configuration-set", message)
                .help(suggest::advice(name, "sets", &known));
        }
        let meant = self.known.difference(&self.given).copied();
        let known: Vec<&str> = self.known.iter().copied().collect();
        let listed = match known.is_empty() {
            true => "none are known".to_owned(),
            false => format!("parameters: {}", suggest::listed(known)),
        };
        let help = match suggest::nearest(name, meant) {
            Some(near) if self.known.len() == 1 => format!("did you mean `{near}`?"),
            Some(near) => format!("did you mean `{near}`? {listed}"),
            None => listed,
        };
        match self.all_in {
            Some(file) => {
                let message = format!("the type of `{instance}` has no parameter `{name}`{others}");
                Finding::warning("rtc-unknown-parameter", message)
                    .help(format!("{help}; so says {file}"))
            }
            None => {
                let message = format!("no set of `{instance}` has a parameter `{name}`{others}");
                Finding::warning("unknown-parameter", message).help(help)
            }
        }
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
