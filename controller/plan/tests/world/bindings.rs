//! In-port ends: each stays at its port when its source goes, until somebody unbinds it.

use std::collections::BTreeSet;

use rts_plan::desired::SystemRef;
use rts_plan::observed::{BindingObserved, ConnectorState, ManagerObserved};
use rts_schemas::system::PortRef;

use super::World;

impl World {
    /// Binds an in-port of the component with this incarnation, in the place of another end that its process has for
    /// that connector.
    pub fn bind(&mut self, connector: &str, source: &PortRef, port: &str, target: &str) {
        let holds = |m: &&mut ManagerObserved| m.components.iter().any(|c| c.incarnation == target);
        let Some(manager) = self.managers_mut().find(holds) else {
            return;
        };
        for component in &mut manager.components {
            component.bindings.retain(|b| b.connector != connector);
            if component.incarnation == target {
                component.bindings.push(BindingObserved {
                    connector: connector.to_owned(),
                    port: port.to_owned(),
                    source: Some(source.clone()),
                    // Who is connected is found when somebody looks.
                    connected: false,
                    samples_received: 0,
                    drops: 0,
                    gaps: 0,
                });
            }
        }
    }

    /// Unbinds a connector in the processes of a system on a node that answer.
    pub fn unbind(&mut self, node: &str, system: Option<&SystemRef>, connector: &str) {
        let Some(inventory) = self.nodes.get_mut(node) else {
            return;
        };
        let managers = inventory.managers.iter_mut();
        let own = managers.filter(|m| m.responsive && m.key.system.as_ref() == system);
        for component in own.flat_map(|m| &mut m.components) {
            component.bindings.retain(|b| b.connector != connector);
        }
    }

    /// Unbinds a connector of one component.
    pub fn unbind_at(&mut self, target: &str, connector: &str) {
        let own = self.components_mut().filter(|c| c.incarnation == target);
        own.for_each(|c| c.bindings.retain(|b| b.connector != connector));
    }

    /// The ends that somebody is connected to: connector and incarnation of the target.
    pub fn connected_ends(&self) -> BTreeSet<(String, String)> {
        let connectors = self.components().flat_map(|(_, _, c)| &c.connectors);
        let connected = connectors.filter(|c| c.state == ConnectorState::Connected);
        connected
            .map(|c| (c.name.clone(), c.target_incarnation.clone()))
            .collect()
    }

    /// An end without a source is at the component at this place in the list: for a connector that nobody ever wanted,
    /// or for one that is desired elsewhere.
    pub fn leave_end(&mut self, nth: usize, of_another: bool) {
        let mut own = self.components().filter(|(_, _, c)| c.system.is_some());
        let found = own
            .nth(nth)
            .map(|(_, _, c)| (c.incarnation.clone(), c.instance.clone()));
        drop(own);
        let Some((target, instance)) = found else {
            return;
        };
        let desired = self.desired();
        let parts = desired.nodes.values().flat_map(|spec| &spec.systems);
        let mut others = parts
            .flat_map(|part| &part.connectors)
            .filter(|c| of_another && c.spec.target.instance != instance)
            .map(|c| c.spec.name.clone());
        let name = others.next().unwrap_or_else(|| "Gone.out-in".to_owned());
        let source = PortRef {
            instance: "Gone".to_owned(),
            port: "out".to_owned(),
        };
        self.bind(&name, &source, "in", &target);
    }

    /// Ends of components of systems that no desired connector asks for and nobody is connected to: connector and
    /// instance.
    pub fn left_ends(&self) -> Vec<(String, String)> {
        let (desired, connected) = (self.desired(), self.connected_ends());
        let mut left = Vec::new();
        for (_, key, component) in self.components() {
            let parts = desired.nodes.values().flat_map(|spec| &spec.systems);
            let own = parts.filter(|part| Some(&part.system) == key.system.as_ref());
            let wanted: BTreeSet<&str> = own
                .flat_map(|part| &part.connectors)
                .filter(|c| c.spec.target.instance == component.instance)
                .map(|c| c.spec.name.as_str())
                .collect();
            for binding in component
                .bindings
                .iter()
                .filter(|_| component.system.is_some())
            {
                let end = (binding.connector.clone(), component.incarnation.clone());
                if !wanted.contains(binding.connector.as_str()) && !connected.contains(&end) {
                    left.push((end.0, component.instance.clone()));
                }
            }
        }
        left
    }
}
