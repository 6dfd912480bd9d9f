//! Pages about one object, as `kubectl describe` prints them.

mod component;
mod gone;
mod manager;
mod node;
mod page;
mod policy;
#[cfg(test)]
mod tests;
mod timing;

use std::collections::BTreeSet;

use jiff::Timestamp;
use rts_controller_api::objects::{
    Component, Connector, Event, Kind, Manager, Metadata, Node, System,
};

use self::component::component;
use self::manager::manager;
use self::node::node;
use self::page::Page;
use super::age::{age, short_time};
use super::table::Table;

/// Everything that there is, at one moment.
#[derive(Debug, Clone)]
pub struct Scene {
    /// When it was looked at.
    pub now: Timestamp,
    /// Nodes of the local controller whose agents do not run.
    pub lacking: Vec<String>,
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
        return gone::gone(kind, name, scene)
            .map(Page::text)
            .into_iter()
            .collect();
    }
    there
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
    if status.stand_ins > 0 {
        let text = format!("{} of {components} components", status.stand_ins);
        page.line("Stand-ins", text);
    }
    for step in &status.progress.running {
        page.line("Runs", step);
    }
    page.waiting(status.waiting_on.iter(), scene.now);
    let own: Vec<_> = components_of(system, scene).collect();
    let nodes: BTreeSet<_> = own.iter().map(|c| &c.status.node).collect();
    for help in nodes.into_iter().filter_map(|n| node::help(n, scene)) {
        page.line("Help", help);
    }
    for hangs in &own {
        let name = &hangs.metadata.name;
        let help = component::hang_help(hangs, scene).map(|help| format!("{name}: {help}"));
        page.line("Help", help.unwrap_or_default());
    }
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
            shorter(&condition.message, system),
        ]);
    }
    page.table("Conditions", &conditions);
    page.table("Components", &component_table(own.into_iter()));
    page.events(scene, |event| event.spec.system == spec.name);
    page
}

fn components_of<'a>(system: &'a System, scene: &'a Scene) -> impl Iterator<Item = &'a Component> {
    let all = scene.components.iter();
    all.filter(|c| c.spec.system == system.spec.name)
}

/// The message of a condition, unless it repeats what the page said before.
fn shorter(message: &str, system: &System) -> String {
    let mut waiting = system.status.waiting_on.iter();
    let said = waiting.find(|w| format!("{}: {}", w.target, w.reason) == message);
    said.map_or_else(|| message.to_owned(), |w| format!("waits for {}", w.target))
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
    page.line("Gaps", status.gaps.to_string());
    page.line("Bytes", status.bytes.to_string());
    page.line("Rate", format!("{}/s", status.rate));
    if let Some(latency) = &status.latency {
        let [min, median, p99, max] = [
            latency.min_ns,
            latency.median_ns,
            latency.p99_ns,
            latency.max_ns,
        ]
        .map(short_time);
        page.line(
            "Latency",
            format!("{min} at least, {median} median, {p99} of 99 %, {max} at most"),
        );
    }
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
    page.drift(&target, &spec.system, &status.drift_fields, scene);
    page.events(scene, |event| {
        event.spec.object == target && event.spec.system == spec.system
    });
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
