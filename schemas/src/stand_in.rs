//! What a stand-in is made of: the ports, parameters and behaviour of the component whose place it takes, as far as its
//! system says them.
//!
//! Pure: whether there is a stand-in is decided elsewhere.

mod ports;
mod profile;
pub mod recorded;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::system::{ComponentSpec, PortKind, PortSpec, StandInFault, SystemSpec};

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
    /// Values that its out-ports play instead of numbers, from the first again after the last.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub data: BTreeMap<String, Vec<Vec<String>>>,
}

/// The shapes of the stand-ins for these instances of a system. One that was made of more than it would be now stays as it
/// was: to take a connector or a parameter away is no reason to make it again.
pub fn shapes<'a>(
    spec: &SystemSpec,
    instances: impl IntoIterator<Item = &'a String>,
    before: &BTreeMap<String, Shape>,
) -> BTreeMap<String, Shape> {
    let ends = Ends::of(spec);
    let instances: BTreeSet<&String> = instances.into_iter().collect();
    let components = spec.components.iter();
    components
        .filter(|component| instances.contains(&component.instance))
        .map(|component| {
            let now = Shape::of(component, &ends);
            let before = before.get(&component.instance);
            let before = before.filter(|before| before.covers(&now));
            let shape = before.cloned().unwrap_or(now);
            (component.instance.clone(), shape)
        })
        .collect()
}

impl Shape {
    /// True when it behaves as another one, and has all that the other one has.
    fn covers(&self, other: &Self) -> bool {
        let behaviour = |shape: &Self| Self {
            ports: Vec::new(),
            parameters: BTreeMap::new(),
            ..shape.clone()
        };
        let mut parameters = other.parameters.iter();
        behaviour(self) == behaviour(other)
            && other.ports.iter().all(|port| self.ports.contains(port))
            && parameters.all(|(name, default)| self.parameters.get(name) == Some(default))
    }

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
            data: said.data.clone(),
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
