//! A set-up → an RTS Profile 0.2, and the overlay that says which component is in which manager.

mod components;
mod composites;
mod connectors;
mod types;

use std::collections::{HashMap, HashSet};

use super::item::local_name;
use super::setup::{Component, Manager, Setup};
use super::{overlay, system_name};
use crate::diagnostic::{Finding, Place, Report, Severity};
use crate::form::{Around, Form};
use crate::names;
use crate::rtc_profile::forms::RtcProfile;
use crate::rts_profile::forms::{self, Order, Profile, Property, TargetExecutionContext};
use crate::span::{Span, Text};
use crate::suggest;
use types::Types;

/// What the caller knows besides the files.
#[derive(Debug, Clone, Copy)]
pub struct Options<'a> {
    /// Name of the system; else the files' folder gives it.
    pub name: Option<&'a str>,
    /// `rts:creationDate` and `rts:updateDate`: a time as XML Schema has it (`2026-01-15T10:00:00`).
    pub created: &'a str,
    /// RTC Profiles of types of components: their ids and ports.
    pub types: &'a [RtcProfile],
    /// The profile says the managers itself, in `rtsctl.manager`, and needs no overlay.
    pub managers_inside: bool,
}

/// A set-up as profile and overlay.
#[derive(Debug, Clone)]
pub struct Converted {
    /// The profile.
    pub profile: Profile,
    /// The overlay, YAML.
    pub overlay: String,
    /// What could not be carried over, and what had to be guessed.
    pub report: Report,
}

/// Converts a set-up. Errors in the report name what is left out of the profile because of them.
pub fn convert(setup: &Setup, options: &Options<'_>) -> Converted {
    let mut report = Report::default();
    let types = Types::of(options.types);
    let components = distinct(setup, &mut report);
    if components.is_empty() {
        report.push(no_component(setup));
    }
    let instances: HashMap<&str, &Component> = components
        .iter()
        .map(|(_, c)| (c.instance.as_str(), *c))
        .collect();
    let mut made = Made {
        setup,
        types: &types,
        instances,
        unknown: 0,
        report,
    };
    let connections = made.connections();
    let ends = connectors::ends(&connections);
    let ids = made.ids(&components);
    let name = name(setup, options);
    let mut profile = Profile {
        id: text(format!("RTSystem:unknown:{name}:1.0.0")),
        version: text("0.2"),
        abstract_text: text(""),
        creation_date: text(options.created),
        update_date: text(options.created),
        ..Profile::default()
    };
    for (index, (manager, component)) in components.iter().enumerate() {
        let mut form = made.component(index, manager, component, &ids, &ends);
        if options.managers_inside {
            form.properties
                .push(property("rtsctl.manager", &component.manager));
        }
        profile.components.push(form);
    }
    made.connectors(&connections, &ids, &mut profile);
    profile.activation.extend(made.activation(&ids));
    made.not_carried();
    let managers = components
        .iter()
        .map(|(_, c)| (c.instance.as_str(), c.manager.as_str()));
    Converted {
        overlay: overlay::write(&name, managers),
        profile,
        report: made.report,
    }
}

impl Converted {
    /// The text of the profile.
    pub fn text(&self, format: crate::form::Format) -> String {
        let form: &dyn Form = &self.profile;
        crate::form::format(form, &Around::default(), &forms::WORDS, format)
    }
}

fn name(setup: &Setup, options: &Options<'_>) -> String {
    let first = setup.managers.first().map_or("", |m| m.conf.source.name());
    let given = options.name.and_then(names::dns_label);
    given
        .or_else(|| system_name(first))
        .unwrap_or_else(|| "system".to_owned())
}

/// Each instance once: a name stands for one component.
fn distinct<'a>(setup: &'a Setup, report: &mut Report) -> Vec<(&'a Manager, &'a Component)> {
    let mut seen: HashMap<&str, &Component> = HashMap::new();
    let mut all = Vec::new();
    for manager in &setup.managers {
        for component in &manager.components {
            let instance = component.instance.as_str();
            if let Some(first) = seen.get(instance) {
                let place = first.place.as_ref();
                let place =
                    place.map_or_else(String::new, |p| format!(" by {}:{}", p.file, p.line));
                let message = format!("a component called `{instance}` is made{place} already");
                let help = format!(
                    "name this one: `{}?instance_name=NAME`",
                    component.type_name
                );
                let finding = Finding::error("conf-duplicate-instance", message);
                report.push(finding.at(component.place.clone()).help(help));
            } else if let Some(problem) = names::instance_name_problem(instance) {
                let message = format!("`{instance}` cannot name a component: {problem}");
                let finding = Finding::error("conf-bad-item", message);
                let help = "name it with `?instance_name=NAME`";
                report.push(finding.at(component.place.clone()).help(help));
            } else {
                seen.insert(instance, component);
                all.push((manager, component));
            }
        }
    }
    all
}

fn no_component(setup: &Setup) -> Finding {
    let entry = setup.managers.iter().find_map(|manager| {
        let conf = &manager.conf;
        let entry = conf
            .get("manager.components.precreate")
            .or(conf.entries.first())?;
        conf.place(entry.key.span)
    });
    if let [manager] = setup.managers.as_slice()
        && manager.conf.is_of_a_component()
    {
        let message = "this file configures one component and makes none, so there is no system";
        let help = "convert the `rtc.conf` that makes the component, and names this file: `CATEGORY.INSTANCE.config_file: FILE`";
        return Finding::error("conf-no-component", message)
            .at(entry)
            .help(help);
    }
    let finding = Finding::error(
        "conf-no-component",
        "no component is made, so there is no system",
    );
    finding
        .at(entry)
        .help("name the types in `manager.components.precreate`")
}

