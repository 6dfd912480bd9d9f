//! A person changes by hand what runs; marks are kept as a manager keeps them.

use rts_agent_api::messages::NodeSpecEnvelope;
use rts_plan::desired::{PlacedComponent, PlacedConnector};
use rts_plan::observed::{ConnectorObserved, ConnectorState};
use rts_schemas::system::ConnectorSpec;

use super::agent::{FakeAgent, State};
use super::carry_out::incarnation_of;

impl FakeAgent {
    /// Sets a value of the set `default`.
    pub fn set_by_hand(&self, instance: &str, parameter: &str, value: &str) {
        let mark = self.told(|told| settings(told, instance));
        self.change(instance, |component| {
            let set = component.configuration.sets.entry("default".into());
            set.or_default().insert(parameter.into(), value.into());
            component.by_hand.configured = Some(mark);
        });
    }

    /// Active → Inactive.
    pub fn deactivate_by_hand(&self, instance: &str) {
        let mark = self.told(|told| settings(told, instance));
        self.change(instance, |component| {
            component.state = rts_plan::observed::LifeCycleState::Inactive;
            component.by_hand.deactivated = Some(mark);
        });
    }

    /// Removes a desired connector.
    pub fn disconnect_by_hand(&self, instance: &str, name: &str) {
        let mark = self.told(|told| connector(told, name)).unwrap();
        self.change(instance, |component| {
            component.connectors.retain(|c| c.name != name);
            component.by_hand.disconnected.insert(name.into(), mark);
        });
    }

    /// Makes a connector.
    pub fn connect_by_hand(&self, spec: &ConnectorSpec) {
        let mark = self.told(|told| connector(told, &spec.name));
        let target_incarnation = {
            let state = self.state.lock().unwrap();
            incarnation_of(&state, &spec.target.instance)
        };
        let made = ConnectorObserved {
            name: spec.name.clone(),
            source: spec.source.clone(),
            target: spec.target.clone(),
            target_incarnation,
            properties: spec.properties.clone(),
            by_hand: Some(mark.unwrap_or_default()),
            state: ConnectorState::Connected,
            transport: "direct".into(),
            samples_sent: 0,
            samples_received: 0,
            bytes: 0,
            drops: 0,
        };
        self.change(&spec.source.instance, |c| c.connectors.push(made));
    }

    fn told<T>(&self, what: impl FnOnce(&NodeSpecEnvelope) -> T) -> T {
        let state: &State = &self.state.lock().unwrap();
        what(state.spec.as_ref().unwrap())
    }
}

fn settings(told: &NodeSpecEnvelope, instance: &str) -> String {
    let mut all = told.spec.systems.iter().flat_map(|part| &part.components);
    let placed = all.find(|c| c.spec.instance == instance);
    placed.map_or_else(String::new, PlacedComponent::settings_digest)
}

/// None where it is not desired.
fn connector(told: &NodeSpecEnvelope, name: &str) -> Option<String> {
    let mut all = told.spec.systems.iter().flat_map(|part| &part.connectors);
    all.find(|c| c.spec.name == name)
        .map(PlacedConnector::digest)
}
