//! An RTS Profile against the RTC Profiles of its components: what one says must be what the other has.

pub(super) mod component;
mod connector;
mod interfaces;

use std::collections::{BTreeSet, HashMap};

pub(crate) use connector::direction;

use super::library::{Found, Library};
use super::sink::Sink;
use crate::diagnostic::{Report, Severity};
use crate::rtc_profile::forms::{DataPort, ServicePort};
use crate::rts_profile::model::{Component, Target};
use crate::rts_profile::{ReadProfile, composite};
use crate::span::Text;
use crate::suggest;

/// What does not fit, and which profiles of the library were used: their indices, sorted.
pub fn against(read: &ReadProfile, library: &Library) -> (Report, Vec<usize>) {
    let mut against = Against {
        read,
        library,
        types: HashMap::new(),
        sink: Sink::new(&read.source, Report::default()),
    };
    let mut used = BTreeSet::new();
    for component in &read.profile.components {
        if composite::kind(component).is_some() {
            continue;
        }
        let Some(found) = library.find(component) else {
            against.missing(component);
            continue;
        };
        used.insert(found.index);
        let kind = against.types.entry(found.index);
        let kind = kind.or_insert_with(|| Type::of(found));
        component::component(&mut against.sink, component, found, kind);
    }
    for connector in &read.profile.connectors {
        connector::connector(&mut against, connector);
    }
    let mut report = against.sink.report;
    report.sort_by_place();
    (report, used.into_iter().collect())
}

struct Against<'a> {
    read: &'a ReadProfile,
    library: &'a Library,
    types: HashMap<usize, Type<'a>>,
    sink: Sink<'a>,
}

/// The ports of a type by their names.
struct Type<'a> {
    data: HashMap<&'a str, &'a DataPort>,
    service: HashMap<&'a str, &'a ServicePort>,
}

impl<'a> Type<'a> {
    fn of(found: Found<'a>) -> Self {
        let profile = &found.profile.profile;
        let data = profile.data_ports.iter();
        let service = profile.service_ports.iter();
        Self {
            data: data
                .filter_map(|port| Some((port.name.as_ref()?.trimmed(), port)))
                .collect(),
            service: service
                .filter_map(|port| Some((port.name.as_ref()?.trimmed(), port)))
                .collect(),
        }
    }
}

impl<'a> Against<'a> {
    fn missing(&mut self, component: &Component) {
        if self.sink.is_full() {
            return;
        }
        let Some(id) = component.id.as_ref() else {
            return;
        };
        let instance = component.instance_name.as_ref().map_or("", Text::trimmed);
        let Some(kind) = crate::rts_profile::type_name(component) else {
            return;
        };
        let help = match suggest::nearest(&kind, self.library.types()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "name the folder of its package with another `--rtc`".to_owned(),
        };
        let message =
            format!("there is no RTC Profile of the type `{kind}` of component `{instance}`");
        self.sink.warning("no-rtc-profile", message, id.span, help);
    }

    /// The component of an end, its bare port name, and its type.
    fn end(&self, target: &'a Target) -> Option<(&'a Component, &'a str, usize)> {
        let instance = target.instance_name.as_ref()?;
        let component = self.read.component(&instance.value)?;
        let port = component.bare_port(&target.port_name.as_ref()?.value);
        Some((component, port, self.library.find(component)?.index))
    }
}

/// How bad it is when a profile of just this version says otherwise, or one of another version.
fn severity(found: Found<'_>) -> Severity {
    match found.exact {
        true => Severity::Error,
        false => Severity::Warning,
    }
}

/// Which file says so.
pub(super) fn said_by(found: Found<'_>) -> String {
    let name = found.profile.source.name();
    let id = found.profile.profile.id.as_ref().map_or("", Text::trimmed);
    match found.exact || id.is_empty() {
        true => format!("so says {name}"),
        false => format!("so says {name}, which is of `{id}`"),
    }
}
