//! Where the components of systems live, how often their processes died, and which of them are not brought up again.
//! Durable: an agent that starts knows what died while it was away.

mod component;
mod file;
mod memory;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rts_agent_api::session::AgentEvent;
use rts_host::disk::Disk;
use rts_manager_api::files::ManagerFile;
use rts_plan::desired::{ManagerKey, NodeSpec, SystemRef};
use rts_plan::observed::{Held, Inventory};
use rts_plan::restart::Ended;
use rts_plan::target;
use tokio::time::sleep;

use crate::agent::{Agent, StartError};
use crate::events::{lock, of_manager};
use crate::inventory::system_ref;
use crate::launch::Exit;
use crate::managers::Patience;
use crate::policies::Policies;
use memory::Memory;

/// How long changes are gathered that may be written a little later.
const GATHER: Duration = Duration::from_millis(100);

/// What is remembered, in memory and on disk.
pub(crate) struct Restarts {
    memory: Mutex<Memory>,
    disk: Arc<dyn Disk>,
    path: PathBuf,
    boot_id: Option<String>,
    /// Number of the last change.
    changes: AtomicU64,
    /// Number of the last change that is on disk; locked while it is written.
    saved: Arc<tokio::sync::Mutex<u64>>,
    /// A write is about to come.
    soon: AtomicBool,
}

impl Restarts {
    /// Reads what was remembered in a state folder.
    pub async fn load(
        disk: Arc<dyn Disk>,
        state: &Path,
        boot_id: Option<String>,
    ) -> Result<Self, StartError> {
        let path = file::path(state);
        let memory = match file::load(&*disk, &path, boot_id.as_deref()).await {
            Ok(memory) => memory,
            Err(source) => return Err(StartError::File { path, source }),
        };
        Ok(Self {
            memory: Mutex::new(memory),
            disk,
            path,
            boot_id,
            changes: AtomicU64::new(0),
            saved: Arc::default(),
            soon: AtomicBool::new(false),
        })
    }

    /// Forgets what a spec does not name; written with the next change.
    pub fn keep(&mut self, spec: &NodeSpec, policies: &Policies) {
        self.change(|m| m.keep(spec, None, policies));
    }

    /// The count that the next creation of a component has.
    pub fn of(&self, system: &SystemRef, instance: &str) -> u32 {
        lock(&self.memory).restarts(system, instance)
    }

    /// What is not brought up again, sorted.
    pub fn held(&self, policies: &Policies) -> Vec<Held> {
        let mut held = lock(&self.memory).held();
        // What is held is held under the spec of now: another one has pardoned it.
        for held in &mut held {
            held.part = policies.digest(&held.system).map(str::to_owned);
        }
        held
    }

    /// Why a component is not brought up again.
    pub fn why_held(&self, system: &SystemRef, instance: &str) -> Option<String> {
        lock(&self.memory).why_held(system, instance)
    }

    fn change<T>(&self, change: impl FnOnce(&mut Memory) -> T) -> T {
        let done = change(&mut lock(&self.memory));
        self.changes.fetch_add(1, Ordering::SeqCst);
        done
    }

    /// Writes what has changed. Durable when it returns; a failure is told, and the next change tries again. A write goes
    /// on when the caller gives up: no other may begin meanwhile.
    pub async fn save(&self) {
        let mut saved = self.saved.clone().lock_owned().await;
        let changes = self.changes.load(Ordering::SeqCst);
        if *saved == changes {
            return;
        }
        let components = lock(&self.memory).components();
        let (disk, path) = (self.disk.clone(), self.path.clone());
        let boot = self.boot_id.clone();
        let write = tokio::spawn(async move {
            match file::save(&*disk, &path, boot.as_deref(), components).await {
                Ok(()) => *saved = changes,
                Err(e) => tracing::warn!("cannot save {}: {e}", path.display()),
            }
        });
        // It cannot panic.
        let _ = write.await;
    }
}

impl Agent {
    /// A manager is about to make a component.
    pub(crate) fn component_made(
        self: &Arc<Self>,
        system: &SystemRef,
        instance: &str,
        incarnation: &str,
    ) {
        self.restarts
            .change(|m| m.made(system, instance, incarnation));
        self.save_soon();
    }

    /// A component was never made.
    pub(crate) fn component_gone(self: &Arc<Self>, system: &SystemRef, instance: &str) {
        self.restarts.change(|m| m.gone(system, instance));
        self.save_soon();
    }

    /// A component is about to be deleted. Unless the value that this gives is told how that went, it is there still.
    pub(crate) fn component_leaves(
        self: &Arc<Self>,
        system: &SystemRef,
        instance: &str,
        incarnation: &str,
    ) -> Leaving {
        self.restarts.change(|m| m.leaving(system, instance));
        self.save_soon();
        Leaving {
            agent: self.clone(),
            system: system.clone(),
            instance: instance.to_owned(),
            incarnation: Some(incarnation.to_owned()),
        }
    }

