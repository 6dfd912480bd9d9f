//! What is in the way of a plan, and what must hold all the same for components that need their peers.

use std::collections::BTreeSet;

use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use rts_plan::observed::{ComponentObserved, ConnectorObserved, ConnectorState, LifeCycleState};
use rts_plan::plan;
use rts_plan::plan::{Blocked, Drift, DriftKind, Plan, Work};
use rts_plan::target::{connector, on};
use rts_schemas::system::{DriftPolicy, OnDisconnect};

use super::{Lab, hand};
use crate::world::World;
use crate::world::by_hand::Hand;
use crate::world::specs::NODES;

/// Something that is in the way of a plan.
#[derive(Debug, Clone)]
pub enum Trouble {
    Block(usize),
    Kill(usize),
    HoldAndKill(usize),
    Silence(usize),
    LoseSight(usize),
    /// A connector is lost and no manager acts.
    Disconnect {
        nth: usize,
        remove: bool,
        block: bool,
    },
    Hand(Hand),
}

pub fn trouble() -> impl Strategy<Value = Trouble> {
    prop_oneof![
        3 => (0..80usize).prop_map(Trouble::Block),
        2 => (0..9usize).prop_map(Trouble::Kill),
        2 => (0..9usize).prop_map(Trouble::HoldAndKill),
        1 => (0..9usize).prop_map(Trouble::Silence),
        1 => (0..9usize).prop_map(Trouble::LoseSight),
        4 => (0..12usize, any::<bool>(), any::<bool>())
            .prop_map(|(nth, remove, block)| Trouble::Disconnect { nth, remove, block }),
        4 => hand().prop_map(Trouble::Hand),
    ]
}

impl Lab {
    pub fn trouble(&mut self, trouble: &Trouble) {
        match trouble {
            Trouble::Block(nth) => self.block(*nth),
            Trouble::Kill(nth) => self.world.kill(*nth),
            Trouble::LoseSight(nth) => self.world.lose_sight_of_manager(*nth),
            Trouble::Hand(hand) => self.world.by_hand(hand),
            Trouble::HoldAndKill(nth) => {
                self.world.hold(*nth);
                let held = self
                    .world
                    .nodes
                    .values()
                    .flat_map(|n| &n.held)
                    .last()
                    .cloned();
                let mut all = self.world.managers();
                let at = held.and_then(|held| {
                    all.position(|(_, m)| m.components.iter().any(|c| c.instance == held.instance))
                });
                drop(all);
                at.into_iter().for_each(|at| self.world.kill(at));
            }
            Trouble::Silence(nth) => {
                self.world
                    .managers_mut()
                    .skip(*nth)
                    .take(1)
                    .for_each(|m| m.responsive = false);
            }
            Trouble::Disconnect { nth, remove, block } => {
                let node = |(node, _, c): (&str, _, &ComponentObserved)| {
                    let name = |c: &ConnectorObserved| on(node, &format!("connector/{}", c.name));
                    c.connectors.iter().map(name).collect::<Vec<_>>()
                };
                let targets: Vec<String> = self.world.components().flat_map(node).collect();
                let Some(target) = targets.get(*nth) else {
                    return;
                };
                if *block {
                    self.blocked.insert(target.clone(), "no".to_owned());
                }
                let mut at = *nth;
                for component in self.world.components_mut() {
                    if at < component.connectors.len() {
                        component.connectors[at].state = ConnectorState::Disconnected;
                        if *remove {
                            component.connectors.remove(at);
                        }
                        break;
                    }
                    at -= component.connectors.len();
                }
            }
        }
    }

    /// Blocks the target of a step of the first bring-up.
    fn block(&mut self, nth: usize) {
        let nothing = World::new(&NODES).observed();
        let plan = plan(&self.world.desired(), &nothing, &Blocked::new());
        if let Some(step) = plan.steps.iter().cycle().take(80).nth(nth) {
            let target = on(&step.node, &step.target);
            self.blocked.insert(target, "no".to_owned());
        }
    }

