//! Turning the answers of managers into one inventory. Strings are read leniently: a manager may be of another version.

use std::collections::HashMap;
use std::time::Duration;

use rts_manager_api::control::{
    Busy, ByHandInfo, ComponentInfo, ConnectorInfo, ManagerInventory, PortInfo, SystemId,
};
use rts_plan::desired::{ManagerKey, SystemRef};
use rts_plan::observed::{
    ByHand, ComponentObserved, ConnectorObserved, ConnectorState, Inventory, LifeCycleState,
    ManagerObserved, PortObserved,
};
use rts_schemas::system::{
    Configuration, Direction, ExecutionKind, OnDisconnect, PortKind, PortRef,
};

use super::hang;
use crate::policies::Policies;

/// What is known of one manager.
#[derive(Debug, Clone)]
pub(crate) struct View {
    pub key: ManagerKey,
    pub incarnation: String,
    pub pid: u32,
    pub started: String,
    pub responsive: bool,
    /// Since when it has not answered.
    pub silent: Option<Duration>,
    pub inventory: ManagerInventory,
}

/// Samples received, by (connector, incarnation with the in-port, in-port).
type Received = HashMap<(String, String, String), u64>;

/// Merges the answers; the revision is 0.
pub(crate) fn merge(node: &str, mut views: Vec<View>, policies: &Policies) -> Inventory {
    views.sort_by(|a, b| a.key.cmp(&b.key));
    let received = received(&views);
    Inventory {
        node: node.to_owned(),
        revision: 0,
        held: Vec::new(),
        managers: views
            .into_iter()
            .map(|v| manager(v, &received, policies))
            .collect(),
    }
}

fn received(views: &[View]) -> Received {
    let mut received = Received::new();
    for view in views {
        for component in &view.inventory.components {
            // One without a source counts what came over a connection that is no more.
            for binding in component.bindings.iter().filter(|b| b.connected) {
                let (end, port) = (component.incarnation.clone(), binding.port.clone());
                let key = (binding.connector.clone(), end, port);
                received.insert(key, binding.samples_received);
            }
        }
    }
    received
}

fn manager(view: View, received: &Received, policies: &Policies) -> ManagerObserved {
    let expired = hang::expired(policies, &view);
    let mut components: Vec<_> = view
        .inventory
        .components
        .into_iter()
        .map(|c| component(c, received, policies))
        .collect();
    components.sort_by(|a, b| a.instance.cmp(&b.instance));
    ManagerObserved {
        key: view.key,
        incarnation: view.incarnation,
        pid: view.pid,
        started: view.started,
        responsive: view.responsive,
        expired,
        modules: view.inventory.modules,
        opened: view.inventory.opened,
        components,
    }
}

fn component(info: ComponentInfo, received: &Received, policies: &Policies) -> ComponentObserved {
    let hangs = hang::hangs(policies, &info).map(hangs);
    let mut connectors: Vec<_> = info
        .connectors
        .into_iter()
        .map(|c| connector(&info.instance, c, received))
        .collect();
    connectors.sort_by(|a, b| a.name.cmp(&b.name));
    ComponentObserved {
        type_name: info.type_name,
        system: info.system.as_ref().map(system_ref),
        incarnation: info.incarnation,
        recreate_hash: info.recreate_hash,
        state: state(&info.state),
        message: info.message,
        restarts: info.restarts,
        created: info.created,
        configuration: Configuration {
            active: Some(info.active).filter(|a| !a.is_empty()),
            sets: info.sets,
        },
        defaults: info.defaults,
        hangs,
        on_disconnect: on_disconnect(info.on_disconnect.as_deref()),
        execution_kind: execution_kind(&info.execution_kind),
        rate: info.rate,
        executions: info.executions,
        ports: info.ports.into_iter().map(port).collect(),
        connectors,
        by_hand: info.by_hand.map(by_hand).unwrap_or_default(),
        instance: info.instance,
    }
}

fn by_hand(info: ByHandInfo) -> ByHand {
    ByHand {
        configured: info.configured,
        deactivated: info.deactivated,
        disconnected: info.disconnected,
    }
}

