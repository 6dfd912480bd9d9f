//! A small simulated world: nodes, processes and components that carry out steps as agents would, and complain about
//! every step that an agent could not, or should not, carry out.

// Each test program uses a part of it.
#![allow(dead_code)]

pub mod bindings;
pub mod by_hand;
pub mod execute;
pub mod loss;
pub mod orders;
pub mod specs;
pub mod story;

use std::collections::{BTreeMap, BTreeSet};

use rts_plan::desired::{Desired, ManagerKey, SystemRef};
use rts_plan::observed::{
    ComponentObserved, ConnectorState, Held, Inventory, LifeCycleState, ManagerObserved,
    NodeObserved, Observed,
};
use rts_plan::{NodeFacts, StoredSystem, place};
use rts_schemas::system::{Configuration, ExecutionKind, OnDisconnect};

/// Everything that runs.
#[derive(Debug, Clone, Default)]
pub struct World {
    pub nodes: BTreeMap<String, Inventory>,
    /// Nodes whose agents do not answer.
    pub silent: BTreeSet<String>,
    /// Incarnations of managers that their agents have never seen answer.
    pub unseen: BTreeSet<String>,
    /// Modules that Install has put on a node.
    pub installed: BTreeSet<(String, String)>,
    /// Systems that were applied.
    pub systems: Vec<StoredSystem>,
    /// The present plan.
    running: orders::Running,
    /// Time-outs run out, at random.
    pub hasty: bool,
    /// Nodes and instances of components that acted by themselves since the present plan began.
    acted: BTreeSet<(String, String)>,
    /// Incarnations that stopped by themselves.
    pub stopped: BTreeSet<String>,
    count: u32,
}

impl World {
    pub fn new(nodes: &[&str]) -> Self {
        let inventory = |node: &&str| {
            let inventory = Inventory {
                node: (*node).to_owned(),
                ..Inventory::default()
            };
            ((*node).to_owned(), inventory)
        };
        Self {
            nodes: nodes.iter().map(inventory).collect(),
            ..Self::default()
        }
    }

    pub fn desired(&self) -> Desired {
        let facts: Vec<NodeFacts> = self
            .nodes
            .keys()
            .map(|name| NodeFacts {
                name: name.clone(),
                aliases: vec![format!("{name}.example")],
            })
            .collect();
        let placed = place(&self.systems, &facts, &facts[0].name);
        placed.accept().unwrap().desired
    }

    pub fn observed(&self) -> Observed {
        let answer = |(node, inventory): (&String, &Inventory)| {
            let observed = if self.silent.contains(node) {
                NodeObserved::Unknown {
                    reason: "no heartbeat for 3 s".to_owned(),
                }
            } else {
                NodeObserved::Known(self.seen(inventory).into())
            };
            (node.clone(), observed)
        };
        Observed {
            nodes: self.nodes.iter().map(answer).collect(),
        }
    }

    /// What an agent can say: nothing of what is in a manager that has never answered it.
    fn seen(&self, inventory: &Inventory) -> Inventory {
        let mut inventory = inventory.clone();
        let connected = self.connected_ends();
        for manager in &mut inventory.managers {
            for component in &mut manager.components {
                for binding in &mut component.bindings {
                    let end = (binding.connector.clone(), component.incarnation.clone());
                    binding.connected = connected.contains(&end);
                }
            }
            if !manager.responsive && self.unseen.contains(&manager.incarnation) {
                manager.unseen = true;
                manager.modules.clear();
                manager.opened.clear();
                manager.components.clear();
            }
        }
        inventory
    }

    /// The manager at this place in the list hangs, and its agent is a new one.
    pub fn lose_sight_of_manager(&mut self, nth: usize) {
        let mut lost = None;
        if let Some(manager) = self.managers_mut().nth(nth) {
            manager.responsive = false;
            lost = Some(manager.incarnation.clone());
        }
        self.unseen.extend(lost);
    }

    /// Stores a system, in place of an earlier one of its name. Nothing of it is held any longer.
    pub fn apply(&mut self, system: StoredSystem) {
        for inventory in self.nodes.values_mut() {
            inventory
                .held
                .retain(|h| h.system.name != system.reference.name);
        }
        self.systems
            .retain(|s| s.reference.name != system.reference.name);
        self.systems.push(system);
    }

    pub fn delete(&mut self, name: &str) {
        for system in &mut self.systems {
            if system.reference.name == name {
                system.deleting = true;
            }
        }
    }

    pub fn next(&mut self) -> u32 {
        self.count += 1;
        self.count
    }

    pub fn managers(&self) -> impl Iterator<Item = (&str, &ManagerObserved)> {
        self.nodes.iter().flat_map(|(node, inventory)| {
            let managers = inventory.managers.iter();
            managers.map(move |manager| (node.as_str(), manager))
        })
    }

    pub fn components(&self) -> impl Iterator<Item = (&str, &ManagerKey, &ComponentObserved)> {
        self.managers().flat_map(|(node, manager)| {
            let components = manager.components.iter();
            components.map(move |component| (node, &manager.key, component))
        })
    }

    pub fn managers_mut(&mut self) -> impl Iterator<Item = &mut ManagerObserved> {
        self.nodes.values_mut().flat_map(|n| &mut n.managers)
    }

