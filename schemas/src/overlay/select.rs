//! Which components each part of an overlay speaks of.

use std::borrow::Cow;
use std::collections::HashMap;

use wildmatch::WildMatch;

use super::DeploymentSpec;
use crate::composite::Composites;
use crate::diagnostic::Finding;
use crate::placement::Settings;
use crate::span::{Span, Text};
use crate::suggest;
use crate::system::SystemSpec;
use crate::yaml_type::{Faults, Map, Setting};

/// Most globs of one part: each is held against every name.
const GLOBS: usize = 1000;

/// What is said of some components.
pub(super) struct Chosen<'a> {
    /// Indices of the components.
    pub components: Vec<usize>,
    /// What is said.
    pub said: Cow<'a, Settings>,
}

/// What a spec says, the weakest first: laid one after the other, the nearer wins key by key.
pub(super) fn choose<'a>(
    spec: &SystemSpec,
    said: &'a DeploymentSpec,
    faults: &mut Faults,
) -> Vec<Chosen<'a>> {
    let mut chosen = Vec::new();
    if let Some(settings) = said.defaults.get() {
        chosen.push(Chosen {
            components: (0..spec.components.len()).collect(),
            said: Cow::Borrowed(settings),
        });
    }
    if let Some(hosts) = said.hosts.get() {
        chosen.extend(self::hosts(spec, hosts, faults));
    }
    let types = Names::of(spec.components.iter().map(|c| c.type_name.as_str()));
    let instances = Names::of_instances(spec);
    let mut of_types = Part::default();
    if let Some(map) = said.types.get() {
        of_types = types.choose(map, "type", faults);
    }
    let mut of_instances = Part::default();
    if let Some(map) = said.components.get() {
        of_instances = instances.choose(map, "component", faults);
    }
    chosen.extend(of_types.by_glob);
    chosen.extend(of_instances.by_glob);
    chosen.extend(of_types.by_name);
    chosen.extend(of_instances.by_composite);
    chosen.extend(of_instances.by_name);
    chosen
}

/// What `types` or `components` says.
#[derive(Default)]
struct Part<'a> {
    by_glob: Vec<Chosen<'a>>,
    by_composite: Vec<Chosen<'a>>,
    by_name: Vec<Chosen<'a>>,
}

/// Names, and the components that have them.
pub(super) struct Names<'a> {
    own: HashMap<&'a str, Vec<usize>>,
    /// Composites, and the components that they stand for.
    composites: HashMap<&'a str, Vec<usize>>,
}

impl<'a> Names<'a> {
    /// The names of components, in their order.
    pub fn of(names: impl Iterator<Item = &'a str>) -> Self {
        let mut all: HashMap<&str, Vec<usize>> = HashMap::new();
        for (index, name) in names.enumerate() {
            all.entry(name).or_default().push(index);
        }
        Self {
            own: all,
            composites: HashMap::new(),
        }
    }

    /// The instance names of a system; that of a composite means its members.
    pub fn of_instances(spec: &'a SystemSpec) -> Self {
        let mut names = Self::of(spec.components.iter().map(|c| c.instance.as_str()));
        let all = Composites::of(&spec.composites);
        for composite in &spec.composites {
            let name = composite.instance.as_str();
            let leaves = all.leaves(name).into_iter();
            let found = leaves.filter_map(|leaf| names.own.get(leaf)).flatten();
            let found = found.copied().collect();
            names.composites.insert(name, found);
        }
        names
    }

    /// The components that a name or glob means, in their order. A name that exists is never a glob.
    pub fn find(&self, selector: &str) -> Vec<usize> {
        let known = [&self.own, &self.composites];
        if let Some(found) = known.iter().find_map(|names| names.get(selector)) {
            return found.clone();
        }
        if !is_glob(selector) {
            return Vec::new();
        }
        let glob = WildMatch::new(selector);
        let fitting = self.own.iter().filter(|(name, _)| glob.matches(name));
        let mut found: Vec<usize> = fitting
            .flat_map(|(_, found)| found.iter().copied())
            .collect();
        found.sort_unstable();
        found
    }

