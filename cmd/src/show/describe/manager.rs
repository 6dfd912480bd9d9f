//! The page of a manager.

use rts_controller_api::objects::{Component, Manager};

use super::page::Page;
use super::{Scene, component_table, policy, system_or_drift};
use crate::show::age::short_time;
use crate::show::size::bytes;

pub(super) fn manager(manager: &Manager, scene: &Scene) -> Page {
    let (name, status) = (&manager.metadata.name, &manager.status);
    let mut page = Page::of(&manager.metadata, status.started, scene);
    page.line(
        "System",
        system_or_drift(&manager.spec.system, manager.spec.system.is_empty()),
    );
    page.line("Node", &status.node);
    page.line("PID", status.pid.to_string());
    page.line("State", &status.state);
    page.line("Incarnation", &status.incarnation);
    page.line("Modules", status.modules.join(", "));
    if let Some(usage) = &status.activity.usage {
        page.line("Memory", bytes(usage.memory as f64));
        page.line(
            "CPU time",
            short_time(usage.cpu_ms.saturating_mul(1_000_000)),
        );
    }
    // Who looks at its ports, or writes to them: `rtsctl port`.
    let taps = status.activity.taps.iter();
    let taps: Vec<String> = taps
        .map(|tap| format!("{} ({})", tap.port, tap.way))
        .collect();
    page.line("Taps", taps.join(", "));
    let target = format!("manager/{name}");
    page.line(
        "Last exit",
        policy::last_exit(&target, scene).unwrap_or_default(),
    );
    let waiting = scene.systems.iter().flat_map(|s| &s.status.waiting_on);
    page.waiting(waiting.filter(|w| w.target == target), scene.now);
    let inside = scene
        .components
        .iter()
        .filter(|c| c.status.node == status.node && status.components.contains(&c.metadata.name));
    page.table("Components", &component_table(inside));
    page.events(scene, |event| event.spec.object == target);
    page
}

/// A component's manager as events and waits name it: `hello.main`.
pub(super) fn name_of(component: &Component) -> String {
    let (system, short) = (&component.spec.system, &component.status.manager);
    if short.contains('.') || system.is_empty() {
        short.clone()
    } else {
        format!("{system}.{short}")
    }
}

/// The manager that a component is in, or would be.
pub(super) fn of<'a>(component: &Component, scene: &'a Scene) -> Option<&'a Manager> {
    let name = name_of(component);
    let mut managers = scene.managers.iter();
    managers.find(|m| m.metadata.name == name && m.status.node == component.status.node)
}

/// `main (pid 4711)`; a state that is not Ready is told as well.
pub(super) fn words(component: &Component, scene: &Scene) -> String {
    let manager = of(component, scene);
    let state = manager.map(|manager| manager.status.state.as_str());
    let state = match state.filter(|state| *state != "Ready") {
        Some(state) => format!(", {state}"),
        None => String::new(),
    };
    let pid = component.status.pid;
    match pid.or(manager.map(|manager| manager.status.pid)) {
        Some(pid) => format!("{} (pid {pid}{state})", component.status.manager),
        None => format!("{} (no process)", component.status.manager),
    }
}
