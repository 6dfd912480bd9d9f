//! The page of a component.

use rts_controller_api::objects::{Component, ComponentStatus, Waiting};
use rts_schemas::system::{Direction, OnHang, PortKind, RestartPolicy};

use super::page::Page;
use super::{Scene, manager, node, policy, system_or_drift, timing};
use crate::show::conf;
use crate::show::progress::shortened;
use crate::show::table::Table;

pub(super) fn component(component: &Component, scene: &Scene) -> Page {
    let (name, spec, status) = (&component.metadata.name, &component.spec, &component.status);
    let mut page = Page::of(&component.metadata, status.created, scene);
    page.line("System", system_or_drift(&spec.system, status.drift));
    page.line("Type", &spec.type_name);
    page.line("Required", spec.required.to_string());
    page.line("Node", &status.node);
    page.line("Manager", manager::words(component, scene));
    page.line("State", &status.state);
    page.line(
        "Last state",
        status.last_known_state.clone().unwrap_or_default(),
    );
    page.line("Message", status.message.clone().unwrap_or_default());
    page.line("Restarts", status.restarts.to_string());
    if let Some(policy) = policy::of(component, scene) {
        page.line("Restart", policy::restart(policy));
        for (key, text) in policy::others(policy) {
            page.line(key, text);
        }
    }
    let manager = format!("manager/{}", manager::name_of(component));
    page.line(
        "Last exit",
        policy::last_exit(&manager, scene).unwrap_or_default(),
    );
    page.line("Incarnation", &status.incarnation);
    if status.stand_in {
        page.line("Stand-in", "true (none of its own code runs)");
    }
    if let Some(composite) = &spec.composite {
        page.line("Composite", composite.kind.as_str());
        page.line("Members", composite.members.join(", "));
    }
    if let Some(shared) = &status.execution_context {
        let order = format!("{} (order {})", shared.name, shared.order);
        page.line("Execution context", order);
        page.line("Runs with", status.runs_with.join(", "));
    }
    let rate = status.rate.map(|rate| format!("{rate} Hz"));
    page.line("Rate", rate.unwrap_or_default());
    page.line("Executions", status.executions.to_string());
    for (key, text) in timing::lines(status) {
        page.line(key, text);
    }
    let waiting: Vec<_> = concerning(component, scene).collect();
    page.waiting(waiting.iter().copied(), scene.now);
    if waiting.is_empty() {
        page.line("Waits for", status.waiting_on.clone().unwrap_or_default());
    }
    let help = node::help(&status.node, scene);
    let help = help.or_else(|| hang_help(component, scene));
    page.line("Help", help.unwrap_or_default());
    let target = format!("component/{name}");
    page.drift(&target, &spec.system, &status.drift_fields, scene);
    page.table("Configuration", &conf::table(component, None));
    if !status.ports.is_empty() {
        page.table("Ports", &ports(status));
    }
    let ends = scene.connectors.iter().filter(|c| {
        let of = |end: &str| {
            end.strip_prefix(name.as_str())
                .is_some_and(|rest| rest.starts_with('.'))
        };
        c.spec.system == spec.system && (of(&c.spec.source) || of(&c.spec.target))
    });
    let mut connectors = Table::new(&["NAME", "STATE", "SENT", "RECEIVED", "WAITS-FOR"]);
    for connector in ends {
        let status = &connector.status;
        connectors.row([
            connector.metadata.name.clone(),
            status.state.clone(),
            status.samples_sent.to_string(),
            status.samples_received.to_string(),
            shortened(status.waiting_on.clone().unwrap_or_default(), &waiting),
        ]);
    }
    page.table("Connectors", &connectors);
    let module = format!("module/{}@{}", spec.type_name, manager::name_of(component));
    page.events(scene, |event| {
        let about = [&target, &manager, &module];
        about.contains(&&event.spec.object) && event.spec.system == spec.system
    });
    page
}

/// What can be connected, looked at and written to.
fn ports(status: &ComponentStatus) -> Table {
    let mut table = Table::new(&["NAME", "DIRECTION", "TYPE"]);
    for port in &status.ports {
        let direction = match (port.kind, port.direction) {
            (PortKind::Service, _) => "service",
            (PortKind::Data, Some(Direction::In)) => "in",
            (PortKind::Data, Some(Direction::Out)) => "out",
            (PortKind::Data, None) => "",
        };
        let (name, of) = (port.name.clone(), port.data_type.clone());
        table.row([name, direction.to_owned(), of]);
    }
    table
}

/// What keeps a component from running when it is waited for: itself, its module, package, manager and node.
pub(super) fn targets(component: &Component) -> [String; 5] {
    let (name, spec, status) = (&component.metadata.name, &component.spec, &component.status);
    let manager = manager::name_of(component);
    [
        format!("component/{name}"),
        format!("module/{}@{manager}", spec.type_name),
        format!("package/{}@{}", spec.type_name, status.node),
        format!("manager/{manager}"),
        format!("node/{}", status.node),
    ]
}

/// What its system waits for that keeps a component from running.
fn concerning<'a>(component: &'a Component, scene: &'a Scene) -> impl Iterator<Item = &'a Waiting> {
    let targets = targets(component);
    let own = scene.systems.iter();
    own.filter(|s| s.spec.name == component.spec.system)
        .flat_map(|system| &system.status.waiting_on)
        .filter(move |waiting| targets.contains(&waiting.target))
}

/// What ends a callback that does not return; none when nothing hangs, or its policy ends it.
pub(super) fn hang_help(component: &Component, scene: &Scene) -> Option<String> {
    let status = &component.status;
    let waits = status.waiting_on.as_deref().unwrap_or_default();
    let policy = policy::of(component, scene).cloned().unwrap_or_default();
    if !waits.starts_with("has been in ") || policy.on_hang == OnHang::Restart {
        return None;
    }
    let manager = manager::of(component, scene);
    let pid = status.pid.or(manager.map(|m| m.status.pid))?;
    let inside = manager.map_or(&[][..], |m| &m.status.components);
    let others = inside
        .iter()
        .filter(|name| **name != component.metadata.name);
    let others = match others.map(String::as_str).collect::<Vec<_>>().as_slice() {
        [] => String::new(),
        names => format!(", with {} in it", names.join(", ")),
    };
    let then = match policy.restart {
        RestartPolicy::Never => "and it is not started again (rtsctl.restart is never)",
        RestartPolicy::Always | RestartPolicy::OnFailure => "and it is started again",
    };
    Some(format!(
        "`kill -9 {pid}` ends its process{others}, {then}; rtsctl.onHang: restart has that done by itself"
    ))
}