/// What is known while the profile is made.
struct Made<'a> {
    setup: &'a Setup,
    types: &'a Types<'a>,
    instances: HashMap<&'a str, &'a Component>,
    /// How many names stand for no component.
    unknown: usize,
    report: Report,
}

/// Most findings on names that stand for no component; the rest is counted.
const UNKNOWN: usize = 50;

impl<'a> Made<'a> {
    /// The component that a name means; behind `rtcloc://` a category stands before it.
    fn resolve(&self, name: &str) -> Option<&'a Component> {
        let found = self.instances.get(name).copied();
        found.or_else(|| self.instances.get(name.rsplit_once('.')?.1).copied())
    }

    fn unknown(&mut self, place: Option<Place>, name: &str, what: &str) {
        self.unknown += 1;
        if self.unknown > UNKNOWN {
            return;
        }
        let mut known: Vec<&str> = self.instances.keys().copied().collect();
        known.sort_unstable();
        let mut help = format!("{what} is left out");
        if let Some(near) = suggest::nearest(name, known) {
            help.push_str(&format!("; did you mean `{near}`?"));
        } else {
            help.push_str("; if another manager makes it, name its `rtc.conf` too");
        }
        let message = format!("no component called `{name}` is made");
        let finding = Finding::warning("conf-unknown-instance", message);
        self.report.push(finding.at(place).help(help));
    }

    /// The order of each manager's list; managers do not wait for each other.
    fn activation(&mut self, ids: &HashMap<&str, String>) -> Option<Order> {
        let setup = self.setup;
        let mut order = Order::default();
        let mut active = HashSet::new();
        for manager in &setup.managers {
            let mut sequence = 0;
            for item in &manager.view.preactivation {
                let name = local_name(&item.value);
                let Some(component) = self.resolve(name) else {
                    let place = manager.conf.place(item.span);
                    self.unknown(place, name, "its activation");
                    continue;
                };
                if !active.insert(component.instance.as_str()) {
                    continue;
                }
                sequence += 1;
                order.targets.push(forms::Condition {
                    xsi_type: text("rtsExt:condition_ext"),
                    sequence: text(sequence.to_string()),
                    target_component: Some(Box::new(TargetExecutionContext {
                        id: text("0"),
                        instance_name: text(component.instance.as_str()),
                        component_id: ids
                            .get(component.instance.as_str())
                            .and_then(|id| text(id.as_str())),
                        ..TargetExecutionContext::default()
                    })),
                    ..forms::Condition::default()
                });
            }
        }
        let mut resting: Vec<&str> = self
            .instances
            .keys()
            .copied()
            .filter(|i| !active.contains(i))
            .collect();
        resting.sort_unstable();
        if !resting.is_empty() {
            let message = format!(
                "`manager.components.preactivation` does not name {}, which OpenRTM-aist leaves Inactive",
                suggest::listed(resting.iter().copied())
            );
            let finding = Finding::new(Severity::Note, "conf-not-activated", message);
            self.report
                .push(finding.help("`rtsctl apply` activates every component"));
        }
        (!order.targets.is_empty()).then_some(order)
    }

    /// What a profile has no place for.
    fn not_carried(&mut self) {
        if self.unknown > UNKNOWN {
            let message = format!(
                "{} more names stand for no component",
                self.unknown - UNKNOWN
            );
            let finding = Finding::warning("conf-unknown-instance", message);
            self.report
                .push(finding.help("what is said of them is left out"));
        }
        for manager in &self.setup.managers {
            let view = &manager.view;
            let mut keys: Vec<&Text> = view.others.iter().collect();
            let modules = [
                "manager.modules.load_path",
                "manager.modules.preload",
                "manager.modules.abs_path_allowed",
            ];
            let more = [
                ("corba.nameservers", view.nameservers.len() > 1),
                ("naming.formats", view.naming_formats.len() > 1),
            ];
            let more = more.iter().filter(|(_, more)| *more).map(|(key, _)| *key);
            for key in modules.into_iter().chain(more).chain(["naming.enable"]) {
                let entry = manager
                    .conf
                    .get(key)
                    .filter(|entry| !entry.value.is_empty());
                keys.extend(entry.map(|entry| &entry.key));
            }
            keys.sort_by_key(|key| key.span.start);
            let Some(first) = keys.first() else { continue };
            let names: Vec<&str> = keys.iter().map(|key| key.value.as_str()).collect();
            let message = format!("a profile has no place for {}", names.join(", "));
            let finding = Finding::new(Severity::Note, "conf-not-carried", message);
            let help = "modules are found where the agent looks for them; of several name servers and formats the first counts";
            self.report
                .push(finding.at(manager.conf.place(first.span)).help(help));
        }
    }
}

/// A text of a form, which stands nowhere.
fn text(value: impl Into<String>) -> Option<Text> {
    Some(Text::new(value, Span::default()))
}

fn property(name: &str, value: &str) -> Property {
    Property {
        name: text(name),
        value: text(value),
        ..Property::default()
    }
}
