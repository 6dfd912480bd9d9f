//! The page of what is not there.

use rts_controller_api::objects::{Component, Event, Kind, Waiting};

use super::page::Page;
use super::{Scene, component, component_table, manager, policy};
use crate::commands::get::singular;

/// What is not there but was, or should be: what is known of it.
pub(super) fn gone(kind: Kind, name: &str, scene: &Scene) -> Option<Page> {
    let target = format!("{}/{name}", singular(kind));
    let meant = match kind {
        Kind::Manager => meant_for(name, scene),
        _ => Vec::new(),
    };
    let waiting = waiting(&target, &meant, scene);
    let about = |event: &Event| event.spec.object == target;
    if waiting.is_empty() && meant.is_empty() && !scene.events.iter().any(about) {
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
    if !meant.is_empty() {
        page.table("Components", &component_table(meant.into_iter()));
    }
    page.events(scene, about);
    Some(page)
}

/// Components that a manager is to hold.
fn meant_for<'a>(name: &str, scene: &'a Scene) -> Vec<&'a Component> {
    let all = scene.components.iter();
    let meant = all.filter(|c| !c.spec.system.is_empty() && manager::name_of(c) == name);
    meant.collect()
}

/// What waits for it, or keeps what belongs into it from running: each once, in the order of their systems.
fn waiting<'a>(target: &str, meant: &[&Component], scene: &'a Scene) -> Vec<&'a Waiting> {
    let all = scene.systems.iter().flat_map(|system| {
        let waiting = system.status.waiting_on.iter();
        waiting.map(|waiting| (&system.spec.name, waiting))
    });
    let wanted = all.filter(|(system, waiting)| {
        let concerns = |c: &&Component| {
            c.spec.system == **system && component::targets(c).contains(&waiting.target)
        };
        waiting.target == target || meant.iter().any(concerns)
    });
    wanted.map(|(_, waiting)| waiting).collect()
}