    pub fn components_mut(&mut self) -> impl Iterator<Item = &mut ComponentObserved> {
        self.managers_mut().flat_map(|m| &mut m.components)
    }

    pub fn component(&self, instance: &str) -> Option<&ComponentObserved> {
        let mut all = self.components();
        all.find(|(_, _, c)| c.instance == instance)
            .map(|(_, _, c)| c)
    }

    /// Connectors to components that are gone notice it.
    pub fn notice(&mut self) {
        let there: BTreeSet<String> = self
            .components()
            .map(|(_, _, c)| c.incarnation.clone())
            .collect();
        for component in self.components_mut() {
            for connector in &mut component.connectors {
                if !there.contains(&connector.target_incarnation) {
                    connector.state = ConnectorState::Disconnected;
                }
            }
        }
    }

    /// Ends the process at this place in the list, as SIGKILL would.
    pub fn kill(&mut self, nth: usize) {
        let all: Vec<(String, ManagerKey)> = self
            .managers()
            .map(|(node, m)| (node.to_owned(), m.key.clone()))
            .collect();
        if all.is_empty() {
            return;
        }
        let (node, key) = &all[nth % all.len()];
        self.remove_manager(node, key);
    }

    pub fn remove_manager(&mut self, node: &str, key: &ManagerKey) {
        let Some(inventory) = self.nodes.get_mut(node) else {
            return;
        };
        let managers = std::mem::take(&mut inventory.managers).into_iter();
        let (gone, left): (Vec<_>, _) = managers.partition(|m| m.key == *key);
        inventory.managers = left;
        self.lose(gone.into_iter().flat_map(|m| m.components).collect());
    }

    /// An agent holds the desired component at this place in the list.
    pub fn hold(&mut self, nth: usize) {
        let desired = self.desired();
        let placed = desired.nodes.iter().flat_map(|(node, spec)| {
            let parts = spec.systems.iter();
            parts.flat_map(move |part| part.components.iter().map(move |c| (node, part, c)))
        });
        let Some((node, part, placed)) = placed.cycle().take(9).nth(nth) else {
            return;
        };
        self.nodes.get_mut(node).unwrap().held.push(Held {
            part: None,
            system: part.system.clone(),
            instance: placed.spec.instance.clone(),
            reason: "its process died 4 times within 10 min".to_owned(),
        });
    }

    /// A person creates a component, in a process of their own or in one of a system.
    pub fn create_by_hand(&mut self, nth: usize, instance: &str, own: bool) {
        let nodes: Vec<String> = self.nodes.keys().cloned().collect();
        let node = nodes[nth % nodes.len()].clone();
        let taken = self
            .components()
            .any(|(there, _, c)| there == node && c.instance == instance);
        if taken {
            return;
        }
        if own {
            let key = ManagerKey {
                system: None,
                name: "mine".to_owned(),
            };
            let there = self.nodes[&node].managers.iter().any(|m| m.key == key);
            if !there {
                let manager = self.new_manager(key);
                self.nodes.get_mut(&node).unwrap().managers.push(manager);
            }
        }
        let component = self.new_component(instance, "ByHand", None, "by-hand");
        let inventory = self.nodes.get_mut(&node).unwrap();
        let manager = inventory
            .managers
            .iter_mut()
            .find(|m| m.key.system.is_none() == own);
        if let Some(manager) = manager {
            manager.components.push(component);
        }
    }

    pub fn new_manager(&mut self, key: ManagerKey) -> ManagerObserved {
        let number = self.next();
        ManagerObserved {
            key,
            incarnation: format!("m{number}"),
            pid: 1000 + number,
            started: "2026-01-01T00:00:00Z".to_owned(),
            responsive: true,
            unseen: false,
            expired: None,
            modules: BTreeSet::new(),
            opened: Default::default(),
            components: Vec::new(),
            activity: Default::default(),
        }
    }

    pub fn new_component(
        &mut self,
        instance: &str,
        type_name: &str,
        system: Option<SystemRef>,
        recreate_hash: &str,
    ) -> ComponentObserved {
        let number = self.next();
        ComponentObserved {
            instance: instance.to_owned(),
            type_name: type_name.to_owned(),
            system,
            incarnation: format!("c{number}"),
            recreate_hash: recreate_hash.to_owned(),
            stand_in: false,
            state: LifeCycleState::Inactive,
            message: None,
            restarts: 0,
            created: "2026-01-01T00:00:00Z".to_owned(),
            configuration: Configuration::default(),
            defaults: BTreeMap::new(),
            hangs: None,
            on_disconnect: OnDisconnect::default(),
            execution_kind: ExecutionKind::Periodic,
            execution_context: None,
            runs_with: Vec::new(),
            rate: 1000.0,
            executions: 0,
            timing: None,
            realtime: None,
            ports: Vec::new(),
            connectors: Vec::new(),
            bindings: Vec::new(),
            by_hand: rts_plan::observed::ByHand::default(),
        }
    }

    /// Everything answers again and what is under way comes to its end.
    pub fn calm(&mut self) {
        self.silent.clear();
        self.unseen.clear();
        self.managers_mut().for_each(|m| m.responsive = true);
        for connector in self.components_mut().flat_map(|c| &mut c.connectors) {
            if connector.state == ConnectorState::Connecting {
                connector.state = ConnectorState::Connected;
            }
        }
        self.notice();
        self.forget_stale_marks();
    }
}
