//! What changed from one inventory to the next: whether its revision rises, and what people should know of it.

use rts_agent_api::session::AgentEvent;
use rts_plan::delta::InventoryDelta;
use rts_plan::observed::{
    Activity, ComponentObserved, ConnectorState, Inventory, LifeCycleState, ManagerObserved,
};

use crate::events::of_manager;

/// The same inventory with its counters, its revision and the seconds of what hangs left out.
pub(super) fn without_counters(inventory: &Inventory) -> Inventory {
    let mut inventory = inventory.clone();
    inventory.revision = 0;
    let managers = inventory.managers.iter_mut();
    let components = managers.flat_map(|m| {
        m.activity = Activity::default();
        &mut m.components
    });
    for component in components {
        component.executions = 0;
        component.timing = None;
        if let Some(hangs) = &mut component.hangs {
            // `has been in on_execute for 11 s`
            let end = hangs.rfind(" for ").unwrap_or(hangs.len());
            hangs.truncate(end);
        }
        for connector in &mut component.connectors {
            connector.samples_sent = 0;
            connector.samples_received = 0;
            connector.bytes = 0;
            connector.drops = 0;
            connector.gaps = 0;
            connector.rate = 0;
            connector.latency = None;
        }
        for binding in &mut component.bindings {
            binding.samples_received = 0;
            binding.drops = 0;
            binding.gaps = 0;
        }
    }
    inventory
}

/// The way from an earlier inventory to this one; none when nothing but counters differs. Managers in which only
/// counters differ are left out.
pub(crate) fn delta(earlier: &Inventory, now: &Inventory) -> Option<InventoryDelta> {
    if earlier.revision == now.revision {
        return None;
    }
    let (bare, bare_now) = (without_counters(earlier), without_counters(now));
    let changed = bare_now.since(&bare);
    let mut delta = now.since(earlier);
    delta
        .managers
        .retain(|m| changed.managers.iter().any(|c| c.key == m.key));
    Some(delta)
}

/// What people should know of the change from one inventory to the next.
pub(super) fn differences(old: &Inventory, new: &Inventory) -> Vec<AgentEvent> {
    let mut events = Vec::new();
    for manager in &new.managers {
        let before = old
            .managers
            .iter()
            .find(|m| m.incarnation == manager.incarnation);
        events.extend(of_answers(before, manager));
        events.extend(of_expiry(before, manager));
        for component in &manager.components {
            let before = before
                .into_iter()
                .flat_map(|m| &m.components)
                .find(|c| c.incarnation == component.incarnation);
            events.extend(of_state(before, component));
            events.extend(of_hanging(before, component));
            events.extend(of_connectors(before, component));
        }
    }
    events
}

fn of_answers(before: Option<&ManagerObserved>, now: &ManagerObserved) -> Option<AgentEvent> {
    let (kind, reason, what) = match (before.is_none_or(|m| m.responsive), now.responsive) {
        (true, false) => ("Warning", "ManagerSilent", "does not answer"),
        (false, true) => ("Normal", "ManagerAnswers", "answers again"),
        _ => return None,
    };
    let message = format!("process {} {what}", now.pid);
    Some(of_manager(kind, reason, &now.key, message))
}

fn of_state(before: Option<&ComponentObserved>, now: &ComponentObserved) -> Option<AgentEvent> {
    let was_in_error = before.is_some_and(|c| c.state == LifeCycleState::Error);
    if now.state != LifeCycleState::Error || was_in_error {
        return None;
    }
    let message = now.message.clone();
    let message = message.unwrap_or_else(|| "went to Error".to_owned());
    let object = format!("component/{}", now.instance);
    Some(warning("ComponentError", object, now, message))
}

fn of_expiry(before: Option<&ManagerObserved>, now: &ManagerObserved) -> Option<AgentEvent> {
    if before.is_some_and(|m| m.expired.is_some()) {
        return None;
    }
    let why = now.expired.as_ref()?;
    let message = format!("{why}: process {} is to be replaced", now.pid);
    Some(of_manager("Warning", "ManagerExpired", &now.key, message))
}

fn of_hanging(before: Option<&ComponentObserved>, now: &ComponentObserved) -> Option<AgentEvent> {
    let did = before.is_some_and(|c| c.hangs.is_some());
    let object = format!("component/{}", now.instance);
    match (did, &now.hangs) {
        (false, Some(hangs)) => Some(warning("Hangs", object, now, hangs.clone())),
        (true, None) => Some(AgentEvent {
            kind: "Normal".to_owned(),
            ..warning("Hangs", object, now, "hangs no longer".to_owned())
        }),
        _ => None,
    }
}

fn of_connectors(before: Option<&ComponentObserved>, now: &ComponentObserved) -> Vec<AgentEvent> {
    let was_connected = |name: &str| {
        let connectors = before.into_iter().flat_map(|c| &c.connectors);
        connectors
            .filter(|c| c.state == ConnectorState::Connected)
            .any(|c| c.name == name)
    };
    now.connectors
        .iter()
        .filter(|c| c.state == ConnectorState::Disconnected && was_connected(&c.name))
        .map(|c| {
            let message = format!("lost its other end, {}", c.target);
            warning(
                "ConnectorDisconnected",
                format!("connector/{}", c.name),
                now,
                message,
            )
        })
        .collect()
}

fn warning(
    reason: &str,
    object: String,
    component: &ComponentObserved,
    message: String,
) -> AgentEvent {
    AgentEvent {
        kind: "Warning".to_owned(),
        reason: reason.to_owned(),
        object,
        system: component.system.as_ref().map(|s| s.name.clone()),
        message,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inventory::fixtures::{bare, view};
    use crate::inventory::merge::merge;
    use crate::policies::Policies;

    /// Two managers, whose components were executed so often and have this state.
    fn at(revision: u64, executions: u64, state: &str) -> Inventory {
        let views = ["one", "two"].map(|name| {
            let mut info = bare(name);
            info.executions = executions;
            if name == "two" {
                info.state = state.to_owned();
            }
            let mut view = view(vec![info]);
            view.key.name = name.to_owned();
            view
        });
        let mut inventory = merge("local", views.to_vec(), &Policies::default());
        inventory.revision = revision;
        inventory
    }

    #[test]
    fn a_delta_holds_what_differs_in_more_than_counters() {
        let earlier = at(1, 10, "Active");
        assert_eq!(delta(&earlier, &at(1, 20, "Active")), None);
        let now = at(2, 20, "Error");
        let delta = delta(&earlier, &now).unwrap();
        assert_eq!((delta.from, delta.to), (1, 2));
        assert_eq!(delta.managers, [now.managers[1].clone()]);
        let mut there = earlier;
        assert!(there.advance(delta));
        assert_eq!(without_counters(&there), without_counters(&now));
    }
}
