//! What changed from one inventory to the next: whether its revision rises, and what people should know of it.

use rts_agent_api::session::AgentEvent;
use rts_plan::observed::{
    ComponentObserved, ConnectorState, Inventory, LifeCycleState, ManagerObserved,
};

use crate::events::of_manager;

/// The same inventory with its counters, its revision and the seconds of what hangs left out.
pub(super) fn without_counters(inventory: &Inventory) -> Inventory {
    let mut inventory = inventory.clone();
    inventory.revision = 0;
    let managers = inventory.managers.iter_mut();
    for component in managers.flat_map(|m| &mut m.components) {
        component.executions = 0;
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
        }
    }
    inventory
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

fn of_hanging(before: Option<&ComponentObserved>, now: &ComponentObserved) -> Option<AgentEvent> {
    if before.is_some_and(|c| c.hangs.is_some()) {
        return None;
    }
    let message = now.hangs.clone()?;
    let object = format!("component/{}", now.instance);
    Some(warning("ComponentHangs", object, now, message))
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
