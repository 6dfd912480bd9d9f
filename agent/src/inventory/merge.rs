//! Turning the answers of managers into one inventory. Strings are read leniently: a manager may be of another version.

use std::collections::HashMap;

use rts_manager_api::control::{
    ComponentInfo, ConnectorInfo, ManagerInventory, PortInfo, SystemId,
};
use rts_plan::desired::{ManagerKey, SystemRef};
use rts_plan::observed::{
    ComponentObserved, ConnectorObserved, ConnectorState, Inventory, LifeCycleState,
    ManagerObserved, PortObserved,
};
use rts_schemas::system::{Configuration, Direction, ExecutionKind, PortKind, PortRef};

/// What is known of one manager.
#[derive(Debug, Clone)]
pub(crate) struct View {
    pub key: ManagerKey,
    pub incarnation: String,
    pub pid: u32,
    pub started: String,
    pub responsive: bool,
    pub inventory: ManagerInventory,
}

/// Samples received, by (system, connector, in-port end).
type Received = HashMap<(Option<SystemRef>, String, PortRef), u64>;

/// Merges the answers; the revision is 0.
pub(crate) fn merge(node: &str, mut views: Vec<View>) -> Inventory {
    views.sort_by(|a, b| a.key.cmp(&b.key));
    let received = received(&views);
    Inventory {
        node: node.to_owned(),
        revision: 0,
        managers: views.into_iter().map(|v| manager(v, &received)).collect(),
    }
}

fn received(views: &[View]) -> Received {
    let mut received = Received::new();
    for view in views {
        for component in &view.inventory.components {
            for binding in &component.bindings {
                let target = PortRef {
                    instance: component.instance.clone(),
                    port: binding.port.clone(),
                };
                let key = (view.key.system.clone(), binding.connector.clone(), target);
                received.insert(key, binding.samples_received);
            }
        }
    }
    received
}

fn manager(view: View, received: &Received) -> ManagerObserved {
    let mut components: Vec<_> = view
        .inventory
        .components
        .into_iter()
        .map(|c| component(c, view.key.system.as_ref(), received))
        .collect();
    components.sort_by(|a, b| a.instance.cmp(&b.instance));
    ManagerObserved {
        key: view.key,
        incarnation: view.incarnation,
        pid: view.pid,
        started: view.started,
        responsive: view.responsive,
        modules: view.inventory.modules,
        components,
    }
}

fn component(
    info: ComponentInfo,
    system: Option<&SystemRef>,
    received: &Received,
) -> ComponentObserved {
    let mut connectors: Vec<_> = info
        .connectors
        .into_iter()
        .map(|c| connector(&info.instance, c, system, received))
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
        execution_kind: execution_kind(&info.execution_kind),
        rate: info.rate,
        executions: info.executions,
        ports: info.ports.into_iter().map(port).collect(),
        connectors,
        instance: info.instance,
    }
}

fn connector(
    instance: &str,
    info: ConnectorInfo,
    system: Option<&SystemRef>,
    received: &Received,
) -> ConnectorObserved {
    let target = PortRef {
        instance: info.target_instance,
        port: info.target_port,
    };
    let key = (system.cloned(), info.name.clone(), target.clone());
    ConnectorObserved {
        name: info.name,
        source: PortRef {
            instance: instance.to_owned(),
            port: info.port,
        },
        target,
        target_incarnation: info.target_incarnation,
        properties: info.properties,
        state: connector_state(&info.state),
        transport: info.transport,
        samples_sent: info.samples_sent,
        samples_received: received.get(&key).copied().unwrap_or(0),
        bytes: info.bytes,
        drops: info.drops,
    }
}

fn port(info: PortInfo) -> PortObserved {
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
