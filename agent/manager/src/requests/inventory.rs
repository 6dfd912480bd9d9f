//! The inventory: everything as it is now. Waits for no component.

use std::collections::BTreeMap;

use rts_manager_api::control::{BindingInfo, ManagerInventory, ResponseBody};

use crate::manager::Manager;
use crate::sync::lock;

/// Collects it. In-port ends come first: what was received is read before what was sent, so it is never more.
pub fn inventory(manager: &Manager) -> ResponseBody {
    let mut bindings: BTreeMap<String, Vec<BindingInfo>> = BTreeMap::new();
    for end in manager.bindings.all() {
        bindings
            .entry(end.incarnation.clone())
            .or_default()
            .push(end.info());
    }
    let components = manager.components().into_iter().map(|component| {
        let mut info = component.info();
        info.bindings = bindings.remove(&info.incarnation).unwrap_or_default();
        info.connectors = component.connector_infos();
        info.connectors.sort_by(|a, b| a.name.cmp(&b.name));
        info
    });
    ResponseBody::Inventory(ManagerInventory {
        modules: lock(&manager.modules).keys().cloned().collect(),
        opened: lock(&manager.opened).clone(),
        components: components.collect(),
        taps: manager.taps.infos(),
    })
}
