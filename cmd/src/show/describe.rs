//! Pages about one object, as `kubectl describe` prints them.

mod component;
mod page;
mod policy;
#[cfg(test)]
mod tests;

use jiff::Timestamp;
use rts_controller_api::objects::{
    Component, Connector, Event, Kind, Manager, Metadata, Node, System,
};

use self::component::component;
use self::page::Page;
use super::age::age;
use super::table::Table;
use crate::commands::get::singular;

/// Everything that there is, at one moment.
#[derive(Debug, Clone)]
pub struct Scene {
    /// When it was looked at.
    pub now: Timestamp,
    /// Systems.
    pub systems: Vec<System>,
    /// Nodes.
    pub nodes: Vec<Node>,
    /// Components.
    pub components: Vec<Component>,
    /// Connectors.
    pub connectors: Vec<Connector>,
    /// Managers.
    pub managers: Vec<Manager>,
    /// Events, oldest first.
    pub events: Vec<Event>,
}

/// Names of a kind.
pub fn names(kind: Kind, scene: &Scene) -> Vec<String> {
    fn of<'a>(all: impl Iterator<Item = &'a Metadata>) -> Vec<String> {
        all.map(|metadata| metadata.name.clone()).collect()
    }
    match kind {
        Kind::System => of(scene.systems.iter().map(|o| &o.metadata)),
        Kind::Node => of(scene.nodes.iter().map(|o| &o.metadata)),
        Kind::Component => of(scene.components.iter().map(|o| &o.metadata)),
        Kind::Connector => of(scene.connectors.iter().map(|o| &o.metadata)),
        Kind::Manager => of(scene.managers.iter().map(|o| &o.metadata)),
        Kind::Event => of(scene.events.iter().map(|o| &o.metadata)),
    }
}

/// A page for each object of a name: several nodes may have components of one name.
pub fn pages(kind: Kind, name: &str, scene: &Scene) -> Vec<String> {
    fn all<T>(objects: &[T], page: impl Fn(&T) -> Option<Page>) -> Vec<String> {
        objects
            .iter()
            .filter_map(|object| page(object).map(Page::text))
            .collect()
    }
    let meant = |metadata: &Metadata| metadata.name == name;
    let there = match kind {
        Kind::System => all(&scene.systems, |o| {
            meant(&o.metadata).then(|| system(o, scene))
        }),
        Kind::Node => all(&scene.nodes, |o| meant(&o.metadata).then(|| node(o, scene))),
        Kind::Component => all(&scene.components, |o| {
            meant(&o.metadata).then(|| component(o, scene))
        }),
        Kind::Connector => all(&scene.connectors, |o| {
            meant(&o.metadata).then(|| connector(o, scene))
        }),
        Kind::Manager => all(&scene.managers, |o| {
            meant(&o.metadata).then(|| manager(o, scene))
        }),
        Kind::Event => all(&scene.events, |o| {
            meant(&o.metadata).then(|| event(o, scene))
        }),
    };
    if there.is_empty() {
        return gone(kind, name, scene)
            .map(Page::text)
            .into_iter()
            .collect();
    }
    there
}

/// What is not there but was, or should be: what is known of it.
fn gone(kind: Kind, name: &str, scene: &Scene) -> Option<Page> {
    let target = format!("{}/{name}", singular(kind));
    let waiting: Vec<_> = scene
        .systems
        .iter()
        .flat_map(|system| &system.status.waiting_on)
        .filter(|waiting| waiting.target == target)
        .collect();
    let about = |event: &Event| event.spec.object == target;
    if waiting.is_empty() && !scene.events.iter().any(about) {
        return None;
    }
    let mut page = Page::default();
    page.line("Name", name);
    page.line("State", "not there");
    page.line(
        "Last exit",
        policy::last_exit(&target, scene).unwrap_or_default(),
    );
    page.waiting(waiting.into_iter(), scene.now);
    page.events(scene, about);
    Some(page)
}

