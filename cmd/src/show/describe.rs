//! Pages about one object, as `kubectl describe` prints them.

mod policy;

use jiff::Timestamp;
use rts_controller_api::objects::{
    Component, Connector, Event, Kind, Manager, Metadata, Node, System, Waiting,
};

use super::age::age;
use super::progress::waits;
use super::table::Table;
use crate::commands::get::singular;

/// Most events on a page; the last ones.
const EVENTS: usize = 10;

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

/// Lines `Key:  value`, then tables with a title.
#[derive(Default)]
struct Page {
    lines: Vec<(&'static str, String)>,
    tables: String,
}

impl Page {
    fn of(metadata: &Metadata, created: Option<Timestamp>, scene: &Scene) -> Self {
        let mut page = Self::default();
        page.line("Name", &metadata.name);
        page.line("UID", &metadata.uid);
        let version = crate::commands::describe::version(metadata);
        page.line("Version", version);
        let created = created.or(metadata.creation_timestamp);
        page.line("Age", age(created, scene.now));
        if let Some(deleted) = metadata.deletion_timestamp {
            page.line("Deletion", format!("asked for {deleted}"));
        }
        page
    }

    /// A line, unless there is nothing to say.
    fn line(&mut self, key: &'static str, value: impl Into<String>) {
        let value = value.into();
        if !value.is_empty() {
            self.lines.push((key, value));
        }
    }

    fn table(&mut self, title: &str, table: &Table) {
        self.tables.push_str(&format!("{title}:\n"));
        if table.rows.is_empty() {
            self.tables.push_str("  none\n");
            return;
        }
        for line in table.render(true, false).lines() {
            self.tables.push_str(&format!("  {line}\n"));
        }
    }

    /// What waits, one under the other.
    fn waiting<'a>(&mut self, waiting: impl Iterator<Item = &'a Waiting>, now: Timestamp) {
        for waiting in waiting {
            self.line("Waits for", waits_for(waiting, now));
        }
    }

    fn events(&mut self, scene: &Scene, about: impl Fn(&Event) -> bool) {
        let events: Vec<_> = scene.events.iter().filter(|event| about(event)).collect();
        let mut table = Table::new(&["AGE", "TYPE", "REASON", "OBJECT", "MESSAGE"]);
        for event in events.iter().skip(events.len().saturating_sub(EVENTS)) {
            let time = event.status.time.or(event.metadata.creation_timestamp);
            let spec = &event.spec;
            table.row([
                age(time, scene.now),
                spec.kind.clone(),
                spec.reason.clone(),
                spec.object.clone(),
                spec.message.clone(),
            ]);
        }
        self.table("Events", &table);
    }

    fn text(self) -> String {
        let width = self.lines.iter().map(|(key, _)| key.len()).max();
        let width = width.unwrap_or_default() + 1;
        let mut text = String::new();
        for (key, value) in &self.lines {
            let key = format!("{key}:");
            text.push_str(&format!("{key:width$}  {value}\n"));
        }
        text + &self.tables
    }
}

/// `component/Motor0: its module failed (tried 3 times, next try in 4s, at 12:00:04Z)`.
fn waits_for(waiting: &Waiting, now: Timestamp) -> String {
    let mut facts = Vec::new();
    match waiting.tries {
        0 => {}
        1 => facts.push("tried once".to_owned()),
        tries => facts.push(format!("tried {tries} times")),
    }
    match waiting.next_try {
        Some(next) => {
            let when = policy::when(next, now);
            facts.push(format!("next try {}", when.as_deref().unwrap_or("now")));
        }
        None if waiting.transient => facts.push("passes by itself".to_owned()),
        None => {}
    }
    if !waiting.required {
        facts.push("not required".to_owned());
    }
    let facts = match facts.as_slice() {
        [] => String::new(),
        facts => format!(" ({})", facts.join(", ")),
    };
    waits(waiting) + &facts
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

fn component(component: &Component, scene: &Scene) -> Page {
    let (name, spec, status) = (&component.metadata.name, &component.spec, &component.status);
    let mut page = Page::of(&component.metadata, status.created, scene);
    page.line("System", system_or_drift(&spec.system, status.drift));
    page.line("Type", &spec.type_name);
    page.line("Required", spec.required.to_string());
    page.line("Node", &status.node);
    let pid = status
        .pid
        .map_or("no process".to_owned(), |pid| format!("pid {pid}"));
    page.line("Manager", format!("{} ({pid})", status.manager));
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
    let manager = format!("manager/{}", manager_of(component));
    page.line(
        "Last exit",
        policy::last_exit(&manager, scene).unwrap_or_default(),
    );
    page.line("Incarnation", &status.incarnation);
    if status.stand_in {
        page.line("Stand-in", "true");
    }
    let rate = status.rate.map(|rate| format!("{rate} Hz"));
    page.line("Rate", rate.unwrap_or_default());
    page.line("Executions", status.executions.to_string());
    let waiting: Vec<_> = concerning(component, scene).collect();
    page.waiting(waiting.iter().copied(), scene.now);
    if waiting.is_empty() {
        page.line("Waits for", status.waiting_on.clone().unwrap_or_default());
    }
    page.table("Configuration", &configuration(component));
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
            status.waiting_on.clone().unwrap_or_default(),
        ]);
    }
    page.table("Connectors", &connectors);
    let target = format!("component/{name}");
    let module = format!("module/{}@{}", spec.type_name, manager_of(component));
    page.events(scene, |event| {
        let about = [&target, &manager, &module];
        about.contains(&&event.spec.object) && event.spec.system == spec.system
    });
    page
}

