//! What is remembered of the components of systems: where they live, how often and when their processes ended, and
//! which of them are not brought up again. Pure: what time it is comes from outside.

use std::collections::BTreeMap;

use jiff::Timestamp;
use rts_plan::desired::{NodeSpec, NodeSystem, SystemRef};
use rts_plan::observed::{Held, ManagerObserved};
use rts_plan::restart::Ended;

use super::component::Component;
use crate::policies::Policies;

/// Most components that are remembered.
const MAX: usize = 16_384;

/// Identity of a component: (system uid, instance name).
type Identity = (String, String);

/// What is remembered of all.
#[derive(Debug, Default)]
#[cfg_attr(test, derive(Clone))]
pub(super) struct Memory {
    components: BTreeMap<Identity, Component>,
    /// Counts what was told here of single components: an answer to a question from before says nothing of them.
    told: u64,
}

/// True when nothing of a system has changed, but for a generation that was not told before, and for where else its
/// components may still run.
fn is_same(before: &NodeSystem, now: &NodeSystem) -> bool {
    let generation = match before.generation {
        0 => now.generation,
        known => known,
    };
    let before = NodeSystem {
        generation,
        ..before.settled()
    };
    before == now.settled()
}

fn identity(system: &SystemRef, instance: &str) -> Identity {
    (system.uid.clone(), instance.to_owned())
}

impl Memory {
    /// What was remembered before; after a reboot everything is to start, and nothing lives.
    pub fn of(components: Vec<Component>, rebooted: bool) -> Self {
        let mut memory = Self::default();
        for mut component in components.into_iter().take(MAX) {
            if rebooted {
                component.pardon();
                component.lives_in = None;
            }
            let key = identity(&component.system, &component.instance);
            memory.components.insert(key, component);
        }
        memory
    }

    /// All of it.
    pub fn components(&self) -> Vec<Component> {
        self.components.values().cloned().collect()
    }

    /// How often a component was made again.
    pub fn restarts(&self, system: &SystemRef, instance: &str) -> u32 {
        let component = self.components.get(&identity(system, instance));
        component.map_or(0, |c| c.restarts)
    }

    /// What is not brought up again, sorted.
    pub fn held(&self) -> Vec<Held> {
        let mut held: Vec<_> = self
            .components
            .values()
            .filter_map(Component::held)
            .collect();
        held.sort();
        held
    }

    /// Why a component is not brought up again.
    pub fn why_held(&self, system: &SystemRef, instance: &str) -> Option<String> {
        let component = self.components.get(&identity(system, instance))?;
        component.held.clone()
    }

    fn entry(&mut self, system: &SystemRef, instance: &str) -> Option<&mut Component> {
        let key = identity(system, instance);
        if self.components.len() >= MAX && !self.components.contains_key(&key) {
            return None;
        }
        let component = self.components.entry(key);
        Some(component.or_insert_with(|| Component::new(system, instance)))
    }

    /// The number of the last word on a single component: what is asked now is answered later.
    pub fn told(&self) -> u64 {
        self.told
    }

    /// A word on one component.
    fn tell(&mut self, system: &SystemRef, instance: &str) -> Option<&mut Component> {
        self.told += 1;
        let told = self.told;
        let component = self.entry(system, instance)?;
        component.told = told;
        component.leaving = false;
        Some(component)
    }

    /// A manager is about to make a component; or it has it after all.
    pub fn made(&mut self, system: &SystemRef, instance: &str, incarnation: &str) {
        if let Some(component) = self.tell(system, instance) {
            component.lives_in = Some(incarnation.to_owned());
            component.ended_in = None;
        }
    }

    /// A component is about to be deleted: should that end its process, it does not die by itself.
    pub fn leaving(&mut self, system: &SystemRef, instance: &str) {
        self.gone(system, instance);
        let component = self.components.get_mut(&identity(system, instance));
        if let Some(component) = component {
            component.leaving = true;
        }
    }

    /// These belong into a manager, which ended while nobody watched: those that nothing is known of lived in it.
    pub fn assume(&mut self, system: &SystemRef, instances: &[String], incarnation: &str) {
        for instance in instances {
            if !self.components.contains_key(&identity(system, instance)) {
                self.made(system, instance, incarnation);
            }
        }
    }

    /// A component is deleted, or was never made. Its manager goes on, and may say later that it is there all the same.
    pub fn gone(&mut self, system: &SystemRef, instance: &str) {
        if self.components.contains_key(&identity(system, instance))
            && let Some(component) = self.tell(system, instance)
        {
            component.lives_in = None;
        }
    }

    /// A manager is stopped: what ends with it does not die.
    pub fn left(&mut self, incarnation: &str) {
        for component in self.living_in(incarnation) {
            component.end();
        }
    }

    /// The process of a manager ended by itself. Gives what is not brought up again because of it.
    pub fn died(
        &mut self,
        incarnation: &str,
        ended: Ended,
        now: Timestamp,
        policies: &Policies,
    ) -> Vec<Held> {
        let dead = self.living_in(incarnation);
        dead.filter_map(|component| component.died(ended, now, policies))
            .collect()
    }

    fn living_in(&mut self, incarnation: &str) -> impl Iterator<Item = &mut Component> {
        let all = self.components.values_mut();
        all.filter(move |c| c.lives_in.as_deref() == Some(incarnation))
    }

    /// A manager has answered to what was asked when `asked` was the last word. What is there is held no longer. True
    /// when that was news.
    pub fn seen(&mut self, manager: &ManagerObserved, asked: u64) -> bool {
        let mut news = false;
        for observed in &manager.components {
            let Some(system) = &observed.system else {
                continue;
            };
            let Some(component) = self.entry(system, &observed.instance) else {
                continue;
            };
            let ended = component.ended_in.as_ref() == Some(&manager.incarnation);
            if ended || component.leaving || component.told > asked {
                continue;
            }
            let lives_in = Some(manager.incarnation.clone());
            let restarts = component.restarts.max(observed.restarts);
            news |= component.lives_in != lives_in
                || component.restarts != restarts
                || component.held.is_some();
            component.lives_in = lives_in;
            component.restarts = restarts;
            component.held = None;
        }
        news
    }

    /// Forgets components that a spec does not name, and what speaks against those whose system has changed. The same
    /// system in other words, as the controller of another version writes it, has not: `before` is the spec until now.
    pub fn keep(&mut self, spec: &NodeSpec, before: Option<&NodeSpec>, policies: &Policies) {
        let named = |c: &Component| policies.of(&c.system, &c.instance).is_some();
        self.components.retain(|_, component| named(component));
        for system in &spec.systems {
            let part = policies.part(&system.system);
            let mut before = before.into_iter().flat_map(|before| &before.systems);
            let same = before.any(|before| is_same(before, system));
            let own = self.components.values_mut();
            for component in own.filter(|c| c.system.uid == system.system.uid) {
                if component.part.as_deref().is_none_or(|p| Some(p) == part) {
                    continue;
                }
                if same {
                    component.part = part.map(str::to_owned);
                } else {
                    component.pardon();
                }
            }
        }
    }
}
