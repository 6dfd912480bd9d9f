//! Finds every problem of a profile in one run, with its place and a way to mend it.
//!
//! Cycles among the orders are found by rts-plan, which owns the graph.

mod against;
mod choices;
mod component;
mod composite;
mod configured;
mod connector;
mod constraint;
mod contexts;
mod library;
mod limits;
mod location;
mod order;
mod parameters;
mod placed;
mod recorded;
mod rtc;
mod service;
mod sink;
mod spec;
mod system;
mod value;
mod woken;

pub use against::against;
pub(crate) use against::direction;
pub use library::Library;
pub use limits::{Limits, Refusal};
pub use placed::placed;
pub use rtc::rtc_profile;
pub use spec::{Pointed, spec, spec_by_pointer};
pub use system::{System, system};

use std::collections::HashSet;

use crate::diagnostic::Report;
use crate::names;
use crate::rts_profile::model::{Component, Target, property_value};
use crate::rts_profile::{NAME_KEY, ReadProfile};
use crate::span::{Span, Text};
use crate::suggest;
use sink::{Sink, said};

/// All problems of a profile, errors and warnings, those of reading first.
pub fn profile(read: &ReadProfile) -> Report {
    let mut seen = HashSet::new();
    let names = read
        .profile
        .components
        .iter()
        .filter_map(|c| c.instance_name.as_ref());
    let instances = names
        .map(Text::trimmed)
        .filter(|name| seen.insert(*name))
        .collect();
    let mut check = Check {
        read,
        instances,
        sink: Sink::new(&read.source, read.findings.clone()),
    };
    check.header();
    for component in &read.profile.components {
        component::component(&mut check, component);
        parameters::parameters(&mut check, component);
    }
    component::duplicates(&mut check);
    composite::composites(&mut check);
    location::locations(&mut check);
    connector::connectors(&mut check);
    for order in &read.profile.orders {
        order::order(&mut check, order);
    }
    check.sink.report
}

/// What every check needs: the profile, its names, and where to put findings.
struct Check<'a> {
    read: &'a ReadProfile,
    instances: Vec<&'a str>,
    sink: Sink<'a>,
}

impl<'a> Check<'a> {
    fn error(&mut self, code: &str, message: String, span: Span, help: impl Into<String>) {
        self.sink.error(code, message, span, help);
    }

    fn warning(&mut self, code: &str, message: String, span: Span, help: impl Into<String>) {
        self.sink.warning(code, message, span, help);
    }

    /// The attribute's text; an error when it is missing or blank.
    fn required(
        &mut self,
        text: &'a Option<Text>,
        key: &str,
        owner: &str,
        span: Span,
    ) -> Option<&'a Text> {
        match text {
            Some(text) if !text.trimmed().is_empty() => Some(text),
            found => {
                let key = self.read.spelled(key);
                let what = if found.is_some() { "empty" } else { "missing" };
                let span = found.as_ref().map_or(span, |text| text.span);
                self.error(
                    "missing-attribute",
                    format!("`{key}` of {owner} is {what}"),
                    span,
                    format!("add `{key}`"),
                );
                None
            }
        }
    }

    /// The name of a component that must be in the profile.
    fn instance(&mut self, target: &'a Target, owner: &str) -> Option<&'a str> {
        let name = self.required(&target.instance_name, "instanceName", owner, target.span)?;
        if let Some(component) = self.read.component(&name.value) {
            self.same_type(target, component, owner);
            return Some(name.trimmed());
        }
        if self.sink.is_full() {
            return None;
        }
        let help = if self.instances.is_empty() {
            "the profile has no component".to_owned()
        } else {
            suggest::advice(name.trimmed(), "components", &self.instances)
        };
        let message = format!(
            "{owner} names the component `{}`, which the profile does not have",
            name.trimmed()
        );
        self.error("unknown-instance", message, name.span, help);
        None
    }

    /// The id beside an instance name says a type too; the name decides.
    fn same_type(&mut self, target: &Target, component: &Component, owner: &str) {
        let instance = component.instance_name.as_ref().map_or("", Text::trimmed);
        let (Some(id), Some(own)) = (said(&target.component_id), said(&component.id)) else {
            return;
        };
        let kind = |id: &Text| names::type_name(&id.value, instance);
        let (Some(named), Some(real)) = (kind(id), kind(own)) else {
            return;
        };
        if named != real {
            let message = format!(
                "{owner} is `{instance}` of the type `{named}`, but `{instance}` is a `{real}`"
            );
            let help = format!(
                "write `{}`, or name the instance that is meant; the name counts",
                own.trimmed()
            );
            self.warning("component-id-mismatch", message, id.span, help);
        }
    }

    fn header(&mut self) {
        let profile = &self.read.profile;
        if profile.components.is_empty() {
            let help = format!("add `{}`", self.read.spelled("Components"));
            let message = "the profile has no components: there is nothing to run".to_owned();
            self.warning("empty-system", message, profile.span, help);
        }
        let named = property_value(&profile.properties, NAME_KEY).is_some();
        if !named && profile.id.as_ref().is_none_or(|id| id.trimmed().is_empty()) {
            let key = self.read.spelled("id");
            let help = format!("add `{key}` in the form `RTSystem:vendor:name:version`");
            self.warning(
                "missing-attribute",
                format!("`{key}` of the profile is missing"),
                profile.span,
                help,
            );
        }
        let key = self.read.spelled("version");
        match &profile.version {
            Some(version) if matches!(version.trimmed(), "0.1" | "0.2") => {}
            Some(version) => {
                let message = format!(
                    "`{}` is not a version of the RTS Profile",
                    version.trimmed()
                );
                self.warning(
                    "unknown-version",
                    message,
                    version.span,
                    "versions: 0.1, 0.2; it is read as 0.2",
                );
            }
            None => self.warning(
                "missing-attribute",
                format!("`{key}` of the profile is missing; it is read as 0.2"),
                profile.span,
                format!("add `{key}` with the value `0.2`"),
            ),
        }
    }
}
