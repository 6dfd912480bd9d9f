//! Values of parameters that overlays give, against what the profile and the RTC Profiles say of them.

use std::collections::HashMap;

use super::against::component::{declared, value_fault};
use super::against::said_by;
use super::constraint::{self, Rule};
use super::library::{Found, Library};
use super::parameters::{SETS, entries, fault};
use crate::diagnostic::{Finding, Place, Report};
use crate::overlay::{KnownParameters, Parameters};
use crate::rtc_profile::forms::Configuration;
use crate::rts_profile::model::Component;
use crate::rts_profile::{Places, ReadProfile, unescaped};
use crate::system::SystemSpec;

/// Parameters that components have beside those of their configuration sets. An RTC Profile names all that there are.
pub(super) fn known_parameters(read: &ReadProfile, library: Option<&Library>) -> KnownParameters {
    let mut known = KnownParameters::new();
    for component in &read.profile.components {
        let Some(name) = &component.instance_name else {
            continue;
        };
        let mut parameters = Parameters::default();
        let found = library.and_then(|library| library.find(component));
        let listed = found.map(|found| (found, declared(found)));
        if let Some((found, listed)) = listed.filter(|(_, listed)| !listed.is_empty()) {
            parameters.names = listed.keys().map(|name| (*name).to_owned()).collect();
            parameters.all_in = Some(found.profile.source.name().to_owned());
        } else {
            let said = SETS.iter().flat_map(|kind| entries(component, kind));
            parameters.names = said.map(|(name, _)| name.trimmed().to_owned()).collect();
        }
        if !parameters.names.is_empty() {
            known.entry(name.trimmed().to_owned()).or_insert(parameters);
        }
    }
    known
}

/// Values that overlays gave and that do not fit; one finding for a line.
pub(super) fn configured(
    read: &ReadProfile,
    spec: &SystemSpec,
    places: &Places,
    library: Option<&Library>,
) -> Report {
    let mut told: Vec<(Finding, usize)> = Vec::new();
    let mut seen: HashMap<(&Place, String), usize> = HashMap::new();
    let mut last: Option<(usize, Known<'_>)> = None;
    for (pointer, place) in places.laid() {
        let Some((index, set, parameter)) = parts(pointer) else {
            continue;
        };
        let Some(lowered) = spec.components.get(index) else {
            continue;
        };
        let value = lowered.configuration.sets.get(&set);
        let Some(value) = value.and_then(|set| set.get(&parameter)) else {
            continue;
        };
        if last.as_ref().is_none_or(|(at, _)| *at != index) {
            let component = read.component(&lowered.instance);
            last = component.map(|component| (index, Known::of(component, library)));
        }
        let Some((_, known)) = &last else { continue };
        let what = format!("the parameter `{parameter}` of `{}`", lowered.instance);
        let Some(finding) = known.fault(&parameter, &what, value) else {
            continue;
        };
        let help = finding.help.clone().unwrap_or_default();
        match seen.get(&(place, help.clone())) {
            Some(at) => told[*at].1 += 1,
            None => {
                seen.insert((place, help), told.len());
                told.push((finding.at(Some(place.clone())), 1));
            }
        }
    }
    let findings = told.into_iter().map(|(mut finding, count)| {
        if count > 1 {
            let more = format!(" (as it is of {} more)", count - 1);
            finding.message.push_str(&more);
        }
        finding
    });
    Report {
        findings: findings.collect(),
    }
}

/// Index, set and parameter of `/components/0/configuration/sets/default/gain`.
fn parts(pointer: &str) -> Option<(usize, String, String)> {
    let (index, rest) = pointer.strip_prefix("/components/")?.split_once('/')?;
    let (set, parameter) = rest.strip_prefix("configuration/sets/")?.split_once('/')?;
    Some((index.parse().ok()?, unescaped(set), unescaped(parameter)))
}

/// What is known of the values of a component.
struct Known<'a> {
    rules: HashMap<&'a str, Rule>,
    types: HashMap<&'a str, &'a str>,
    listed: Option<(Found<'a>, HashMap<&'a str, &'a Configuration>)>,
}

impl<'a> Known<'a> {
    fn of(component: &'a Component, library: Option<&'a Library>) -> Self {
        let rules = entries(component, "__constraints__").into_iter();
        let types = entries(component, "__type__").into_iter();
        let found = library.and_then(|library| library.find(component));
        Self {
            rules: rules
                .filter_map(|(name, text)| {
                    Some((name.trimmed(), constraint::parse(&text.value).ok()?))
                })
                .collect(),
            types: types
                .map(|(name, text)| (name.trimmed(), text.value.as_str()))
                .collect(),
            listed: found.map(|found| (found, declared(found))),
        }
    }

    fn fault(&self, parameter: &str, what: &str, value: &str) -> Option<Finding> {
        let data_type = self.types.get(parameter).copied();
        let own = fault(what, value, data_type, self.rules.get(parameter));
        own.or_else(|| {
            let (found, listed) = self.listed.as_ref()?;
            let finding = value_fault(what, value, listed.get(parameter)?)?;
            let help = finding.help.clone().unwrap_or_default();
            Some(finding.help(format!("{help}; {}", said_by(*found))))
        })
    }
}
