//! The page of a component.

use rts_controller_api::objects::{Component, Waiting};

use super::page::Page;
use super::{Scene, policy, system_or_drift};
use crate::show::table::Table;

pub(super) fn component(component: &Component, scene: &Scene) -> Page {
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
