//! A person changes by hand what runs; marks are kept as a manager keeps them.

use rts_agent_api::messages::NodeSpecEnvelope;
use rts_plan::desired::{PlacedComponent, PlacedConnector};
use rts_plan::mark::{self, Change, Mark};
use rts_plan::observed::{ComponentObserved, ConnectorObserved, ConnectorState};
use rts_schemas::system::ConnectorSpec;

use super::agent::{FakeAgent, State};
use super::carry_out::incarnation_of;

impl FakeAgent {
    /// Sets a value of the set `default`.
    pub fn set_by_hand(&self, instance: &str, parameter: &str, value: &str) {
        let placed = self.told(|told| placed(told, instance).cloned());
        self.change(instance, |component| {
            component.by_hand.configured = placed.map(|p| marked(&p, component, parameter, value));
            let set = component.configuration.sets.entry("default".into());
            set.or_default().insert(parameter.into(), value.into());
        });
    }

    /// Active → Inactive.
    pub fn deactivate_by_hand(&self, instance: &str) {
        let mark = self.told(|told| placed(told, instance).map(PlacedComponent::settings_digest));
        self.change(instance, |component| {
            component.state = rts_plan::observed::LifeCycleState::Inactive;
            component.by_hand.deactivated = Some(mark.unwrap_or_default());
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
            gaps: 0,
            rate: 0,
            latency: None,
        };
        self.change(&spec.source.instance, |c| c.connectors.push(made));
    }

    fn told<T>(&self, what: impl FnOnce(&NodeSpecEnvelope) -> T) -> T {
        let state: &State = &self.state.lock().unwrap();
        what(state.spec.as_ref().unwrap())
    }
}

fn placed<'a>(told: &'a NodeSpecEnvelope, instance: &str) -> Option<&'a PlacedComponent> {
    let mut all = told.spec.systems.iter().flat_map(|part| &part.components);
    all.find(|c| c.spec.instance == instance)
}

/// The mark of a component with one more value of the set `default` that a person sets.
fn marked(
    placed: &PlacedComponent,
    component: &ComponentObserved,
    parameter: &str,
    value: &str,
) -> String {
    let mut mark = Mark::of(component);
    let now = component.configuration.sets.get("default");
    if let Some(desired) = mark::desired(placed, component, "default", parameter) {
        let change = Change {
            desired,
            before: now.and_then(|set| set.get(parameter)).map(String::as_str),
            value,
            policy: placed.spec.policy.drift,
        };
        mark.change(mark::path("default", parameter), &change);
    }
    mark.encode()
}

/// None where it is not desired.
fn connector(told: &NodeSpecEnvelope, name: &str) -> Option<String> {
    let mut all = told.spec.systems.iter().flat_map(|part| &part.connectors);
    all.find(|c| c.spec.name == name)
        .map(PlacedConnector::digest)
}