/// Says since when a callback has not returned.
fn hangs(busy: &Busy) -> String {
    format!(
        "has been in {} for {} s",
        busy.callback,
        busy.milliseconds / 1000
    )
}

fn connector(instance: &str, info: ConnectorInfo, received: &Received) -> ConnectorObserved {
    let target = PortRef {
        instance: info.target_instance,
        port: info.target_port,
    };
    let end = info.target_incarnation.clone();
    let key = (info.name.clone(), end, target.port.clone());
    ConnectorObserved {
        name: info.name,
        source: PortRef {
            instance: instance.to_owned(),
            port: info.port,
        },
        target,
        target_incarnation: info.target_incarnation,
        properties: info.properties,
        by_hand: info.by_hand,
        state: connector_state(&info.state),
        transport: info.transport,
        samples_sent: info.samples_sent,
        // The in-port's manager was asked a moment later, and a new connection counts from 0 at this end only.
        samples_received: received
            .get(&key)
            .map_or(0, |received| info.samples_sent.min(*received)),
        bytes: info.bytes,
        drops: info.drops,
    }
}

/// A port in the words of the plan.
pub(crate) fn port(info: PortInfo) -> PortObserved {
    PortObserved {
        name: info.name,
        kind: PortKind::Data,
        direction: match info.direction.as_str() {
            "in" => Some(Direction::In),
            "out" => Some(Direction::Out),
            _ => None,
        },
        data_type: info.data_type,
    }
}

fn state(text: &str) -> LifeCycleState {
    match text {
        "Inactive" => LifeCycleState::Inactive,
        "Active" => LifeCycleState::Active,
        "Error" => LifeCycleState::Error,
        _ => LifeCycleState::Created,
    }
}

fn connector_state(text: &str) -> ConnectorState {
    match text {
        "Connected" => ConnectorState::Connected,
        "Connecting" => ConnectorState::Connecting,
        _ => ConnectorState::Disconnected,
    }
}

/// What it does when a peer is lost; a manager of version 1 says nothing, and goes on.
fn on_disconnect(text: Option<&str>) -> OnDisconnect {
    match text {
        Some("deactivate") => OnDisconnect::Deactivate,
        Some("stop") => OnDisconnect::Stop,
        _ => OnDisconnect::Keep,
    }
}

/// Kind of an execution context by its name in the control protocol.
fn execution_kind(text: &str) -> ExecutionKind {
    match text {
        "periodic" => ExecutionKind::Periodic,
        "eventDriven" => ExecutionKind::EventDriven,
        _ => ExecutionKind::Other,
    }
}

/// A system in the words of the plan.
pub(crate) fn system_ref(id: &SystemId) -> SystemRef {
    SystemRef {
        name: id.name.clone(),
        uid: id.uid.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inventory::fixtures::{bare, view};
    use rts_manager_api::control::BindingInfo;

    /// A connector that sent so many samples, and its binding.
    fn seen(sent: u64, received: u64, connected: bool) -> u64 {
        let (mut a, mut b) = (bare("A"), bare("B"));
        a.connectors.push(ConnectorInfo {
            name: "c".to_owned(),
            port: "out".to_owned(),
            target_instance: "B".to_owned(),
            target_port: "in".to_owned(),
            target_incarnation: "B".to_owned(),
            properties: Default::default(),
            by_hand: None,
            state: "Connected".to_owned(),
            transport: "direct".to_owned(),
            samples_sent: sent,
            bytes: 0,
            drops: 0,
        });
        b.bindings.push(BindingInfo {
            connector: "c".to_owned(),
            port: "in".to_owned(),
            connected,
            samples_received: received,
            drops: 0,
            gaps: 0,
        });
        let inventory = merge("local", vec![view(vec![a, b])], &Policies::default());
        inventory.managers[0].components[0].connectors[0].samples_received
    }

    #[test]
    fn never_more_is_received_than_sent_and_only_over_this_connection() {
        assert_eq!(seen(9, 7, true), 7);
        assert_eq!(seen(9, 12, true), 9);
        assert_eq!(seen(9, 7, false), 0);
    }
}
