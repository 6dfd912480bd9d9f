//! Manager objects.

use rts_controller_api::objects::{Kind, Manager, ManagerStatus, ManagerView, Metadata};
use rts_plan::observed::{Activity, ManagerObserved};

use super::{Scene, object};

/// Managers that were observed on a node; of an unknown node those last seen.
pub fn of_node(scene: &Scene<'_>, node: &str) -> Vec<Manager> {
    let Some((inventory, known)) = scene.inventories.get(node) else {
        return Vec::new();
    };
    let found = inventory.managers.iter();
    found.map(|found| manager(node, found, *known)).collect()
}

fn manager(node: &str, found: &ManagerObserved, known: bool) -> Manager {
    let system = found.key.system.as_ref().map(|s| s.name.clone());
    let started = found.started.parse().ok();
    let state = match (known, found.responsive) {
        (false, _) => "Unknown",
        (true, false) => "Unresponsive",
        (true, true) => "Ready",
    };
    object(
        Kind::Manager,
        Metadata {
            name: found.key.display_name(),
            uid: found.incarnation.clone(),
            creation_timestamp: started,
            ..Metadata::default()
        },
        ManagerView {
            system: system.unwrap_or_default(),
        },
        ManagerStatus {
            node: node.to_owned(),
            pid: found.pid,
            state: state.to_owned(),
            components: found
                .components
                .iter()
                .map(|c| c.instance.clone())
                .collect(),
            modules: found.modules.iter().cloned().collect(),
            incarnation: found.incarnation.clone(),
            started,
            activity: match known {
                true => found.activity.clone(),
                false => Activity::default(),
            },
        },
    )
}
