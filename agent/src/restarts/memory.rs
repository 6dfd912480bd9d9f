//! What is remembered of the components of systems: where they live, how often and when their processes ended, and
//! which of them are not brought up again. Pure: what time it is comes from outside.

use std::collections::BTreeMap;
use std::time::Duration;

use jiff::Timestamp;
use rts_plan::desired::{NodeSpec, SystemRef};
use rts_plan::observed::{Held, ManagerObserved};
use rts_plan::restart::{Ended, Verdict, verdict, window};
use rts_schemas::system::Policy;
use serde::{Deserialize, Serialize};

use crate::policies::Policies;

/// Most components that are remembered.
const MAX: usize = 16_384;
/// Most deaths of one component that are remembered, whatever its limit.
const MAX_DEATHS: usize = 1001;
/// How many are remembered of one without a limit.
const DEATHS: usize = 16;

/// Identity of a component: (system uid, instance name).
type Identity = (String, String);

/// What is remembered of all.
#[derive(Debug, Default)]
pub(super) struct Memory(BTreeMap<Identity, Component>);

/// What is remembered of one component.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Component {
    system: SystemRef,
    instance: String,
    /// How often it was made again since its process ended.
    #[serde(default)]
    restarts: u32,
    /// When its processes ended by themselves, within its window and this boot.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    deaths: Vec<Timestamp>,
    /// How the last of them ended.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    last_exit: Option<String>,
    /// Incarnation of the manager that it lives in, or was about to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    lives_in: Option<String>,
    /// Why it is not brought up again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    held: Option<String>,
    /// The text of its system's part under which its deaths are counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    part: Option<String>,
    /// Incarnation of a manager that has ended, or was told to: an answer that it gave before says nothing any more.
    #[serde(skip)]
    ended_in: Option<String>,
}

impl Component {
    fn new(system: &SystemRef, instance: &str) -> Self {
        Self {
            system: system.clone(),
            instance: instance.to_owned(),
            restarts: 0,
            deaths: Vec::new(),
            last_exit: None,
            lives_in: None,
            held: None,
            part: None,
            ended_in: None,
        }
    }

    fn leave(&mut self) {
        self.ended_in = self.lives_in.take();
    }

    /// All is forgotten that speaks against making it again.
    fn pardon(&mut self) {
        self.deaths.clear();
        self.held = None;
        self.part = None;
    }

    fn died(&mut self, ended: Ended, now: Timestamp, policies: &Policies) -> Option<Held> {
        self.leave();
        self.restarts = self.restarts.saturating_add(1);
        self.last_exit = Some(ended.to_string());
        let policy = policies.of(&self.system, &self.instance)?;
        self.part = policies.part(&self.system).map(str::to_owned);
        let recent = self.count(policy, now);
        let Verdict::Held(reason) = verdict(policy, ended, recent) else {
            return None;
        };
        self.held = Some(reason);
        self.held()
    }

    /// Adds a death, forgets those that count no more, and gives the number of those left.
    fn count(&mut self, policy: &Policy, now: Timestamp) -> u32 {
        let window = window(policy);
        self.deaths.retain(|death| apart(*death, now) <= window);
        self.deaths.push(now);
        let most = policy.restart_limit.map_or(DEATHS, |limit| {
            usize::try_from(limit).map_or(MAX_DEATHS, |limit| limit.saturating_add(1))
        });
        let over = self.deaths.len().saturating_sub(most.min(MAX_DEATHS));
        self.deaths.drain(..over);
        u32::try_from(self.deaths.len()).unwrap_or(u32::MAX)
    }

    fn held(&self) -> Option<Held> {
        Some(Held {
            system: self.system.clone(),
            instance: self.instance.clone(),
            part: self.part.clone(),
            reason: self.held.clone()?,
        })
    }
}

/// The time between two, whichever is earlier: a clock may be set back.
fn apart(one: Timestamp, other: Timestamp) -> Duration {
    one.duration_since(other).unsigned_abs()
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
            memory.0.insert(key, component);
        }
        memory
    }

    /// All of it.
    pub fn components(&self) -> Vec<Component> {
        self.0.values().cloned().collect()
    }

    /// How often a component was made again.
    pub fn restarts(&self, system: &SystemRef, instance: &str) -> u32 {
        let component = self.0.get(&identity(system, instance));
        component.map_or(0, |c| c.restarts)
    }

    /// What is not brought up again, sorted.
    pub fn held(&self) -> Vec<Held> {
        let mut held: Vec<_> = self.0.values().filter_map(Component::held).collect();
        held.sort();
        held
    }

    /// Why a component is not brought up again.
    pub fn why_held(&self, system: &SystemRef, instance: &str) -> Option<String> {
        let component = self.0.get(&identity(system, instance))?;
        component.held.clone()
    }

    fn entry(&mut self, system: &SystemRef, instance: &str) -> Option<&mut Component> {
        let key = identity(system, instance);
        if self.0.len() >= MAX && !self.0.contains_key(&key) {
            return None;
        }
        let component = self.0.entry(key);
        Some(component.or_insert_with(|| Component::new(system, instance)))
    }

    /// A manager is about to make a component.
    pub fn made(&mut self, system: &SystemRef, instance: &str, incarnation: &str) {
        if let Some(component) = self.entry(system, instance) {
            component.lives_in = Some(incarnation.to_owned());
            component.ended_in = None;
        }
    }

    /// These belong into a manager, which ended while nobody watched: those that nothing is known of lived in it.
    pub fn assume(&mut self, system: &SystemRef, instances: &[String], incarnation: &str) {
        for instance in instances {
            if !self.0.contains_key(&identity(system, instance)) {
                self.made(system, instance, incarnation);
            }
        }
    }

    /// A component is deleted, or was never made.
    pub fn gone(&mut self, system: &SystemRef, instance: &str) {
        if let Some(component) = self.0.get_mut(&identity(system, instance)) {
            component.leave();
        }
    }

    /// A manager is stopped: what ends with it does not die.
    pub fn left(&mut self, incarnation: &str) {
        for component in self.living_in(incarnation) {
            component.leave();
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
        let all = self.0.values_mut();
        all.filter(move |c| c.lives_in.as_deref() == Some(incarnation))
    }

    /// A manager has answered. What is there is held no longer. True when that was news.
    pub fn seen(&mut self, manager: &ManagerObserved) -> bool {
        let mut news = false;
        for observed in &manager.components {
            let Some(system) = &observed.system else {
                continue;
            };
            let Some(component) = self.entry(system, &observed.instance) else {
                continue;
            };
            if component.ended_in.as_ref() == Some(&manager.incarnation) {
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

    /// Forgets components that a spec does not name, and what speaks against those whose system has changed.
    pub fn keep(&mut self, spec: &NodeSpec, policies: &Policies) {
        let named = |c: &Component| policies.of(&c.system, &c.instance).is_some();
        self.0.retain(|_, component| named(component));
        for system in &spec.systems {
            let part = policies.part(&system.system);
            let own = self.0.values_mut();
            for component in own.filter(|c| c.system.uid == system.system.uid) {
                if component.part.as_deref().is_some_and(|p| Some(p) != part) {
                    component.pardon();
                }
            }
        }
    }
}
