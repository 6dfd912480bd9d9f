//! What users asked for, as far as it may be in force.
//!
//! Told before a request is sent: a request whose answer was lost may have been carried out. A version is out of force
//! once everything has converged to a later one that was acknowledged: until then, somebody may still go by it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rts_schemas::system::{ComponentSpec, ConnectorSpec, SystemSpec};

use crate::truth::{Happened, Subject, Witness};

/// What users asked for. Clones are the same.
#[derive(Debug, Clone, Default)]
pub struct Desired(Arc<Mutex<Inner>>);

#[derive(Debug, Default)]
struct Inner {
    systems: BTreeMap<String, System>,
    /// Instances that a person has changed by hand since everything had converged.
    by_hand: BTreeSet<String>,
    /// Nodes that may get a set of another store.
    handed_over: BTreeSet<String>,
    /// How often a store has gone back to an earlier time.
    restored: u64,
}

#[derive(Debug)]
struct System {
    /// The oldest first: it was not there.
    versions: Vec<Version>,
    /// All before this one are out of force.
    floor: usize,
    /// Versions that there were when a store went back to an earlier time: none of them is sure to be in force again.
    doubted: usize,
    /// Types whose modules were exchanged, and the versions that there were then: a later one brings the new module.
    modules: BTreeMap<String, usize>,
    /// Its uid, as components that were made of it show it.
    uid: Option<String>,
}

impl Default for System {
    fn default() -> Self {
        let absent = Version {
            spec: None,
            acked: true,
        };
        Self {
            versions: vec![absent],
            floor: 1,
            doubted: 0,
            modules: BTreeMap::new(),
            uid: None,
        }
    }
}

/// One request.
#[derive(Debug, Clone)]
struct Version {
    /// None for a deletion.
    spec: Option<Arc<SystemSpec>>,
    acked: bool,
}

/// What may be desired of one system.
#[derive(Debug, Clone, Default)]
pub(super) struct Candidates {
    /// None where the system may be gone.
    pub specs: Vec<Option<Arc<SystemSpec>>>,
    /// Uid of those components that were made last.
    pub uid: Option<String>,
}

impl Desired {
    /// A system is about to be applied.
    pub fn asked(&self, spec: &SystemSpec) {
        self.push(&spec.name, Some(Arc::new(spec.clone())));
    }

    /// The deletion of a system is about to be asked for.
    pub fn deletion_asked(&self, system: &str) {
        self.push(system, None);
    }

    /// The last request for a system was refused.
    pub fn refused(&self, system: &str) {
        if let Some(system) = self.lock().systems.get_mut(system)
            && system.versions.last().is_some_and(|last| !last.acked)
        {
            system.versions.pop();
        }
    }

    /// The module of a type is about to be exchanged.
    pub fn module_changed(&self, type_name: &str) {
        for system in self.lock().systems.values_mut() {
            let versions = system.versions.len();
            system.modules.insert(type_name.to_owned(), versions);
        }
    }

    /// A component is about to be changed by hand, or one of its connectors.
    pub fn by_hand(&self, instance: &str) {
        self.lock().by_hand.insert(instance.to_owned());
    }

    /// A node is about to be given to another store: adopted, or taken over.
    pub fn handed_over(&self, node: &str) {
        self.lock().handed_over.insert(node.to_owned());
    }

    /// A store goes back to an earlier time, by a backup: anything that was ever desired may be so again.
    pub fn restored(&self) {
        let mut inner = self.lock();
        inner.restored += 1;
        for system in inner.systems.values_mut() {
            system.floor = 0;
            system.doubted = system.versions.len();
        }
    }

    /// Everything is as desired, everywhere.
    pub fn converged(&self) {
        let mut inner = self.lock();
        inner.by_hand.clear();
        for system in inner.systems.values_mut() {
            let acked = system.versions.iter().rposition(|version| version.acked);
            let sure = acked.filter(|acked| *acked >= system.doubted);
            let old = |then: usize| acked.is_none_or(|acked| acked < then);
            system.modules.retain(|_, then| old(*then));
            system.floor = sure.unwrap_or(0).max(system.floor);
        }
    }

