//! What may change now, and why: told before anything is done, so that whatever else changes is a violation.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};

use super::wish::{Wish, rewired, touched};

/// Shared by those who act and the watcher.
#[derive(Debug, Clone, Default)]
pub struct Shared(Arc<Mutex<Excuses>>);

/// All of them.
#[derive(Debug, Clone, Default)]
pub struct Excuses {
    /// Instances that may end, begin and change their state.
    pub touched: BTreeSet<String>,
    /// Connectors that may lose samples.
    pub connectors: BTreeSet<String>,
    /// Systems whose samples may not rise.
    pub starved: BTreeSet<String>,
    /// Processes that may not answer.
    pub silent: BTreeSet<u32>,
    /// Deaths: instance to times, RFC 3339.
    pub deaths: BTreeMap<String, Vec<String>>,
}

impl Shared {
    fn with<T>(&self, act: impl FnOnce(&mut Excuses) -> T) -> T {
        act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// As they are now.
    pub fn now(&self) -> Excuses {
        self.with(|excuses| excuses.clone())
    }

    /// One wish may take the place of another.
    pub fn change(&self, before: Option<&Wish>, after: Option<&Wish>) {
        self.with(|excuses| {
            excuses.touched.extend(touched(before, after));
            excuses.connectors.extend(rewired(before, after));
            if before != after {
                excuses
                    .starved
                    .extend(before.or(after).map(|w| w.name.clone()));
            }
        });
    }

    /// The process with these instances of a system ends, and is started again. Those of `dead` were in it.
    pub fn death(&self, system: &str, instances: &[String], dead: &[String], wishes: &[&Wish]) {
        let now = jiff::Timestamp::now();
        let now = format!("{now:.3}");
        self.with(|excuses| {
            excuses.touched.extend(instances.iter().cloned());
            for instance in dead {
                let deaths = excuses.deaths.entry(instance.clone()).or_default();
                deaths.push(now.clone());
            }
            excuses.starved.insert(system.to_owned());
            excuses.connectors.extend(connectors_of(instances, wishes));
        });
    }

    /// The process with these instances of a system does nothing for a while.
    pub fn pause(&self, system: &str, pid: u32, instances: &[String], wishes: &[&Wish]) {
        self.with(|excuses| {
            excuses.silent.insert(pid);
            excuses.starved.insert(system.to_owned());
            // What comes to it meanwhile may be too much; and what it has missed it passes on all at once.
            let fed = fed_by(instances, wishes);
            excuses.connectors.extend(connectors_of(&fed, wishes));
        });
    }

    /// The round is over. Deaths are kept: the logs of the past are judged by them.
    pub fn clear(&self) {
        self.with(|excuses| {
            let deaths = std::mem::take(&mut excuses.deaths);
            *excuses = Excuses {
                deaths,
                ..Excuses::default()
            };
        });
    }
}

/// Connectors with one of these instances at an end.
fn connectors_of(instances: &[String], wishes: &[&Wish]) -> BTreeSet<String> {
    let is_of = |end: &str| instances.iter().any(|i| i == instance_of(end));
    let all = wishes.iter().flat_map(|wish| wish.connectors());
    all.filter(|(_, source, target)| is_of(source) || is_of(target))
        .map(|(name, ..)| name)
        .collect()
}

/// These instances, and all that their samples come to in the end.
fn fed_by(instances: &[String], wishes: &[&Wish]) -> Vec<String> {
    let mut fed = instances.to_vec();
    let connectors: Vec<_> = wishes.iter().flat_map(|wish| wish.connectors()).collect();
    let mut place = 0;
    while let Some(source) = fed.get(place).cloned() {
        for (_, _, target) in connectors.iter().filter(|c| instance_of(&c.1) == source) {
            if !fed.iter().any(|known| known == instance_of(target)) {
                fed.push(instance_of(target).to_owned());
            }
        }
        place += 1;
    }
    fed
}

/// Of `Instance.port`.
fn instance_of(end: &str) -> &str {
    end.split('.').next().unwrap_or_default()
}
