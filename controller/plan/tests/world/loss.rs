//! What managers do by themselves when a peer of one of their components is lost (`onDisconnect`).

use std::collections::BTreeSet;

use rts_plan::observed::{ComponentObserved, ConnectorState, LifeCycleState, ManagerObserved};
use rts_plan::plan::{Step, Work};
use rts_schemas::system::OnDisconnect;

use super::World;

impl World {
    /// Components are gone, with their connectors: those that were connected to them act at once, and so on.
    pub fn lose(&mut self, gone: Vec<ComponentObserved>) {
        let mut open = gone;
        while let Some(dead) = open.pop() {
            let fed = connected(&dead);
            for (node, inventory) in &mut self.nodes {
                for manager in inventory.managers.iter_mut().filter(|m| m.responsive) {
                    let acted = act(manager, &dead.incarnation, &fed, &mut open);
                    let acted = acted.into_iter().map(|name| (node.clone(), name));
                    self.acted.extend(acted);
                }
            }
            self.stopped
                .extend(open.iter().map(|c| c.incarnation.clone()));
        }
        self.notice();
    }

    /// True when a step cannot do what it says because a component acted by itself meanwhile.
    pub fn excused(&self, step: &Step) -> bool {
        let acted = |instance: &str| self.has_acted(instance);
        match &step.work {
            Work::Connect { connector } => {
                acted(&connector.spec.source.instance) || acted(&connector.spec.target.instance)
            }
            Work::Create { instance, .. }
            | Work::Activate { instance, .. }
            | Work::Configure { instance, .. }
            | Work::Reset { instance, .. }
            | Work::Disconnect { instance, .. }
            | Work::Unbind { instance, .. } => acted(instance),
            _ => false,
        }
    }

    /// True for a component that acted by itself since the plan began.
    pub fn has_acted(&self, instance: &str) -> bool {
        self.acted.iter().any(|(_, other)| other == instance)
    }

    /// True for a step that asks for what a component has done by itself meanwhile.
    pub fn done_already(&self, step: &Step) -> bool {
        let (Work::Deactivate { instance, .. } | Work::Delete { instance, .. }) = &step.work else {
            return false;
        };
        let mut here = self.components().filter(|(node, _, _)| *node == step.node);
        let there = here.find(|(_, _, c)| c.instance == *instance);
        self.acted.contains(&(step.node.clone(), instance.clone()))
            && match &step.work {
                Work::Delete { .. } => there.is_none(),
                _ => there.is_none_or(|(_, _, c)| c.state != LifeCycleState::Active),
            }
    }
}

fn connected(component: &ComponentObserved) -> BTreeSet<String> {
    let connectors = component.connectors.iter();
    connectors
        .filter(|c| c.state == ConnectorState::Connected)
        .map(|c| c.target_incarnation.clone())
        .collect()
}

/// Gives the names of those that acted; those that stopped are taken out and go to `stopped`.
fn act(
    manager: &mut ManagerObserved,
    dead: &str,
    fed: &BTreeSet<String>,
    stopped: &mut Vec<ComponentObserved>,
) -> Vec<String> {
    let mut acted = Vec::new();
    for mut component in std::mem::take(&mut manager.components) {
        let lost = fed.contains(&component.incarnation) || connected(&component).contains(dead);
        match component.on_disconnect {
            OnDisconnect::Deactivate if lost && component.state == LifeCycleState::Active => {
                component.state = LifeCycleState::Inactive;
                acted.push(component.instance.clone());
            }
            OnDisconnect::Stop if lost => {
                acted.push(component.instance.clone());
                stopped.push(component);
                continue;
            }
            _ => {}
        }
        manager.components.push(component);
    }
    acted
}