fn system(system: &System, scene: &Scene) -> Page {
    let mut page = Page::of(&system.metadata, None, scene);
    let (spec, status) = (&system.spec, &system.status);
    page.line("Id", &spec.full_id);
    page.line("Phase", format!("{:?}", status.phase));
    page.line("Synced", status.synced.to_string());
    page.line("Healthy", status.healthy.to_string());
    page.line(
        "Observed",
        format!("generation {}", status.observed_generation),
    );
    let (active, components) = (status.active, status.components);
    page.line("Active", format!("{active} of {components} components"));
    for step in &status.progress.running {
        page.line("Runs", step);
    }
    page.waiting(status.waiting_on.iter(), scene.now);
    for note in &status.notes {
        page.line("Note", note);
    }
    for drift in &status.drift {
        page.line("Drift", drift);
    }
    let mut conditions = Table::new(&["TYPE", "STATUS", "REASON", "AGE", "MESSAGE"]);
    for condition in &status.conditions {
        conditions.row([
            condition.kind.clone(),
            condition.status.clone(),
            condition.reason.clone(),
            age(Some(condition.last_transition_time), scene.now),
            condition.message.clone(),
        ]);
    }
    page.table("Conditions", &conditions);
    let own = scene.components.iter();
    page.table(
        "Components",
        &component_table(own.filter(|c| c.spec.system == spec.name)),
    );
    page.events(scene, |event| event.spec.system == spec.name);
    page
}

fn component_table<'a>(components: impl Iterator<Item = &'a Component>) -> Table {
    let mut table = Table::new(&["NAME", "TYPE", "MANAGER", "STATE", "RESTARTS"]);
    for component in components {
        table.row([
            component.metadata.name.clone(),
            component.spec.type_name.clone(),
            component.status.manager.clone(),
            component.status.state.clone(),
            component.status.restarts.to_string(),
        ]);
    }
    table
}

fn node(node: &Node, scene: &Scene) -> Page {
    let mut page = Page::of(&node.metadata, None, scene);
    let (name, status) = (&node.metadata.name, &node.status);
    page.line("Endpoint", &node.spec.endpoint);
    page.line("Aliases", node.spec.aliases.join(", "));
    page.line("State", &status.state);
    page.line("Reason", status.reason.clone().unwrap_or_default());
    page.line("Message", status.message.clone().unwrap_or_default());
    page.line(
        "Last seen",
        format!("{} ago", age(status.last_seen, scene.now)),
    );
    page.line(
        "Agent",
        format!("version {}, session {}", status.version, status.session),
    );
    let target = format!("node/{name}");
    let waiting = scene.systems.iter().flat_map(|s| &s.status.waiting_on);
    page.waiting(waiting.filter(|w| w.target == target), scene.now);
    let mut managers = Table::new(&["NAME", "PID", "STATE", "COMPONENTS"]);
    for manager in scene.managers.iter().filter(|m| m.status.node == *name) {
        managers.row([
            manager.metadata.name.clone(),
            manager.status.pid.to_string(),
            manager.status.state.clone(),
            manager.status.components.join(","),
        ]);
    }
    page.table("Managers", &managers);
    page.events(scene, |event| event.spec.object == target);
    page
}

fn connector(connector: &Connector, scene: &Scene) -> Page {
    let (name, spec, status) = (&connector.metadata.name, &connector.spec, &connector.status);
    let mut page = Page::of(&connector.metadata, None, scene);
    page.line("System", system_or_drift(&spec.system, status.drift));
    page.line("Kind", format!("{:?}", spec.kind));
    page.line("Source", &spec.source);
    page.line("Target", &spec.target);
    page.line("Type", spec.data_type.clone().unwrap_or_default());
    for (key, value) in &spec.properties {
        page.line("Property", format!("{key}={value}"));
    }
    page.line("State", &status.state);
    page.line("Transport", &status.transport);
    let (sent, received) = (status.samples_sent, status.samples_received);
    page.line(
        "Samples",
        format!("{sent} sent, {received} received, {} dropped", status.drops),
    );
    page.line("Bytes", status.bytes.to_string());
    let target = format!("connector/{name}");
    let own = scene.systems.iter().filter(|s| s.spec.name == spec.system);
    let waiting: Vec<_> = own
        .flat_map(|system| &system.status.waiting_on)
        .filter(|waiting| waiting.target == target)
        .collect();
    page.waiting(waiting.iter().copied(), scene.now);
    if waiting.is_empty() {
        page.line("Waits for", status.waiting_on.clone().unwrap_or_default());
    }
    page.events(scene, |event| {
        event.spec.object == target && event.spec.system == spec.system
    });
    page
}

fn manager(manager: &Manager, scene: &Scene) -> Page {
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

fn event(event: &Event, scene: &Scene) -> Page {
    let mut page = Page::of(&event.metadata, event.status.time, scene);
    page.line("System", &event.spec.system);
    page.line("Type", &event.spec.kind);
    page.line("Reason", &event.spec.reason);
    page.line("Object", &event.spec.object);
    page.line("Message", &event.spec.message);
    page
}

fn system_or_drift(system: &str, drift: bool) -> String {
    match (system, drift) {
        ("", _) => "none (made by hand)".to_owned(),
        (system, true) => format!("{system} (drift)"),
        (system, false) => system.to_owned(),
    }
}