/// Its manager's name as events and waits have it: `hello.main`.
fn manager_of(component: &Component) -> String {
    let (system, short) = (&component.spec.system, &component.status.manager);
    if short.contains('.') || system.is_empty() {
        short.clone()
    } else {
        format!("{system}.{short}")
    }
}

/// What its system waits for that keeps a component from running: itself, its module, package and manager.
fn concerning<'a>(component: &'a Component, scene: &'a Scene) -> impl Iterator<Item = &'a Waiting> {
    let (name, spec, status) = (&component.metadata.name, &component.spec, &component.status);
    let manager = manager_of(component);
    let targets = [
        format!("component/{name}"),
        format!("module/{}@{manager}", spec.type_name),
        format!("package/{}@{}", spec.type_name, status.node),
        format!("manager/{manager}"),
        format!("node/{}", status.node),
    ];
    let own = scene.systems.iter().filter(|s| s.spec.name == spec.system);
    own.flat_map(|system| &system.status.waiting_on)
        .filter(move |waiting| targets.contains(&waiting.target))
}

/// Each parameter as it is, and as it is wanted where that differs.
fn configuration(component: &Component) -> Table {
    let (is, wanted) = (
        &component.status.configuration,
        &component.spec.configuration,
    );
    let mut table = Table::new(&["SET", "PARAMETER", "VALUE", "WANTED"]);
    let sets: std::collections::BTreeSet<_> = is.sets.keys().chain(wanted.sets.keys()).collect();
    for set in sets {
        let (has, wants) = (is.sets.get(set), wanted.sets.get(set));
        let keys = has
            .into_iter()
            .chain(wants)
            .flat_map(|values| values.keys());
        let keys: std::collections::BTreeSet<_> = keys.collect();
        let active = if is.active.as_ref() == Some(set) {
            "*"
        } else {
            ""
        };
        for key in keys {
            let value = has.and_then(|values| values.get(key));
            let want = wants.and_then(|values| values.get(key));
            table.row([
                format!("{set}{active}"),
                key.clone(),
                value.cloned().unwrap_or_default(),
                want.filter(|_| want != value).cloned().unwrap_or_default(),
            ]);
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::show::lists::typed;
    use crate::show::samples;

    fn scene() -> Scene {
        fn of<T: serde::de::DeserializeOwned>(kind: Kind) -> Vec<T> {
            typed(kind, &samples::values(kind)).unwrap()
        }
        Scene {
            now: samples::NOW,
            systems: of(Kind::System),
            nodes: of(Kind::Node),
            components: of(Kind::Component),
            connectors: of(Kind::Connector),
            managers: of(Kind::Manager),
            events: of(Kind::Event),
        }
    }

    #[test]
    fn every_kind_has_its_page() {
        let scene = scene();
        let mut text = String::new();
        for kind in Kind::ALL {
            let name = names(kind, &scene).remove(0);
            let pages = pages(kind, &name, &scene);
            assert_eq!(pages.len(), 1);
            text.push_str(&format!("# {kind:?}\n{}\n", pages[0]));
        }
        insta::assert_snapshot!(text);
        assert!(pages(Kind::Node, "nobody", &scene).is_empty());
    }

    #[test]
    fn what_is_gone_is_told_by_its_events() {
        let mut scene = scene();
        scene.managers.clear();
        let page = pages(Kind::Manager, "hello.main", &scene).remove(0);
        assert!(page.contains("State:      not there"), "{page}");
        assert!(page.contains("ended with signal 9"), "{page}");
        assert!(pages(Kind::Manager, "hello.other", &scene).is_empty());
    }

    #[test]
    fn a_component_that_does_not_run_says_why_and_when_it_is_tried_again() {
        let mut scene = scene();
        scene.systems[0].status.waiting_on = vec![
            Waiting {
                target: "module/SineSource@hello.main".to_owned(),
                reason: "LoadModule module/SineSource@hello.main: no such file".to_owned(),
                required: true,
                transient: false,
                tries: 3,
                next_try: Some(samples::NOW + jiff::SignedDuration::from_secs(4)),
            },
            Waiting {
                target: "component/Printer0".to_owned(),
                reason: "another one".to_owned(),
                required: true,
                transient: false,
                tries: 0,
                next_try: None,
            },
        ];
        let page = pages(Kind::Component, "Sine0", &scene).remove(0);
        let waits: Vec<_> = page
            .lines()
            .filter(|l| l.starts_with("Waits for"))
            .collect();
        assert_eq!(
            waits,
            [
                "Waits for:   module/SineSource@hello.main: LoadModule: no such file (tried 3 times, next try in 4s, at 22:13:24Z)"
            ]
        );
    }
}