    /// What is wrong with a selector that means nothing: an error for an instance name.
    pub fn unmatched(&self, what: &str, selector: &str) -> Finding {
        let mut names: Vec<&str> = self.own.keys().copied().collect();
        names.sort_unstable();
        let help = match names.is_empty() {
            true => "the system has no component".to_owned(),
            false => suggest::advice(selector, &format!("{what}s"), &names),
        };
        let finding = if is_glob(selector) {
            let message = format!("the glob `{selector}` fits no {what} of the system");
            Finding::warning("unmatched-selector", message)
        } else if what == "type" {
            let message = format!("the system has no component of type `{selector}`");
            Finding::warning("unmatched-selector", message)
        } else {
            let message = format!("the system has no component `{selector}`");
            Finding::error("unknown-instance", message)
        };
        finding.help(help)
    }

    fn choose<'s>(&self, map: &'s Map<Settings>, what: &str, faults: &mut Faults) -> Part<'s> {
        let mut part = Part::default();
        for (name, setting) in map.iter() {
            let components = self.find(name.trimmed());
            if components.is_empty() {
                faults.push(self.unmatched(what, name.trimmed()), name.span);
                continue;
            }
            let Some(said) = setting.get().map(Cow::Borrowed) else {
                continue;
            };
            let chosen = Chosen { components, said };
            if self.own.contains_key(name.trimmed()) {
                part.by_name.push(chosen);
            } else if self.composites.contains_key(name.trimmed()) {
                part.by_composite.push(chosen);
            } else if part.by_glob.len() < GLOBS {
                part.by_glob.push(chosen);
            } else {
                too_many(name.span, faults);
                break;
            }
        }
        part
    }
}

/// A selector with one of these is a glob.
pub(super) fn is_glob(selector: &str) -> bool {
    selector.contains(['*', '?'])
}

fn too_many(span: Span, faults: &mut Faults) {
    let message = format!("there are more than {GLOBS} globs");
    let finding = Finding::error("too-many-entries", message).help("join some of them");
    faults.push(finding, span);
}

/// The components of each host, and the node that is said for it.
fn hosts<'a>(
    spec: &SystemSpec,
    hosts: &Map<crate::placement::NodeName>,
    faults: &mut Faults,
) -> Vec<Chosen<'a>> {
    let lower: Vec<Option<String>> = spec
        .components
        .iter()
        .map(|component| {
            component
                .placement
                .host
                .as_ref()
                .map(|host| host.to_lowercase())
        })
        .collect();
    let names = Names::of(lower.iter().map(|host| host.as_deref().unwrap_or_default()));
    let mut chosen = Vec::new();
    for (host, node) in hosts.iter() {
        let components = names.own.get(host.trimmed().to_lowercase().as_str());
        let Some(components) = components else {
            faults.push(unknown_host(host, &names), host.span);
            continue;
        };
        if node.is_silent() {
            continue;
        }
        let said = Settings {
            node: node.clone(),
            ..Settings::default()
        };
        chosen.push(Chosen {
            components: components.clone(),
            said: Cow::Owned(said),
        });
    }
    chosen
}

fn unknown_host(host: &Text, names: &Names<'_>) -> Finding {
    let message = format!("the profile names no host `{}`", host.trimmed());
    let mut known: Vec<&str> = names
        .own
        .keys()
        .copied()
        .filter(|name| !name.is_empty())
        .collect();
    known.sort_unstable();
    let help = match known.is_empty() {
        true => {
            "it names no host but this machine; `defaults: { node: … }` places all its components"
                .to_owned()
        }
        false => suggest::advice(host.trimmed(), "hosts", &known),
    };
    Finding::warning("unmatched-selector", message).help(help)
}

/// The spans of everything that is said of components, part by part, for what is told once for each.
pub(super) fn all_settings(said: &DeploymentSpec) -> Vec<&Settings> {
    let maps = [&said.types, &said.components].into_iter();
    let entries = maps.filter_map(Setting::get).flat_map(Map::iter);
    let named = entries.filter_map(|(_, setting)| setting.get());
    said.defaults.get().into_iter().chain(named).collect()
}
