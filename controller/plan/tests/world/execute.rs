//! Carries out a plan as agents would, in any order that its edges allow.

use std::collections::{BTreeMap, BTreeSet};

use rts_plan::desired::{ManagerKey, PlacedConnector};
use rts_plan::mark::Mark;
use rts_plan::observed::{ComponentObserved, LifeCycleState, ManagerObserved, RealtimeObserved};
use rts_plan::plan::{Plan, Step, StepId, Work};
use rts_plan::target::on;
use rts_schemas::system::Configuration;

use super::World;
use super::by_hand::connected;
use super::orders::Running;

/// A rule that a step broke.
pub type Broken = String;

/// How one run of a plan went.
#[derive(Debug, Default)]
pub struct Run {
    /// Target → why one of its steps failed.
    pub failed: BTreeMap<String, String>,
    /// Steps that were tried, in this order.
    pub asked: Vec<StepId>,
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
        self.acted.clear();
        self.running = Running::of(&plan.steps);
        let mut lost: BTreeSet<StepId> = BTreeSet::new();
        loop {
            self.skip(&mut lost);
            if self.running.open.is_empty() {
                break;
            }
            let ready = self.ready();
            let step = match ready.len() {
                0 => return Err(format!("{} steps can never start", self.running.open.len())),
                count => ready[(chance.pick)(count) % count].clone(),
            };
            let late = self.running.before(&step);
            if !late.is_empty() {
                // Its limits are over.
                let go_on = late.iter().all(|id| Running::may_forget(&step, *id));
                let pairs = late.iter().map(|id| (step.id, *id));
                self.running.forgotten.extend(pairs.filter(|_| go_on));
                if !go_on {
                    self.running.open.remove(&step.id);
                    lost.insert(step.id);
                    let reason = format!("{} waited too long", step.work.kind());
                    run.failed.insert(on(&step.node, &step.target), reason);
                }
                continue;
            }
            run.asked.push(step.id);
            self.running.open.remove(&step.id);
            let failed = if (chance.fails)(&step) {
                Some(format!("{} failed", step.work.kind()))
            } else {
                self.attempt(&step, plan)?
            };
            match failed {
                None => drop(self.running.done.insert(step.id)),
                Some(why) => {
                    lost.insert(step.id);
                    run.failed.insert(on(&step.node, &step.target), why);
                }
            }
        }
        self.notice();
        Ok(run)
    }

    /// Gives up every step that needs a lost one.
    fn skip(&mut self, lost: &mut BTreeSet<StepId>) {
        for step in &self.running.steps {
            let in_vain = |id: &StepId| {
                let forgets = Running::may_forget(step, *id) || self.running.forgets(step, *id);
                lost.contains(id) && !forgets
            };
            if self.running.open.contains(&step.id) && step.needs.iter().any(in_vain) {
                self.running.open.remove(&step.id);
                lost.insert(step.id);
            }
        }
    }

    /// Steps that may start; when nobody is patient, those too that wait only for what is limited.
    fn ready(&self) -> Vec<Step> {
        let open = |step: &&Step| self.running.open.contains(&step.id);
        let may = |step: &&Step| {
            let hasty = self.hasty && self.running.is_armed(step);
            hasty || self.running.before(step).is_empty()
        };
        let steps = self.running.steps.iter().filter(open).filter(may);
        steps.cloned().collect()
    }

    /// Gives the reason when it cannot do it for a good one.
    fn attempt(&mut self, step: &Step, plan: &Plan) -> Result<Option<String>, Broken> {
        let early = self.too_early(step);
        let early = early.iter().filter(|other| !self.has_acted(other));
        let early: Vec<&String> = early.collect();
        if !early.is_empty() {
            let (kind, target) = (step.work.kind(), &step.target);
            return Err(format!("{kind} {target} does not wait for {early:?}"));
        }
        match self.step(step, plan) {
            Ok(()) => Ok(None),
            Err(_) if self.done_already(step) => Ok(None),
            Err(why) if self.excused(step) => Ok(Some(why)),
            Err(why) => {
                let (id, kind, target) = (step.id, step.work.kind(), &step.target);
                Err(format!("step {id} {kind} {target}: {why}"))
            }
        }
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
                manager,
                type_name,
                module_digest,
            } => {
                let installed = (node.to_owned(), type_name.clone());
                check(
                    self.installed.contains(&installed),
                    "the module is not installed",
                )?;
                let process = self.manager(node, manager)?;
                process.modules.insert(type_name.clone());
                // What was opened stays mapped.
                let opened = process.opened.entry(type_name.clone());
                if let Some(digest) = module_digest {
                    opened.or_insert(digest.clone());
                }
                Ok(())
            }
            Work::Create { manager, .. } => self.create(step, node, manager),
            Work::Configure {
                manager,
                instance,
                configuration,
                rate,
                on_disconnect,
                order,
            } => {
                let component = self.find(node, manager, instance)?;
                if let Some(on_disconnect) = on_disconnect {
                    component.on_disconnect = *on_disconnect;
                }
                if *configuration != Configuration::default() {
                    let mut mark = Mark::of(component);
                    mark.set(configuration);
                    let left = (!mark.is_empty()).then(|| mark.encode());
                    component.by_hand.configured = left;
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
                if let (Some(order), Some(shared)) = (order, &mut component.execution_context) {
                    shared.order = *order;
                }
                Ok(())
            }
            Work::Connect { connector } => self.connect(step, node, connector),
            Work::Activate { manager, instance } => self.activate(node, manager, instance),
            Work::Deactivate { manager, instance } => {
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
                component.by_hand.disconnected.remove(connector);
                self.unbind(node, manager.system.as_ref(), connector);
                Ok(())
            }
            Work::Unbind {
                manager,
                instance,
                connector,
            } => {
                let target = self.find(node, manager, instance)?.incarnation.clone();
                let end = (connector.clone(), target.clone());
                let connected = self.connected_ends().contains(&end);
                check(!connected, "somebody is connected to it")?;
                self.unbind_at(&target, connector);
                Ok(())
            }
            Work::Delete { manager, instance } => self.delete_step(plan, node, manager, instance),
            Work::UnloadModule { manager, type_name } => {
                let manager = self.manager(node, manager)?;
                let used = manager
                    .components
                    .iter()
                    .any(|c| !c.stand_in && c.type_name == *type_name);
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
            execution_context,
            on_disconnect,
            stand_in,
            realtime,
            ..
        } = &step.work
        else {
            return Err("no Create".to_owned());
        };
        for (there, key, other) in self.components() {
            // Nobody can know what a silent node holds.
            if self.silent.contains(there) {
                continue;
            }
            // Nor what a person made in a process of others that has never answered.
            let hidden = key.system != step.system && self.is_unseen(there, key);
            let same_name = there == node && other.instance == *instance && !hidden;
            let same_identity = other.instance == *instance && other.system == step.system;
            check(
                !same_name && !same_identity,
                "there would be two of this name",
            )?;
        }
        let mut component =
            self.new_component(instance, type_name, step.system.clone(), recreate_hash);
        component.configuration.clone_from(configuration);
        component.execution_kind = *execution_kind;
        component.execution_context.clone_from(execution_context);
        component.on_disconnect = *on_disconnect;
        component.stand_in = stand_in.is_some();
        component.rate = rate.unwrap_or(component.rate);
        component.realtime = realtime.clone().map(|asked| RealtimeObserved {
            asked,
            ..RealtimeObserved::default()
        });
        let wanted = self.digest(step, type_name);
        let manager = self.manager(node, key)?;
        check(
            component.stand_in || manager.modules.contains(type_name),
            "its module is not loaded",
        )?;
        check(
            component.stand_in || manager.opened.get(type_name) == wanted.as_ref(),
            "its process has other code for it",
        )?;
        manager.components.push(component);
        Ok(())
    }

    fn is_unseen(&self, node: &str, key: &ManagerKey) -> bool {
        let mut managers = self.managers();
        managers.any(|(n, m)| n == node && m.key == *key && self.unseen.contains(&m.incarnation))
    }

    /// The module file that a system wants for a type.
    fn digest(&self, step: &Step, type_name: &str) -> Option<String> {
        let mut systems = self.systems.iter();
        let own = systems.find(|s| Some(&s.reference) == step.system.as_ref())?;
        own.module_digests.get(type_name).cloned()
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
        let (name, ends) = (
            spec.name.clone(),
            (spec.source.clone(), spec.target.clone()),
        );
        let mut connector = connected(name, ends.0, ends.1, &target);
        connector.properties.clone_from(&spec.properties);
        source.by_hand.disconnected.remove(&spec.name);
        source.connectors.push(connector);
        self.bind(&spec.name, &spec.source, &spec.target.port, &target);
        Ok(())
    }

    fn activate(&mut self, node: &str, key: &ManagerKey, instance: &str) -> Result<(), Broken> {
        let component = self.find(node, key, instance)?;
        check(component.state != LifeCycleState::Error, "it is in Error")?;
        check(
            component.state != LifeCycleState::Active,
            "it is Active already",
        )?;
        component.state = LifeCycleState::Active;
        component.by_hand.deactivated = None;
        Ok(())
    }

    fn delete_step(
        &mut self,
        plan: &Plan,
        node: &str,
        key: &ManagerKey,
        instance: &str,
    ) -> Result<(), Broken> {
        let component = self.find(node, key, instance)?.clone();
        check(component.state != LifeCycleState::Active, "it is Active")?;
        check(component.system.is_some(), "a person made it")?;
        let name = &component.incarnation;
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

fn check(holds: bool, otherwise: &str) -> Result<(), Broken> {
    if holds {
        Ok(())
    } else {
        Err(otherwise.to_owned())
    }
}
