//! Components: their ids, ports, configuration and execution context.

use std::collections::{HashMap, HashSet};

use super::connectors::Connected;
use super::types::Declared;
use super::{Made, property, text};
use crate::diagnostic::{Finding, Severity};
use crate::names;
use crate::rtc_conf::setup::{Component, Manager};
use crate::rts_profile::TYPE_KEY;
use crate::rts_profile::forms::{
    self, ConfigurationData, ConfigurationSet, DataPort, ExecutionContext, Location, Property,
    ServicePort,
};
use crate::suggest;
use crate::system::Direction;

/// Cycles in a second, where nobody says a number: OpenRTM-aist's own.
const RATE: &str = "1000.0";

const PERIODIC: &str = "PeriodicExecutionContext";

impl<'a> Made<'a> {
    /// Ids by instance: as told, else as an RTC Profile says, else made up.
    pub(super) fn ids(
        &mut self,
        components: &[(&Manager, &'a Component)],
    ) -> HashMap<&'a str, String> {
        let mut ids = HashMap::new();
        let mut guessed = HashSet::new();
        for (_, component) in components {
            let known = self.types.id(&component.type_name);
            let told = component.id.clone();
            if known.is_none() && told.is_none() && guessed.insert(component.type_name.as_str()) {
                self.report.push(unknown_type(component));
            }
            if let (Some([_, category, _]), Some(own)) = (&known, &component.category)
                && category != own
            {
                let message = format!(
                    "the configuration of `{}` is given for the category `{own}`, but its RTC Profile says `{category}`",
                    component.instance
                );
                let help = format!(
                    "OpenRTM-aist does not read it: write `{category}.{}.…`",
                    component.instance
                );
                let finding = Finding::warning("conf-other-category", message);
                self.report
                    .push(finding.at(component.place.clone()).help(help));
            }
            let known = known.unwrap_or_default();
            let mut fields = told.unwrap_or_default();
            for (field, known) in fields.iter_mut().zip(known) {
                if field.is_empty() {
                    *field = known;
                }
            }
            let [vendor, category, version] =
                fields.each_ref().map(|field| field.replace(':', "."));
            let own = component
                .category
                .as_ref()
                .map(|category| category.replace(':', "."));
            let or = |field: String, other: &str| {
                if field.is_empty() {
                    other.to_owned()
                } else {
                    field
                }
            };
            let id = format!(
                "RTC:{}:{}:{}:{}",
                or(vendor, "unknown"),
                or(category, own.as_deref().unwrap_or("unknown")),
                component.type_name,
                or(version, "1.0.0")
            );
            ids.insert(component.instance.as_str(), id);
        }
        ids
    }

    pub(super) fn component(
        &mut self,
        index: usize,
        manager: &Manager,
        component: &Component,
        ids: &HashMap<&str, String>,
        ends: &HashMap<&str, Vec<Connected<'_, '_>>>,
    ) -> forms::Component {
        let conf = &component.conf;
        let instance = component.instance.as_str();
        let id = ids.get(instance).cloned().unwrap_or_default();
        let own_type = names::type_name(&id, instance).as_deref() != Some(&component.type_name);
        let type_property = own_type.then(|| property(TYPE_KEY, &component.type_name));
        let others = conf
            .others
            .iter()
            .map(|(name, value)| property(name, value));
        let default = conf.sets.get("default").map(|_| "default");
        let active = conf.active.as_deref().or(default);
        let mut form = forms::Component {
            xsi_type: text("rtsExt:component_ext"),
            path_uri: text(path_uri(manager, component, &id)),
            id: text(id),
            instance_name: text(instance),
            active_configuration_set: active.and_then(text),
            composite_type: text("None"),
            is_required: text("true"),
            configuration_sets: sets(component),
            execution_contexts: vec![execution_context(component)],
            location: Some(Box::new(location(index))),
            properties: type_property.into_iter().chain(others).collect(),
            ..forms::Component::default()
        };
        self.composite(component, ids, &mut form);
        self.ports(
            component,
            ends.get(instance).map_or(&[], Vec::as_slice),
            &mut form,
        );
        form
    }

    /// The ports that the RTC Profile says, and those that are connected.
    fn ports(
        &mut self,
        component: &Component,
        connected: &[Connected<'_, '_>],
        form: &mut forms::Component,
    ) {
        let type_name = &component.type_name;
        let known = self.types.ports(type_name);
        let full = |port: &str| text(format!("{}.{port}", component.instance));
        for port in &known {
            match self.types.port(type_name, port) {
                Some(Declared::Service) => form.service_ports.push(service_port(full(port))),
                Some(Declared::Data(direction, data_type)) => {
                    form.data_ports
                        .push(data_port(full(port), direction, data_type));
                }
                None => {}
            }
        }
        let declared: HashSet<&str> = known.iter().copied().collect();
        for (port, connection) in connected
            .iter()
            .filter(|(port, _)| !declared.contains(port))
        {
            match connection.is_service {
                true => form.service_ports.push(service_port(full(port))),
                false => form.data_ports.push(data_port(full(port), None, None)),
            }
            if !known.is_empty() {
                let message = format!("the RTC Profile of `{type_name}` has no port `{port}`");
                let finding = Finding::warning("conf-unknown-port", message);
                let help = suggest::advice(port, "ports", &known);
                self.report.push(finding.at(connection.place()).help(help));
            }
        }
    }
}

fn unknown_type(component: &Component) -> Finding {
    let message = format!(
        "vendor and version of `{}` are not known",
        component.type_name
    );
    let finding = Finding::new(Severity::Warning, "conf-unknown-type", message);
    finding
        .at(component.place.clone())
        .help("`--rtc DIR` names a folder with its RTC Profile, which says its ports too")
}

fn sets(component: &Component) -> Vec<ConfigurationSet> {
    let sets = component
        .conf
        .sets
        .iter()
        .map(|(id, values)| ConfigurationSet {
            id: text(id),
            data: values
                .iter()
                .map(|(name, value)| ConfigurationData {
                    name: text(name),
                    data: text(value.as_str()),
                    ..ConfigurationData::default()
                })
                .collect(),
            ..ConfigurationSet::default()
        });
    sets.collect()
}

fn execution_context(component: &Component) -> ExecutionContext {
    let of = component.conf.execution_type.as_deref().map(str::trim);
    let other = of.filter(|of| *of != PERIODIC);
    ExecutionContext {
        xsi_type: text("rtsExt:execution_context_ext"),
        id: text("0"),
        kind: text(if other.is_some() { "OTHER" } else { "PERIODIC" }),
        rate: text(component.conf.rate.as_deref().unwrap_or(RATE)),
        properties: other.map(|of| property("type", of)).into_iter().collect(),
        ..ExecutionContext::default()
    }
}

fn data_port(
    name: Option<crate::span::Text>,
    direction: Option<Direction>,
    data_type: Option<String>,
) -> DataPort {
    let direction = direction.map(|direction| match direction {
        Direction::In => "DataInPort",
        Direction::Out => "DataOutPort",
    });
    let direction = direction.map(|direction| property("port.port_type", direction));
    let data_type = data_type.map(|name| property("dataport.data_type", &name));
    DataPort {
        xsi_type: text("rtsExt:dataport_ext"),
        name,
        properties: direction
            .into_iter()
            .chain(data_type)
            .collect::<Vec<Property>>(),
        ..DataPort::default()
    }
}

fn service_port(name: Option<crate::span::Text>) -> ServicePort {
    ServicePort {
        xsi_type: text("rtsExt:serviceport_ext"),
        name,
        properties: vec![property("port.port_type", "CorbaPort")],
        ..ServicePort::default()
    }
}

/// A place in the editor's drawing: rows of five.
fn location(index: usize) -> Location {
    Location {
        x: text((40 + 200 * (index % 5)).to_string()),
        y: text((40 + 160 * (index / 5)).to_string()),
        width: text("-1"),
        height: text("-1"),
        direction: text("RIGHT"),
        ..Location::default()
    }
}

/// The first name server, and the first of the paths that the component has there.
fn path_uri(manager: &Manager, component: &Component, id: &str) -> String {
    let server = manager
        .view
        .nameservers
        .first()
        .map_or("localhost", |text| address(&text.value));
    let formats = manager
        .view
        .naming_formats
        .first()
        .map(|text| text.value.as_str());
    let own = component.conf.naming_formats.as_deref();
    let format = own
        .and_then(|own| own.split(',').next())
        .or(formats)
        .unwrap_or("%n.rtc");
    format!("{server}/{}", named(format, manager, component, id))
}

/// `host` or `host:port` of the ways to name a name server: `ssliop:host:port`, `https://host:port/call`.
fn address(text: &str) -> &str {
    let text = text.rsplit_once("://").map_or(text, |(_, rest)| rest);
    let text = text.split('/').next().unwrap_or(text).trim();
    let start = match text.matches(':').count() {
        0 | 1 => 0,
        _ if text.starts_with('[') => 0,
        count => text
            .match_indices(':')
            .nth(count - 2)
            .map_or(0, |(at, _)| at + 1),
    };
    match &text[start..] {
        "" => "localhost",
        address => address,
    }
}

/// A path with its `%` filled in. The host is not known before it runs.
fn named(format: &str, manager: &Manager, component: &Component, id: &str) -> String {
    let fields: Vec<&str> = id.split(':').collect();
    let field = |at: usize| fields.get(at).copied().unwrap_or_default();
    let mut path = String::new();
    let mut chars = format.trim().chars();
    while let Some(c) = chars.next() {
        if c != '%' {
            path.push(c);
            continue;
        }
        match chars.next() {
            Some('n') => path.push_str(&component.instance),
            Some('t' | 'm' | 'i') => path.push_str(&component.type_name),
            Some('v') => path.push_str(field(4)),
            Some('V') => path.push_str(field(1)),
            Some('c') => path.push_str(field(2)),
            Some('h') => path.push_str("localhost"),
            Some('M') => path.push_str(&manager.name),
            Some('p') => path.push('0'),
            Some(c) => path.push(c),
            None => {}
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::address;

    #[test]
    fn addresses_of_name_servers() {
        for (text, expected) in [
            ("localhost", "localhost"),
            ("10.4.62.1:2809", "10.4.62.1:2809"),
            ("ssliop:localhost:2809", "localhost:2809"),
            ("https://127.0.0.1:2809/call", "127.0.0.1:2809"),
            ("corbaloc:ssliop:host:2809", "host:2809"),
            ("[fe80::1]:2809", "[fe80::1]:2809"),
            ("", "localhost"),
        ] {
            assert_eq!(address(text), expected);
        }
    }
}
