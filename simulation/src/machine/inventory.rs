//! What a manager says of itself, and the marks of what a person changed.

use std::collections::BTreeMap;
use std::time::Duration;

use rts_manager_api::control::{
    BindingInfo, Busy, ByHandInfo, ComponentInfo, ConnectorInfo, ExecutionContextInfo,
    ManagerInventory,
};

use super::state::{Component, Connector, End, Process};

/// A callback that takes this long is shown.
const HANGS: Duration = Duration::from_secs(1);
/// Bytes of a sample.
const SAMPLE: u64 = 16;

impl Process {
    /// Everything in it.
    pub fn inventory(&self) -> ManagerInventory {
        let components = self.components.values().map(|component| {
            let ends = self.ends.values();
            let own = ends.filter(|end| end.incarnation == component.subject.incarnation);
            component.info(own.map(End::info).collect())
        });
        ManagerInventory {
            modules: self.modules.keys().cloned().collect(),
            opened: self.opened.clone(),
            components: components.collect(),
            taps: Vec::new(),
        }
    }

    /// Forgets marks, where they are still these.
    pub fn forget(
        &mut self,
        instance: &str,
        marks: &ByHandInfo,
        connectors: &BTreeMap<String, String>,
    ) {
        let Some(component) = self.components.get_mut(instance) else {
            return;
        };
        for (name, mark) in connectors {
            if let Some(connector) = component.connectors.get_mut(name) {
                connector.by_hand.take_if(|known| known == mark);
            }
        }
        let known = &mut component.by_hand;
        let same = |mark: &Option<String>| {
            let mark = mark.clone();
            move |known: &mut String| mark.as_ref() == Some(known)
        };
        known.configured.take_if(same(&marks.configured));
        known.deactivated.take_if(same(&marks.deactivated));
        let disconnected = &mut known.disconnected;
        disconnected.retain(|name, mark| marks.disconnected.get(name) != Some(mark));
    }
}

impl Component {
    fn info(&self, bindings: Vec<BindingInfo>) -> ComponentInfo {
        let busy = self.busy.map(|(call, since)| (call, since.elapsed()));
        let busy = busy.filter(|(_, running)| *running >= HANGS);
        ComponentInfo {
            instance: self.subject.instance.clone(),
            type_name: self.type_name.clone(),
            system: self.system.clone(),
            incarnation: self.subject.incarnation.clone(),
            recreate_hash: self.subject.recreate_hash.clone(),
            stand_in: self.stand_in,
            restarts: self.restarts,
            created: self.created.clone(),
            state: self.state.name().to_owned(),
            message: self.message.clone(),
            sets: self.configuration.sets.clone(),
            active: self.configuration.active.clone(),
            defaults: self.configuration.defaults.clone(),
            busy: busy.map(|(callback, running)| Busy {
                callback: callback.to_owned(),
                milliseconds: u64::try_from(running.as_millis()).unwrap_or(u64::MAX),
            }),
            on_disconnect: Some(self.on_disconnect.clone()),
            execution_kind: "periodic".to_owned(),
            execution_context: self.shared.as_deref().map(|shared| ExecutionContextInfo {
                name: shared.name.clone(),
                order: shared.order,
                shared_state: shared.shared_state.clone(),
                members: Vec::new(),
            }),
            rate: self.rate,
            executions: self.executions as u64,
            timing: None,
            realtime: self.realtime.clone(),
            ports: self.ports.clone(),
            connectors: self.connectors.values().map(Connector::info).collect(),
            bindings,
            by_hand: Some(self.by_hand.clone()),
        }
    }
}

impl Connector {
    fn info(&self) -> ConnectorInfo {
        let request = self.request.clone();
        let transport = match request.target_socket {
            None => "direct",
            Some(_) => "uds",
        };
        ConnectorInfo {
            name: request.connector,
            port: request.port,
            target_instance: request.target_instance,
            target_port: request.target_port,
            target_incarnation: request.target_incarnation,
            properties: request.properties,
            by_hand: self.by_hand.clone(),
            state: self.state().to_owned(),
            transport: transport.to_owned(),
            samples_sent: self.sent as u64,
            bytes: self.sent as u64 * SAMPLE,
            drops: 0,
            refused: 0,
            rate: 0,
        }
    }
}

impl End {
    fn info(&self) -> BindingInfo {
        let source = self.source.as_ref();
        BindingInfo {
            connector: self.binding.connector.clone(),
            port: self.binding.port.clone(),
            source: Some(self.binding.source.clone()),
            connected: source.is_some_and(|source| source.closed.is_none()),
            samples_received: source.map_or(0, |source| source.received as u64),
            drops: 0,
            gaps: 0,
            latency: None,
        }
    }
}
