//! What a manager holds. Its locks are held for look-ups only, never while a component or a peer is waited for.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use rts_manager_api::control::{Failure, Hello};

use crate::component::{Component, Contexts};
use crate::data::Parting;
use crate::data::binding::Bindings;
use crate::events::Events;
use crate::failure::{conflict, list, not_found};
use crate::module::Module;
use crate::module::loading::Loading;
use crate::pool::Pool;
use crate::slots::Slots;
use crate::sync::lock;
use crate::tap;

/// Components of one manager that may exist at once.
const MAX_COMPONENTS: usize = 4096;
/// Outgoing data connections, a thread each.
const MAX_DATA: usize = 1024;
/// Threads of each pool that are ready before they are needed: for one who still wants something of a manager in which an
/// initialiser hangs, and one that is kept for his order to end it (Deactivate, Delete, Shutdown). What is asked at once takes one, however much it is, and each costs a
/// process a tenth of its start and its end.
const SPARE_THREADS: usize = 2;
/// Requests that may be under way at once.
const MAX_REQUESTS: usize = 64;
/// Control connections.
pub const MAX_CONTROLS: usize = 64;
/// Incoming data connections.
pub const MAX_INCOMING: usize = 1024;
/// Connections of both kinds, and those that have not greeted yet.
const MAX_CONNECTIONS: usize = MAX_CONTROLS + MAX_INCOMING + 64;

/// The manager.
pub struct Manager {
    /// What it answers to a greeting.
    pub hello: Hello,
    /// Where it does, for connectors that take a transport though both ends are here.
    pub socket: PathBuf,
    /// Modules that are open, by type.
    pub modules: Mutex<BTreeMap<String, Arc<Module>>>,
    /// Type name → digest of the file that was opened for it, as far as it was told; never forgotten.
    pub opened: Mutex<BTreeMap<String, String>>,
    /// Modules are opened one at a time.
    pub loading: Arc<Loading>,
    /// In-port ends.
    pub bindings: Bindings,
    /// The way out for events.
    pub events: Events,
    /// Outgoing data connections.
    pub outgoing: Slots,
    /// Who looks at ports or writes to them.
    pub taps: tap::List,
    /// Threads for requests.
    pub pool: Pool,
    /// Threads for connections.
    pub connections: Pool,
    /// Execution contexts that components share.
    pub contexts: Contexts,
    components: Mutex<BTreeMap<String, Arc<Component>>>,
    stopping: AtomicBool,
}

/// The threads of a manager, which may run before it is known which manager it is.
pub struct Threads {
    /// For requests.
    pool: Pool,
    /// For connections.
    connections: Pool,
    /// Sends events.
    events: Events,
}

impl Threads {
    /// None is started yet.
    pub fn new() -> Self {
        Self {
            pool: Pool::new("request", MAX_REQUESTS, SPARE_THREADS),
            connections: Pool::new("connection", MAX_CONNECTIONS, SPARE_THREADS),
            events: Events::default(),
        }
    }

    /// Starts those that must be there before a module is opened, and does not wait for them.
    pub fn prepare(&self) {
        // With its first connection and its first request as many are free.
        self.connections.prepare_for(1);
        self.pool.prepare_for(1);
        self.events.prepare();
    }
}

/// What is in the way of an orderly end of the process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Leftovers {
    /// Nothing.
    None,
    /// Code of a module still runs: exit handlers of its library would wait for it or crash with it.
    Running,
}

impl Manager {
    /// An empty manager.
    pub fn new(hello: Hello, socket: PathBuf, threads: Threads) -> Self {
        let Threads {
            pool,
            connections,
            events,
        } = threads;
        Self {
            hello,
            socket,
            pool,
            connections,
            events,
            modules: Mutex::default(),
            opened: Mutex::default(),
            loading: Arc::default(),
            bindings: Bindings::default(),
            outgoing: Slots::new(MAX_DATA),
            taps: tap::List::default(),
            contexts: Contexts::default(),
            components: Mutex::default(),
            stopping: AtomicBool::new(false),
        }
    }

    /// From now on nothing is created any more.
    pub fn stop_creating(&self) {
        // Under the lock, so that nothing is added after the list was taken.
        let _components = lock(&self.components);
        self.stopping.store(true, Ordering::Release);
    }

