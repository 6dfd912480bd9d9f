//! RTC Profiles of the types that are made.

use std::collections::{HashMap, HashSet};

use crate::rtc_profile::forms::{DataPort, RtcProfile};
use crate::rts_profile::normal_data_type;
use crate::span::Text;
use crate::system::Direction;

/// RTC Profiles by type.
pub(super) struct Types<'a> {
    by_name: HashMap<&'a str, &'a RtcProfile>,
}

/// What a type says of one of its ports.
pub(super) enum Declared {
    /// A data port.
    Data(Option<Direction>, Option<String>),
    /// A service port.
    Service,
}

fn trimmed(text: Option<&Text>) -> &str {
    text.map_or("", Text::trimmed)
}

impl<'a> Types<'a> {
    pub(super) fn of(profiles: &'a [RtcProfile]) -> Self {
        let named = profiles.iter().filter_map(|profile| {
            let name = profile.basic_info.as_ref()?.name.as_ref()?.trimmed();
            (!name.is_empty()).then_some((name, profile))
        });
        Self {
            by_name: named.collect(),
        }
    }

    pub(super) fn get(&self, type_name: &str) -> Option<&'a RtcProfile> {
        self.by_name.get(type_name).copied()
    }

    /// Vendor, category and version.
    pub(super) fn id(&self, type_name: &str) -> Option<[String; 3]> {
        let info = self.get(type_name)?.basic_info.as_ref()?;
        Some(
            [&info.vendor, &info.category, &info.version]
                .map(|text| trimmed(text.as_ref()).to_owned()),
        )
    }

    pub(super) fn port(&self, type_name: &str, port: &str) -> Option<Declared> {
        let profile = self.get(type_name)?;
        let data = profile
            .data_ports
            .iter()
            .find(|p| trimmed(p.name.as_ref()) == port);
        if let Some(data) = data {
            let data_type = data
                .data_type
                .as_ref()
                .and_then(|text| normal_data_type(&text.value));
            return Some(Declared::Data(direction(data), data_type));
        }
        let mut services = profile.service_ports.iter();
        let service = services.any(|p| trimmed(p.name.as_ref()) == port);
        service.then_some(Declared::Service)
    }

    /// Names of the ports of a type, data ports first.
    pub(super) fn ports(&self, type_name: &str) -> Vec<&'a str> {
        let Some(profile) = self.get(type_name) else {
            return Vec::new();
        };
        let data = profile.data_ports.iter().map(|p| p.name.as_ref());
        let service = profile.service_ports.iter().map(|p| p.name.as_ref());
        let mut seen = HashSet::new();
        let names = data.chain(service).map(trimmed);
        names
            .filter(|name| !name.is_empty() && seen.insert(*name))
            .collect()
    }
}

fn direction(port: &DataPort) -> Option<Direction> {
    match trimmed(port.port_type.as_ref())
        .to_ascii_lowercase()
        .as_str()
    {
        "datainport" => Some(Direction::In),
        "dataoutport" => Some(Direction::Out),
        _ => None,
    }
}
