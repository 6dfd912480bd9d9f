//! Compares each look with the one before: what changed without an excuse is a violation.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use rts_manager_api::control::ComponentInfo;

use super::excuses::Excuses;
use super::table::Manager;

/// Longest time without a new sample where samples flow.
const STALL: Duration = Duration::from_secs(6);
/// Longest time that a healthy manager may be silent.
const SILENCE: Duration = Duration::from_secs(10);

/// What was seen at one moment.
#[derive(Debug)]
pub struct Look {
    /// When.
    pub at: Instant,
    /// Live managers, and what is in those that answered.
    pub managers: Vec<(Manager, Option<Vec<ComponentInfo>>)>,
    /// The machine kept up: samples that are lost are lost by our programs.
    pub on_time: bool,
}

/// What is known of one component.
#[derive(Debug, Clone)]
struct Life {
    manager: Manager,
    incarnation: String,
    state: String,
    flows: BTreeMap<String, Flow>,
}

/// What is known of one end of a connector.
#[derive(Debug, Clone)]
struct Flow {
    received: u64,
    gaps: u64,
    /// Of the last sample.
    since: Instant,
}

/// Remembers what was seen.
#[derive(Debug, Default)]
pub struct Judge {
    lives: BTreeMap<String, Life>,
    /// Since when a process does not answer.
    silent: BTreeMap<u32, Instant>,
}

impl Judge {
    /// Judges a look and remembers it.
    pub fn judge(&mut self, look: &Look, excuses: &Excuses) -> Vec<String> {
        let mut found = twins(look);
        self.find_silent(look, excuses, &mut found);
        self.find_ended(look, excuses, &mut found);
        for (manager, components) in &look.managers {
            for info in components.iter().flatten() {
                self.see(look, manager, info, excuses, &mut found);
            }
        }
        found
    }

    fn find_silent(&mut self, look: &Look, excuses: &Excuses, found: &mut Vec<String>) {
        let quiet = |pid: u32| {
            let mut managers = look.managers.iter();
            managers.any(|(m, answer)| m.pid == pid && answer.is_none())
        };
        self.silent.retain(|pid, _| quiet(*pid));
        for (manager, answer) in &look.managers {
            if answer.is_some() || excuses.silent.contains(&manager.pid) {
                self.silent.remove(&manager.pid);
                continue;
            }
            let since = *self.silent.entry(manager.pid).or_insert(look.at);
            if look.at.duration_since(since) > SILENCE {
                let text = manager.text();
                found.push(format!("{text} has not answered for {SILENCE:?}"));
            }
        }
    }

    /// What was there and is gone, though its process answers or has ended.
    fn find_ended(&mut self, look: &Look, excuses: &Excuses, found: &mut Vec<String>) {
        let mut gone = Vec::new();
        for (instance, life) in &self.lives {
            let process = look
                .managers
                .iter()
                .find(|(m, _)| (m.pid, m.ticks) == (life.manager.pid, life.manager.ticks));
            let why = match process {
                None => "its process has ended",
                Some((_, None)) => continue,
                Some((_, Some(all))) if all.iter().any(|c| c.instance == *instance) => continue,
                Some(_) => "its process has it no more",
            };
            gone.push(instance.clone());
            if !excuses.touched.contains(instance) {
                let text = life.manager.text();
                found.push(format!(
                    "{instance} was in {text}: {why}, and nobody touched it"
                ));
            }
        }
        for instance in gone {
            self.lives.remove(&instance);
        }
    }

    fn see(
        &mut self,
        look: &Look,
        manager: &Manager,
        info: &ComponentInfo,
        excuses: &Excuses,
        found: &mut Vec<String>,
    ) {
        let instance = &info.instance;
        let touched = excuses.touched.contains(instance);
        let before = self.lives.get(instance);
        if !touched {
            match before {
                None => found.push(format!("{instance} has begun, and nobody wishes that")),
                Some(before) => compare(before, manager, info, found),
            }
        }
        let same = before.filter(|before| before.incarnation == info.incarnation);
        let judged = Judged {
            look,
            excuses,
            touched,
            system: &manager.system,
        };
        let flows = judged.flows(same, info, found);
        let life = Life {
            manager: manager.clone(),
            incarnation: info.incarnation.clone(),
            state: info.state.clone(),
            flows,
        };
        self.lives.insert(instance.clone(), life);
    }

