//! Carries out a plan as agents would, in any order that its edges allow.

use std::collections::{BTreeMap, BTreeSet};

use rts_plan::desired::{ManagerKey, PlacedConnector};
use rts_plan::observed::{
    ComponentObserved, ConnectorObserved, ConnectorState, LifeCycleState, ManagerObserved,
};
use rts_plan::plan::{Plan, Step, StepId, Work};
use rts_plan::target::on;
use rts_schemas::system::{Condition, SendingTiming, WaitFor};

use super::World;

/// A rule that a step broke.
pub type Broken = String;

/// How one run of a plan went.
#[derive(Debug, Default)]
pub struct Run {
    /// Target → why one of its steps failed.
    pub failed: BTreeMap<String, String>,
}

/// Which ready step goes next, and which fail.
pub struct Chance<'a> {
    pub pick: &'a mut dyn FnMut(usize) -> usize,
    pub fails: &'a mut dyn FnMut(&Step) -> bool,
}

impl World {
    /// Carries out a plan. Steps whose needs failed are skipped.
    pub fn execute(&mut self, plan: &Plan, chance: Chance<'_>) -> Result<Run, Broken> {
        let mut run = Run::default();
        self.done.clear();
        self.acted.clear();
        let mut open: BTreeMap<StepId, &Step> = plan.steps.iter().map(|s| (s.id, s)).collect();
        let mut lost: BTreeSet<StepId> = BTreeSet::new();
        while !open.is_empty() {
            let skipped: Vec<StepId> = open
                .values()
                .filter(|step| step.needs.iter().any(|id| lost.contains(id)))
                .map(|step| step.id)
                .collect();
            if !skipped.is_empty() {
                for id in skipped {
                    open.remove(&id);
                    lost.insert(id);
                }
                continue;
            }
            let ready: Vec<&Step> = open
                .values()
                .filter(|step| {
                    let before = step.needs.iter().chain(&step.after_start_of);
                    before.copied().all(|id| !open.contains_key(&id))
                })
                .copied()
                .collect();
            if ready.is_empty() {
                return Err(format!(
                    "nothing can start, but {} steps are left",
                    open.len()
                ));
            }
            let step = ready[(chance.pick)(ready.len()) % ready.len()];
            open.remove(&step.id);
            if (chance.fails)(step) {
                lost.insert(step.id);
                let reason = format!("{} failed", step.work.kind());
                run.failed.insert(on(&step.node, &step.target), reason);
                continue;
            }
            match self.step(step, plan) {
                Ok(()) => drop(self.done.insert(step.id)),
                Err(_) if self.done_already(step) => drop(self.done.insert(step.id)),
                Err(why) if self.excused(step) => {
                    lost.insert(step.id);
                    run.failed.insert(on(&step.node, &step.target), why);
                }
                Err(why) => {
                    let (id, kind, target) = (step.id, step.work.kind(), &step.target);
                    return Err(format!("step {id} {kind} {target}: {why}"));
                }
            }
        }
        self.notice();
        Ok(run)
    }

    fn step(&mut self, step: &Step, plan: &Plan) -> Result<(), Broken> {
        if self.silent.contains(&step.node) {
            return Err(format!("node {} is unknown", step.node));
        }
        let node = step.node.as_str();
        match &step.work {
            Work::Install { type_name, .. } => {
                self.installed.insert((node.to_owned(), type_name.clone()));
                Ok(())
            }
            Work::StartManager { manager } => self.start(node, manager),
            Work::LoadModule {
                manager, type_name, ..
            } => {
                let installed = (node.to_owned(), type_name.clone());
                check(
                    self.installed.contains(&installed),
                    "the module is not installed",
                )?;
                self.manager(node, manager)?
                    .modules
                    .insert(type_name.clone());
                Ok(())
            }
            Work::Create { manager, .. } => self.create(step, node, manager),
            Work::Configure {
                manager,
                instance,
                configuration,
                rate,
                on_disconnect,
            } => {
                let component = self.find(node, manager, instance)?;
                if let Some(on_disconnect) = on_disconnect {
                    component.on_disconnect = *on_disconnect;
                }
                for (set, values) in &configuration.sets {
                    let own = component.configuration.sets.entry(set.clone()).or_default();
                    own.extend(values.clone());
                }
                if configuration.active.is_some() {
                    component
                        .configuration
                        .active
                        .clone_from(&configuration.active);
                }
                component.rate = rate.unwrap_or(component.rate);
                Ok(())
            }
            Work::Connect { connector } => self.connect(step, node, connector),
            Work::Activate { manager, instance } => self.activate(step, node, manager, instance),
            Work::Deactivate { manager, instance } => {
                self.before_deactivate(step, plan, instance)?;
                let component = self.find(node, manager, instance)?;
                check(component.state == LifeCycleState::Active, "is not Active")?;
                component.state = LifeCycleState::Inactive;
                Ok(())
            }
            Work::Reset { manager, instance } => {
                let component = self.find(node, manager, instance)?;
                check(component.state == LifeCycleState::Error, "is not in Error")?;
                component.state = LifeCycleState::Inactive;
                Ok(())
            }
            Work::Disconnect {
                manager,
                instance,
                connector,
            } => {
                let component = self.find(node, manager, instance)?;
                component.connectors.retain(|c| c.name != *connector);
                Ok(())
            }
            Work::Delete { manager, instance } => {
                self.delete_step(step, plan, node, manager, instance)
            }
            Work::UnloadModule { manager, type_name } => {
                let manager = self.manager(node, manager)?;
                let used = manager.components.iter().any(|c| c.type_name == *type_name);
                check(!used, "a component uses the module")?;
                manager.modules.remove(type_name);
                Ok(())
            }
            Work::StopManager {
                manager,
                incarnation,
            } => {
                let process = self.process(node, manager)?;
                check(
                    process.incarnation == *incarnation,
                    "another start is meant",
                )?;
                check(
                    process.key.system.is_some(),
                    "a person's process is stopped",
                )?;
                self.remove_manager(node, manager);
                Ok(())
            }
        }
    }