    /// With `onDisconnect: stop` a component is made only when all its peers are there or are made too.
    pub fn nothing_is_made_without_its_peers(
        &self,
        plan: &Plan,
        dim: &BTreeSet<String>,
    ) -> TestCaseResult {
        for system in &self.world.systems {
            let made = |name: &str| {
                plan.steps.iter().any(|step| {
                    let this =
                        matches!(&step.work, Work::Create { instance, .. } if instance == name);
                    this && step.system.as_ref() == Some(&system.reference)
                })
            };
            let there = |name: &str| {
                let mut all = self.world.components();
                all.any(|(_, _, c)| {
                    c.instance == name && c.system.as_ref() == Some(&system.reference)
                })
            };
            let stops = |name: &str| {
                let mut all = system.spec.components.iter();
                all.any(|c| c.instance == name && c.policy.on_disconnect == OnDisconnect::Stop)
            };
            for connector in &system.spec.connectors {
                let ends = [&connector.source.instance, &connector.target.instance];
                for (end, peer) in [(ends[0], ends[1]), (ends[1], ends[0])] {
                    if stops(end) && made(end) && !dim.contains(peer) {
                        let fits = made(peer) || there(peer);
                        prop_assert!(fits, "{} is made without {}: {}", end, peer, plan);
                    }
                }
            }
        }
        Ok(())
    }

    /// Instances of which something cannot be seen, by their desired or their present place.
    pub fn dim(&self) -> BTreeSet<String> {
        let world = &self.world;
        let dark = |node: &str, manager: &str| {
            let mut managers = world.managers();
            let silent = managers.any(|(n, m)| n == node && m.key.name == manager && !m.responsive);
            silent || world.silent.contains(node)
        };
        let there = world
            .components()
            .map(|(node, key, c)| (node, key.name.as_str(), &c.instance));
        let there = there.filter(|(node, manager, _)| dark(node, manager));
        let mut dim: BTreeSet<String> = there.map(|(_, _, instance)| instance.clone()).collect();
        for (node, spec) in &world.desired().nodes {
            let placed = spec.systems.iter().flat_map(|part| &part.components);
            let placed = placed.filter(|c| dark(node, &c.manager));
            dim.extend(placed.map(|c| c.spec.instance.clone()));
        }
        dim
    }

    /// Active components with a policy, in their place, and a connector of theirs that does not work.
    pub fn without_peers(&self, dim: &BTreeSet<String>) -> Vec<(String, String)> {
        let mut found = Vec::new();
        for (node, spec) in &self.world.desired().nodes {
            for part in &spec.systems {
                for placed in &part.components {
                    let name = &placed.spec.instance;
                    let blocked = self
                        .blocked
                        .contains_key(&on(node, &format!("component/{name}")));
                    let keeps = placed.spec.policy.on_disconnect == OnDisconnect::Keep;
                    let active = self.world.components().any(|(n, key, c)| {
                        let here = n == node && key.name == placed.manager && c.instance == *name;
                        let own = c.system.as_ref() == Some(&part.system);
                        here && own && c.state == LifeCycleState::Active
                    });
                    if blocked || keeps || !active || dim.contains(name) {
                        continue;
                    }
                    for connector in &part.connectors {
                        let ends = [
                            &connector.spec.source.instance,
                            &connector.spec.target.instance,
                        ];
                        let own =
                            ends.contains(&name) && !ends.iter().any(|end| dim.contains(*end));
                        if own && !self.works(&connector.spec.name) {
                            found.push((name.clone(), connector.spec.name.clone()));
                        }
                    }
                }
            }
        }
        found
    }

    fn works(&self, connector: &str) -> bool {
        let mut all = self.world.components().flat_map(|(_, _, c)| &c.connectors);
        all.any(|c| c.name == connector && c.state != ConnectorState::Disconnected)
    }

    /// True for a component with a policy, one of whose connectors cannot be made now, or is left out.
    pub fn waits_for_a_peer(&self, plan: &Plan, instance: &str) -> bool {
        let specs = self.world.systems.iter().map(|system| &system.spec);
        let keeps = specs
            .clone()
            .flat_map(|spec| &spec.components)
            .any(|c| c.instance == instance && c.policy.on_disconnect == OnDisconnect::Keep);
        let mut own = specs
            .flat_map(|spec| &spec.connectors)
            .filter(|c| c.source.instance == instance || c.target.instance == instance);
        let waits = |name: &str| {
            let target = connector(name);
            let left = |d: &Drift| d.policy != DriftPolicy::Repair && d.kind == DriftKind::Missing;
            let mut left = plan.drift.iter().filter(|d| left(d));
            left.any(|d| d.target == target) || plan.waiting_on.iter().any(|w| w.target == target)
        };
        !keeps && own.any(|c| waits(&c.name))
    }
}