    /// What may be desired of a system.
    pub(super) fn candidates(&self, system: &str) -> Candidates {
        let inner = self.lock();
        let Some(system) = inner.systems.get(system) else {
            return Candidates::default();
        };
        let versions = system.versions.iter().skip(system.floor);
        Candidates {
            specs: versions.map(|version| version.spec.clone()).collect(),
            uid: system.uid.clone(),
        }
    }

    /// True when an instance was changed by hand.
    pub(super) fn is_by_hand(&self, instance: &str) -> bool {
        self.lock().by_hand.contains(instance)
    }

    /// True when one of a system's types has another module by now than when everything had converged.
    pub(super) fn has_other_module(&self, spec: &SystemSpec) -> bool {
        let inner = self.lock();
        let system = inner.systems.get(&spec.name);
        let mut types = spec.components.iter().map(|c| &c.type_name);
        system.is_some_and(|system| types.any(|name| system.modules.contains_key(name)))
    }

    /// True when a node may get a set of another store.
    pub(super) fn is_handed_over(&self, node: &str) -> bool {
        self.lock().handed_over.contains(node)
    }

    /// How often a store has gone back to an earlier time.
    pub(super) fn restores(&self) -> u64 {
        self.lock().restored
    }

    /// True when the last request for a system was made before a store went back: whoever acknowledges it may be the
    /// controller of before, whose store counts no more.
    pub(super) fn is_of_before(&self, system: &str) -> bool {
        let inner = self.lock();
        let system = inner.systems.get(system);
        system.is_some_and(|system| system.versions.len() <= system.doubted)
    }

    /// True when the last request for a system is for its deletion (`deleted`), or for its existence, and there is no
    /// answer to it yet.
    pub(super) fn is_in_flight(&self, system: &str, deleted: bool) -> bool {
        let inner = self.lock();
        let versions = inner.systems.get(system).map(|system| &system.versions);
        let since_ack = versions
            .into_iter()
            .flatten()
            .rev()
            .take_while(|v| !v.acked);
        since_ack.map(|v| v.spec.is_none()).any(|d| d == deleted)
    }

    fn push(&self, system: &str, spec: Option<Arc<SystemSpec>>) {
        let mut inner = self.lock();
        let system = inner.systems.entry(system.to_owned()).or_default();
        system.versions.push(Version { spec, acked: false });
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Witness for Desired {
    fn see(&mut self, _: Duration, what: &Happened) {
        let mut inner = self.lock();
        match what {
            Happened::DesiredAcked { system, generation } => {
                let versions = inner.systems.get_mut(system).map(|s| &mut s.versions);
                let mut asked = versions.into_iter().flatten().rev();
                let meant = |v: &&mut Version| v.spec.is_some() == generation.is_some();
                if let Some(version) = asked.find(meant) {
                    version.acked = true;
                }
            }
            Happened::Created(Subject {
                system: Some(reference),
                ..
            }) => {
                if let Some(system) = inner.systems.get_mut(&reference.name) {
                    system.uid = Some(reference.uid.clone());
                }
            }
            _ => {}
        }
    }
}

impl Candidates {
    /// The component, if every candidate has it and all say the same of it.
    pub fn agreed(&self, instance: &str) -> Option<&ComponentSpec> {
        let mut all = self.specs.iter().map(|spec| {
            let components = &spec.as_ref()?.components;
            components.iter().find(|c| c.instance == instance)
        });
        let first = all.next()??;
        all.all(|other| other == Some(first)).then_some(first)
    }

    /// The connector, if every candidate has it and all say the same of it.
    pub fn agreed_connector(&self, name: &str) -> Option<&ConnectorSpec> {
        let mut all = self.specs.iter().map(|spec| {
            let connectors = &spec.as_ref()?.connectors;
            connectors.iter().find(|c| c.name == name)
        });
        let first = all.next()??;
        all.all(|other| other == Some(first)).then_some(first)
    }

    /// Candidates in which the system is there.
    pub fn present(&self) -> impl Iterator<Item = &Arc<SystemSpec>> {
        self.specs.iter().flatten()
    }
}

#[cfg(test)]
mod tests;