    /// True once it was told to end.
    pub fn is_stopping(&self) -> bool {
        self.stopping.load(Ordering::Acquire)
    }

    /// Whether code of a module still runs after everything was taken down.
    pub fn leftovers(&self) -> Leftovers {
        if lock(&self.components).is_empty() && self.loading.hangs().is_none() {
            Leftovers::None
        } else {
            Leftovers::Running
        }
    }

    /// Waits until the threads run that are needed while an initialiser hangs in dlopen.
    pub fn settle_threads(&self) {
        self.events.prepare();
        self.connections.prepare();
        self.pool.settle();
        self.connections.settle();
    }

    /// False while an initialiser hangs in dlopen: a new thread would then wait for it.
    pub fn may_start_threads(&self) -> bool {
        !self.loading.is_stuck()
    }

    /// The component with this name.
    pub fn component(&self, instance: &str) -> Result<Arc<Component>, Failure> {
        let components = lock(&self.components);
        components.get(instance).cloned().ok_or_else(|| {
            not_found(format!(
                "there is no component `{instance}` in the manager {}; there are: {}",
                self.hello.name,
                list(components.keys().map(String::as_str))
            ))
        })
    }

    /// All components, by name.
    pub fn components(&self) -> Vec<Arc<Component>> {
        lock(&self.components).values().cloned().collect()
    }

    /// Makes a component known. Its name must be free.
    pub fn add_component(&self, component: &Arc<Component>) -> Result<(), Failure> {
        let name = &component.identity.instance;
        let mut components = lock(&self.components);
        if self.is_stopping() {
            return Err(conflict("the manager is shutting down"));
        }
        if let Some(other) = components.get(name) {
            return Err(conflict(format!(
                "there is a component `{name}` already (type {}, incarnation {}); delete it first",
                other.module.type_name, other.identity.incarnation
            )));
        }
        if components.len() >= MAX_COMPONENTS {
            return Err(conflict(format!(
                "there are {MAX_COMPONENTS} components already"
            )));
        }
        let module = &component.module;
        let most = module.max_instances as usize;
        let of_type = |other: &&Arc<Component>| Arc::ptr_eq(&other.module, module);
        if most > 0 && components.values().filter(of_type).count() >= most {
            return Err(conflict(format!(
                "the type {} allows {most} instances in one process, and the manager {} has as many; place `{name}` in \
                 another manager",
                module.type_name, self.hello.name
            )));
        }
        components.insert(name.clone(), Arc::clone(component));
        Ok(())
    }

    /// Forgets a component that has ended.
    pub fn remove_component(&self, component: &Arc<Component>) {
        self.detach(component, Parting::GoodBye);
        let mut components = lock(&self.components);
        let name = &component.identity.instance;
        if components
            .get(name)
            .is_some_and(|known| Arc::ptr_eq(known, component))
        {
            components.remove(name);
        }
    }

    /// Closes all connectors of a component, at both kinds of ends, and lets none be added.
    pub fn detach(&self, component: &Component, parting: Parting) {
        component.leave();
        for connector in component.take_connectors(|_| true) {
            connector.close(parting);
            let request = &connector.request;
            if parting == Parting::Loss && connector.is_direct() {
                self.lose(&request.target_instance, &request.connector);
            }
        }
        for end in self.bindings.remove_of(&component.identity.incarnation) {
            end.close(&self.events, parting);
            let binding = &end.binding;
            if parting == Parting::Loss
                && end.is_direct()
                && let Some((source, _)) = binding.source.rsplit_once('.')
            {
                self.lose(source, &binding.connector);
            }
        }
    }

    /// A connector of this component lost its other end, and nobody ordered that.
    pub fn lose(&self, instance: &str, connector: &str) {
        if !self.is_stopping()
            && let Ok(component) = self.component(instance)
        {
            component.lose(connector);
        }
    }

    /// Looks once a second for what does not come to an end by itself.
    pub fn watch(&self) {
        for component in self.components() {
            component.look_after_loss(&self.events);
        }
    }

    /// Waits until the good-byes of outgoing connections have left, or the deadline.
    pub fn wait_for_good_byes(&self, deadline: Instant) {
        self.outgoing.wait(deadline);
    }
}