    /// Instances that were last seen in this process.
    pub fn instances_of(&self, pid: u32) -> Vec<String> {
        let lives = self.lives.iter();
        lives
            .filter(|(_, life)| life.manager.pid == pid)
            .map(|(instance, _)| instance.clone())
            .collect()
    }

    /// The time before now does not count as a stall.
    pub fn forget_stalls(&mut self) {
        let now = Instant::now();
        let flows = self
            .lives
            .values_mut()
            .flat_map(|life| life.flows.values_mut());
        flows.for_each(|flow| flow.since = now);
        self.silent.clear();
    }
}

/// What samples are judged by.
struct Judged<'a> {
    look: &'a Look,
    excuses: &'a Excuses,
    touched: bool,
    system: &'a str,
}

impl Judged<'_> {
    fn flows(
        &self,
        before: Option<&Life>,
        info: &ComponentInfo,
        found: &mut Vec<String>,
    ) -> BTreeMap<String, Flow> {
        let mut flows = BTreeMap::new();
        for binding in &info.bindings {
            let then = before.and_then(|life| life.flows.get(&binding.connector));
            let excused = self.touched || self.excuses.connectors.contains(&binding.connector);
            let starved = excused || self.excuses.starved.contains(self.system);
            let (instance, connector) = (&info.instance, &binding.connector);
            let mut since = self.look.at;
            if let Some(then) = then {
                if binding.gaps > then.gaps && !excused && self.look.on_time {
                    let more = binding.gaps - then.gaps;
                    found.push(format!(
                        "{instance} lost samples of {connector}: {more} gaps"
                    ));
                }
                if binding.samples_received == then.received && !starved && self.look.on_time {
                    since = then.since;
                }
                if self.look.at.duration_since(since) > STALL {
                    found.push(format!("no sample of {connector} has come for {STALL:?}"));
                }
            }
            let flow = Flow {
                received: binding.samples_received,
                gaps: binding.gaps,
                since,
            };
            flows.insert(connector.clone(), flow);
        }
        flows
    }
}

/// Two live processes of one key, or two live incarnations of one instance.
fn twins(look: &Look) -> Vec<String> {
    let mut found = Vec::new();
    let mut keys: BTreeMap<(&str, &str), &Manager> = BTreeMap::new();
    let mut instances: BTreeMap<&str, &Manager> = BTreeMap::new();
    for (manager, components) in &look.managers {
        if let Some(twin) = keys.insert(manager.key(), manager) {
            let (one, other) = (twin.text(), manager.text());
            found.push(format!(
                "two live processes of one manager: {one} and {other}"
            ));
        }
        for info in components.iter().flatten() {
            if let Some(twin) = instances.insert(&info.instance, manager) {
                let (one, other) = (twin.text(), manager.text());
                let instance = &info.instance;
                found.push(format!(
                    "two live incarnations of {instance}: in {one} and in {other}"
                ));
            }
        }
    }
    found
}

fn compare(before: &Life, manager: &Manager, info: &ComponentInfo, found: &mut Vec<String>) {
    let instance = &info.instance;
    let (then, now) = (&before.manager, manager);
    if (then.pid, then.ticks) != (now.pid, now.ticks) {
        let (then, now) = (then.text(), now.text());
        found.push(format!(
            "{instance} moved from {then} to {now}, and nobody touched it"
        ));
    } else if before.incarnation != info.incarnation {
        found.push(format!("{instance} was made again, and nobody touched it"));
    } else if before.state == "Active" && info.state != "Active" {
        let (state, message) = (&info.state, &info.message);
        found.push(format!(
            "{instance} was Active and is {state} ({message:?}), and nobody touched it"
        ));
    }
}

#[cfg(test)]
mod tests;
