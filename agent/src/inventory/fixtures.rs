//! Managers and components for tests.

use rts_manager_api::control::{ComponentInfo, ManagerInventory};
use rts_plan::desired::ManagerKey;

use super::merge::View;

/// A component without anything.
pub(super) fn bare(instance: &str) -> ComponentInfo {
    ComponentInfo {
        instance: instance.to_owned(),
        type_name: "T".to_owned(),
        on_disconnect: None,
        system: None,
        incarnation: instance.to_owned(),
        recreate_hash: String::new(),
        stand_in: false,
        restarts: 0,
        created: String::new(),
        state: "Active".to_owned(),
        message: None,
        sets: Default::default(),
        active: String::new(),
        defaults: Default::default(),
        busy: None,
        execution_kind: "periodic".to_owned(),
        execution_context: None,
        rate: 1.0,
        executions: 0,
        timing: None,
        realtime: None,
        ports: Vec::new(),
        connectors: Vec::new(),
        bindings: Vec::new(),
        by_hand: None,
    }
}

/// A manager that answers.
pub(super) fn view(components: Vec<ComponentInfo>) -> View {
    View {
        key: ManagerKey {
            system: None,
            name: "main".to_owned(),
        },
        incarnation: "i".to_owned(),
        pid: 1,
        started: String::new(),
        responsive: true,
        silent: None,
        unseen: false,
        inventory: ManagerInventory {
            modules: Default::default(),
            opened: Default::default(),
            components,
            taps: Vec::new(),
        },
        usage: None,
    }
}