    fn start(&mut self, node: &str, key: &ManagerKey) -> Result<(), Broken> {
        let there = self.managers().any(|(n, m)| n == node && m.key == *key);
        check(!there, "the process runs already")?;
        let manager = self.new_manager(key.clone());
        self.nodes.get_mut(node).unwrap().managers.push(manager);
        Ok(())
    }

    fn create(&mut self, step: &Step, node: &str, key: &ManagerKey) -> Result<(), Broken> {
        let Work::Create {
            instance,
            type_name,
            recreate_hash,
            configuration,
            execution_kind,
            rate,
            on_disconnect,
            ..
        } = &step.work
        else {
            return Err("no Create".to_owned());
        };
        for (there, _, other) in self.components() {
            // Nobody can know what a silent node holds.
            if self.silent.contains(there) {
                continue;
            }
            let same_name = there == node && other.instance == *instance;
            let same_identity = other.instance == *instance && other.system == step.system;
            check(
                !same_name && !same_identity,
                "there would be two of this name",
            )?;
        }
        let absent = self.not_yet(step, instance, &["startUp", "initializing"], |_| true);
        check(
            absent.is_empty(),
            &format!("{absent:?} must be there first"),
        )?;
        let mut component =
            self.new_component(instance, type_name, step.system.clone(), recreate_hash);
        component.configuration.clone_from(configuration);
        component.execution_kind = *execution_kind;
        component.on_disconnect = *on_disconnect;
        component.rate = rate.unwrap_or(component.rate);
        let manager = self.manager(node, key)?;
        check(
            manager.modules.contains(type_name),
            "its module is not loaded",
        )?;
        manager.components.push(component);
        Ok(())
    }

    fn connect(&mut self, step: &Step, node: &str, placed: &PlacedConnector) -> Result<(), Broken> {
        let spec = &placed.spec;
        let key = |name: &str| ManagerKey {
            system: step.system.clone(),
            name: name.to_owned(),
        };
        check(
            placed.source.node == node,
            "is not carried out at the source",
        )?;
        let (there, target) = (&placed.target, &spec.target.instance);
        check(
            !self.silent.contains(&there.node),
            "the target's node is unknown",
        )?;
        let target = self
            .find(&there.node, &key(&there.manager), target)?
            .incarnation
            .clone();
        let source = self.find(node, &key(&placed.source.manager), &spec.source.instance)?;
        let there = source.connectors.iter().any(|c| c.name == spec.name);
        check(!there, "the connector exists already")?;
        source.connectors.push(ConnectorObserved {
            name: spec.name.clone(),
            source: spec.source.clone(),
            target: spec.target.clone(),
            target_incarnation: target,
            properties: spec.properties.clone(),
            by_hand: None,
            state: ConnectorState::Connected,
            transport: "uds".to_owned(),
            samples_sent: 0,
            samples_received: 0,
            bytes: 0,
            drops: 0,
        });
        Ok(())
    }

    fn activate(
        &mut self,
        step: &Step,
        node: &str,
        key: &ManagerKey,
        instance: &str,
    ) -> Result<(), Broken> {
        let active = |c: &ComponentObserved| c.state == LifeCycleState::Active;
        let late = self.not_yet(step, instance, &["activation"], active);
        check(late.is_empty(), &format!("{late:?} must be Active first"))?;
        let component = self.find(node, key, instance)?;
        check(component.state != LifeCycleState::Error, "it is in Error")?;
        check(
            component.state != LifeCycleState::Active,
            "it is Active already",
        )?;
        component.state = LifeCycleState::Active;
        Ok(())
    }