    /// A manager is about to be stopped. One that is replaced since something hangs in it counts as dead, and is not
    /// replaced again before its time.
    pub(crate) async fn manager_leaves(self: &Arc<Self>, incarnation: &str) -> Patience {
        let last = self.inventory.last();
        let mut managers = last.managers.iter();
        let expired = managers
            .find(|m| m.incarnation == incarnation)
            .and_then(|m| Some((&m.key, m.expired.clone()?)));
        if let Some((key, why)) = expired {
            self.manager_failed(key, why);
            self.count_deaths(incarnation, Ended::Unknown).await;
            Patience::Short
        } else {
            self.restarts.change(|m| m.left(incarnation));
            // Beside the stop: should power be lost before it is written, nothing is left that could be taken for dead.
            let agent = self.clone();
            tokio::spawn(async move { agent.restarts.save().await });
            Patience::Usual
        }
    }

    /// A manager failed: without a controller, it is not started or replaced again before its time.
    pub(crate) fn manager_failed(&self, key: &ManagerKey, why: String) {
        let target = target::on(&self.config.node, &target::manager(key));
        lock(&self.failures).failed(target, why, self.inputs.chance.unit());
    }

    /// The process of a manager ended by itself.
    pub(crate) async fn manager_died(&self, incarnation: &str, exit: Exit) {
        let ended = match exit {
            Exit::Code(code) => Ended::Code(code),
            Exit::Signal(signal) => Ended::Signal(signal),
            Exit::Unknown => Ended::Unknown,
        };
        self.count_deaths(incarnation, ended).await;
    }

    /// The run folder of a manager was found whose process ended while nobody watched.
    pub(crate) async fn manager_died_unseen(&self, file: &ManagerFile) {
        if self.restarts.boot_id.as_deref() != Some(file.boot_id.trim()) {
            return;
        }
        let key = ManagerKey {
            system: file.system.as_ref().map(system_ref),
            name: file.name.clone(),
        };
        // What was made in it in the last moment before the agent ended too is not on disk.
        if let Some(system) = &key.system {
            let policies = self.policies();
            let placed = policies.placed_in(&key);
            self.restarts
                .change(|m| m.assume(system, placed, &file.incarnation));
        }
        self.count_deaths(&file.incarnation, Ended::Unknown).await;
        let message = format!("process {} ended while no agent watched it", file.pid);
        self.events
            .push(of_manager("Warning", "ManagerDied", &key, message));
    }

    async fn count_deaths(&self, incarnation: &str, ended: Ended) {
        let (now, policies) = (self.inputs.clock.now(), self.policies());
        let held = self
            .restarts
            .change(|m| m.died(incarnation, ended, now, &policies));
        self.restarts.save().await;
        for held in held {
            self.events.push(not_restarted(held));
        }
    }

    /// The number of the last word on a single component; told with the answers to what is asked now.
    pub(crate) fn components_told(&self) -> u64 {
        lock(&self.restarts.memory).told()
    }

    /// The managers have answered to what was asked when `asked` was the last word.
    pub(crate) fn components_seen(self: &Arc<Self>, inventory: &Inventory, asked: u64) {
        let mut memory = lock(&self.restarts.memory);
        let mut news = false;
        // The others show what was there.
        for manager in inventory.managers.iter().filter(|m| m.responsive) {
            news |= memory.seen(manager, asked);
        }
        drop(memory);
        if news {
            self.restarts.change(|_| ());
            self.save_soon();
        }
    }

    /// A spec was accepted, in place of the one before. What is forgotten for it need not be durable with it: an agent that
    /// starts forgets the same by the spec that it finds.
    pub(crate) fn keep_restarts(
        self: &Arc<Self>,
        spec: &NodeSpec,
        before: Option<&NodeSpec>,
        policies: &Policies,
    ) {
        let forgets = {
            let mut memory = lock(&self.restarts.memory);
            let remembered = memory.components();
            memory.keep(spec, before, policies);
            memory.components() != remembered
        };
        if forgets {
            self.restarts.change(|_| ());
            self.save_soon();
        }
    }

    /// Writes after a moment, for all that changes meanwhile.
    fn save_soon(self: &Arc<Self>) {
        if self.restarts.soon.swap(true, Ordering::SeqCst) {
            return;
        }
        let agent = self.clone();
        tokio::spawn(async move {
            sleep(GATHER).await;
            agent.restarts.soon.store(false, Ordering::SeqCst);
            agent.restarts.save().await;
        });
    }
}

/// A component that is just being deleted.
pub(crate) struct Leaving {
    agent: Arc<Agent>,
    system: SystemRef,
    instance: String,
    /// Incarnation of the manager that it may still live in.
    incarnation: Option<String>,
}

impl Leaving {
    /// It is gone, or its manager is; should it still be there, that one says so.
    pub fn gone(mut self) {
        self.incarnation = None;
    }
}

impl Drop for Leaving {
    fn drop(&mut self) {
        let (agent, system, instance) = (&self.agent, &self.system, &self.instance);
        match &self.incarnation {
            Some(incarnation) => agent.component_made(system, instance, incarnation),
            None => agent.component_gone(system, instance),
        }
    }
}

fn not_restarted(held: Held) -> AgentEvent {
    AgentEvent {
        kind: "Warning".to_owned(),
        reason: "NotRestarted".to_owned(),
        object: target::component(&held.instance),
        system: Some(held.system.name),
        message: held.reason,
    }
}
