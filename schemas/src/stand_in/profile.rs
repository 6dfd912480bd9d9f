//! What an RTC Profile says of the components of its type, as far as a stand-in needs it.

use crate::check::{Library, direction};
use crate::rtc_profile::forms::{Configuration, DataPort, RtcProfile, ServicePort};
use crate::rts_profile::{normal_data_type, parse_rate};
use crate::span::Text;
use crate::system::{ComponentSpec, PortKind, PortSpec, RtcFacts};

/// What the library says of a component's type; none when it does not have it.
pub fn facts(library: &Library, component: &ComponentSpec) -> Option<RtcFacts> {
    let read = library.of_type(&component.full_id, &component.type_name)?;
    Some(of(&read.profile))
}

fn of(profile: &RtcProfile) -> RtcFacts {
    let set = profile.configuration_set.as_deref();
    let parameters = set.into_iter().flat_map(|set| &set.configurations);
    let rate = profile.basic_info.as_deref();
    let rate = rate.and_then(|info| info.execution_rate.as_ref());
    let data = profile.data_ports.iter().filter_map(data_port);
    let service = profile.service_ports.iter().filter_map(service_port);
    RtcFacts {
        ports: data.chain(service).collect(),
        parameters: parameters.filter_map(parameter).collect(),
        rate: rate.and_then(|rate| parse_rate(&rate.value)),
    }
}

fn data_port(port: &DataPort) -> Option<PortSpec> {
    let kind = port.port_type.as_ref().map(Text::trimmed);
    Some(PortSpec {
        name: name(port.name.as_ref())?,
        kind: PortKind::Data,
        direction: kind.and_then(direction),
        data_type: port
            .data_type
            .as_ref()
            .and_then(|text| normal_data_type(&text.value)),
    })
}

fn service_port(port: &ServicePort) -> Option<PortSpec> {
    Some(PortSpec {
        name: name(port.name.as_ref())?,
        kind: PortKind::Service,
        direction: None,
        data_type: None,
    })
}

fn parameter(of: &Configuration) -> Option<(String, String)> {
    let default = of.default_value.as_ref().map_or("", |text| &text.value);
    Some((name(of.name.as_ref())?, default.to_owned()))
}

fn name(text: Option<&Text>) -> Option<String> {
    let name = text?.trimmed();
    (!name.is_empty()).then(|| name.to_owned())
}