    fn delete_step(
        &mut self,
        step: &Step,
        plan: &Plan,
        node: &str,
        key: &ManagerKey,
        instance: &str,
    ) -> Result<(), Broken> {
        let component = self.find(node, key, instance)?.clone();
        check(component.state != LifeCycleState::Active, "it is Active")?;
        check(component.system.is_some(), "a person made it")?;
        let (system, name) = (&component.system, &component.incarnation);
        let orders = self.conditions(step, &["shutDown", "finalizing"]);
        for (before, timing) in predecessors(&orders, instance) {
            let still = plan.steps.iter().any(|s| {
                let same = matches!(&s.work, Work::Delete { instance, .. } if *instance == before);
                same && s.system == *system && !self.done.contains(&s.id)
            });
            let still = still && timing == SendingTiming::Sync;
            check(!still, &format!("{before} must be deleted first"))?;
        }
        for (there, key, source) in self.components() {
            if !self.answers(there, key) {
                continue;
            }
            let feeds = source
                .connectors
                .iter()
                .any(|c| c.target_incarnation == *name);
            let goes = plan.steps.iter().any(|s| match &s.work {
                Work::Delete { instance, .. } => *instance == source.instance,
                Work::StopManager { .. } => true,
                _ => false,
            });
            let by_hand = source.system.is_none();
            check(!feeds || goes || by_hand, "a connector still feeds it")?;
        }
        self.manager(node, key)?
            .components
            .retain(|c| c.instance != instance);
        self.lose(vec![component]);
        Ok(())
    }

    fn answers(&self, node: &str, key: &ManagerKey) -> bool {
        let mut all = self.managers();
        let found = all.find(|(there, m)| *there == node && m.key == *key);
        !self.silent.contains(node) && found.is_some_and(|(_, m)| m.responsive)
    }

    fn before_deactivate(&self, step: &Step, plan: &Plan, instance: &str) -> Result<(), Broken> {
        for (before, timing) in predecessors(&self.conditions(step, &["deactivation"]), instance) {
            let late = plan.steps.iter().any(|s| match &s.work {
                Work::Deactivate { instance, .. } => {
                    *instance == before && s.system == step.system && !self.done.contains(&s.id)
                }
                _ => false,
            });
            let late = late && timing == SendingTiming::Sync;
            check(!late, &format!("{before} must be deactivated first"))?;
        }
        Ok(())
    }

    /// SYNC predecessors of a component that are not as they must be.
    pub fn not_yet(
        &self,
        step: &Step,
        instance: &str,
        orders: &[&str],
        ready: impl Fn(&ComponentObserved) -> bool,
    ) -> Vec<String> {
        predecessors(&self.conditions(step, orders), instance)
            .into_iter()
            .filter(|(_, timing)| *timing == SendingTiming::Sync)
            .map(|(before, _)| before)
            .filter(|before| !self.any_instance(step, before, &ready))
            .collect()
    }

    /// There may be a second instance for a while, after a silent node has come back.
    fn any_instance(
        &self,
        step: &Step,
        instance: &str,
        is: impl Fn(&ComponentObserved) -> bool,
    ) -> bool {
        let mut all = self.components();
        all.any(|(_, _, c)| c.instance == instance && c.system == step.system && is(c))
    }

    fn conditions(&self, step: &Step, orders: &[&str]) -> Vec<Vec<Condition>> {
        let stored = self
            .systems
            .iter()
            .find(|s| Some(&s.reference) == step.system.as_ref());
        let Some(stored) = stored else {
            return Vec::new();
        };
        let all = serde_json::to_value(&stored.spec.orders).unwrap();
        let list = |name: &&str| serde_json::from_value(all[*name].clone()).unwrap();
        orders.iter().map(list).collect()
    }

    fn manager(&mut self, node: &str, key: &ManagerKey) -> Result<&mut ManagerObserved, Broken> {
        let manager = self.process(node, key)?;
        check(manager.responsive, "the process does not answer")?;
        Ok(manager)
    }

    /// One that may be silent.
    fn process(&mut self, node: &str, key: &ManagerKey) -> Result<&mut ManagerObserved, Broken> {
        let inventory = self.nodes.get_mut(node).ok_or("no such node")?;
        let manager = inventory.managers.iter_mut().find(|m| m.key == *key);
        manager.ok_or_else(|| format!("no process {}", key.display_name()))
    }

    fn find(
        &mut self,
        node: &str,
        key: &ManagerKey,
        instance: &str,
    ) -> Result<&mut ComponentObserved, Broken> {
        let components = &mut self.manager(node, key)?.components;
        let component = components.iter_mut().find(|c| c.instance == instance);
        component.ok_or_else(|| format!("no component {instance} in {}", key.display_name()))
    }
}

/// Everyone that a component must wait for, straight from the conditions: each list has its own sequence.
fn predecessors(lists: &[Vec<Condition>], instance: &str) -> Vec<(String, SendingTiming)> {
    let mut before = Vec::new();
    for list in lists {
        let level = |name: &str| {
            list.iter()
                .filter(|c| c.target == name)
                .map(|c| c.sequence)
                .max()
        };
        let Some(own) = level(instance) else { continue };
        for condition in list {
            if level(&condition.target).is_some_and(|other| other < own) {
                before.push((condition.target.clone(), SendingTiming::Sync));
            }
            if let (
                true,
                Some(WaitFor::Preceding {
                    timing, components, ..
                }),
            ) = (condition.target == instance, &condition.wait)
            {
                before.extend(components.iter().map(|c| (c.clone(), *timing)));
            }
        }
    }
    before
}

fn check(holds: bool, otherwise: &str) -> Result<(), Broken> {
    if holds {
        Ok(())
    } else {
        Err(otherwise.to_owned())
    }
}
