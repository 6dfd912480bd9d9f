//! What a stand-in is made of: the ports, parameters and behaviour of the component whose place it takes, as far as its
//! system says them.
//!
//! Pure: whether there is a stand-in is decided elsewhere.

mod ports;
mod profile;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::system::{ComponentSpec, PortKind, PortSpec, StandInFault};

pub use ports::Ends;
pub use profile::facts;

/// What a stand-in is made of. All of it is fixed when it is created.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Shape {
    /// Its ports. A data port without direction or data type is undetermined: listed, but nothing can be connected.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ports: Vec<PortSpec>,
    /// Its parameters with their defaults.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, String>,
    /// Rate in Hz that its type has; what its system says goes before that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// Milliseconds that its initialising takes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub startup_time_ms: Option<u64>,
    /// What it fails in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fail: Option<StandInFault>,
    /// Milliseconds after its activation at which it brings its process down.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crash_after_ms: Option<u64>,
}

impl Shape {
    /// The shape of a component's stand-in. `ends` are those of its system.
    pub fn of<'a>(component: &'a ComponentSpec, ends: &Ends<'a>) -> Self {
        let said = &component.stand_in;
        let sets = component.configuration.sets.values();
        let names = sets.flat_map(BTreeMap::keys);
        let mut parameters: BTreeMap<_, _> =
            names.map(|name| (name.clone(), String::new())).collect();
        if let Some(profile) = &said.profile {
            parameters.extend(profile.parameters.clone());
        }
        Self {
            ports: ends.ports(component),
            parameters,
            rate: said.profile.as_ref().and_then(|profile| profile.rate),
            startup_time_ms: said.startup_time_ms,
            fail: said.fail,
            crash_after_ms: said.crash_after_ms,
        }
    }

    /// Why nothing can be connected to a data port; none when that is possible.
    pub fn undetermined(&self, port: &str) -> Option<&'static str> {
        let port = self.ports.iter().find(|own| own.name == port)?;
        if port.kind == PortKind::Service {
            return None;
        }
        match (port.direction, &port.data_type) {
            (None, _) => Some("its direction is not known"),
            (_, None) => Some("its data type is not known"),
            (Some(_), Some(_)) => None,
        }
    }
}

#[cfg(test)]
mod tests;
