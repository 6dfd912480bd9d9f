//! What runs of a system at one moment.

use std::collections::BTreeMap;

use rts_controller_api::client::Controller;
use rts_controller_api::objects::{Component, Connector, Kind, Manager};
use serde::de::DeserializeOwned;

use crate::error::CliError;

/// Components, connectors and managers of one system.
#[derive(Debug, Clone, Default)]
pub struct Snapshot {
    /// Components.
    pub components: Vec<Component>,
    /// Connectors.
    pub connectors: Vec<Connector>,
    /// Managers.
    pub managers: Vec<Manager>,
}

impl Snapshot {
    /// As of now.
    pub async fn take(controller: &Controller, system: &str) -> Result<Self, CliError> {
        let mut snapshot = Self {
            components: list(controller, Kind::Component).await?,
            connectors: list(controller, Kind::Connector).await?,
            managers: list(controller, Kind::Manager).await?,
        };
        // Nothing of a composite itself runs.
        let own = |c: &Component| c.spec.system == system && c.spec.composite.is_none();
        snapshot.components.retain(own);
        snapshot.connectors.retain(|c| c.spec.system == system);
        snapshot.managers.retain(|m| m.spec.system == system);
        Ok(snapshot)
    }

    /// A component.
    pub fn component(&self, instance: &str) -> Option<&Component> {
        let mut all = self.components.iter();
        all.find(|component| component.metadata.name == instance)
    }

    /// How many components are stand-ins.
    pub fn stand_ins(&self) -> usize {
        self.components.iter().filter(|c| c.status.stand_in).count()
    }

    /// Instance → incarnation.
    pub fn incarnations(&self) -> BTreeMap<&str, &str> {
        let named = self.components.iter();
        named
            .map(|c| (c.metadata.name.as_str(), c.status.incarnation.as_str()))
            .collect()
    }

    /// Instances that are another incarnation now than they were.
    pub fn made_again<'a>(&'a self, before: &'a Self) -> impl Iterator<Item = &'a str> {
        let then = before.incarnations();
        self.incarnations()
            .into_iter()
            .filter(move |(name, now)| then.get(name).is_some_and(|then| then != now))
            .map(|(name, _)| name)
    }
}

/// Objects of a kind.
async fn list<T: DeserializeOwned>(
    controller: &Controller,
    kind: Kind,
) -> Result<Vec<T>, CliError> {
    let list = controller.list(kind).await;
    let list = list.map_err(CliError::request(format!("list {}", kind.plural())))?;
    Ok(list.items)
}

/// Instance name of an end (`Sine0.out`).
pub fn instance(end: &str) -> &str {
    end.rsplit_once('.').map_or(end, |(instance, _)| instance)
}
