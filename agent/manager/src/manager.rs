//! What a manager holds. Its locks are held for look-ups only, never while a component or a peer is waited for.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use rts_manager_api::control::{Failure, Hello};

use crate::component::Component;
use crate::data::binding::Bindings;
use crate::events::Events;
use crate::failure::{conflict, list, not_found};
use crate::module::Module;
use crate::pool::Pool;
use crate::slots::Slots;
use crate::sync::lock;

/// Components of one manager that may exist at once.
const MAX_COMPONENTS: usize = 4096;
/// Outgoing data connections, a thread each.
const MAX_DATA: usize = 1024;
/// Requests that may be under way at once.
const MAX_REQUESTS: usize = 64;

/// The manager.
pub struct Manager {
    /// What it answers to a greeting.
    pub hello: Hello,
    /// Modules that are open, by type.
    pub modules: Mutex<BTreeMap<String, Arc<Module>>>,
    /// Held while a module is opened: one at a time.
    pub loading: Mutex<()>,
    /// In-port ends.
    pub bindings: Bindings,
    /// The way out for events.
    pub events: Events,
    /// Outgoing data connections.
    pub outgoing: Slots,
    /// Threads for requests.
    pub pool: Pool,
    components: Mutex<BTreeMap<String, Arc<Component>>>,
    stopping: AtomicBool,
}

impl Manager {
    /// An empty manager.
    pub fn new(hello: Hello) -> Self {
        Self {
            hello,
            modules: Mutex::default(),
            loading: Mutex::default(),
            bindings: Bindings::default(),
            events: Events::default(),
            outgoing: Slots::new(MAX_DATA),
            pool: Pool::new(MAX_REQUESTS),
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
        if self.stopping.load(Ordering::Acquire) {
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
        components.insert(name.clone(), Arc::clone(component));
        Ok(())
    }

    /// Forgets a component that has ended.
    pub fn remove_component(&self, component: &Arc<Component>) {
        self.detach(component);
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
    pub fn detach(&self, component: &Component) {
        component.leave();
        for connector in component.take_connectors(|_| true) {
            connector.close();
        }
        for end in self.bindings.remove_of(&component.identity.incarnation) {
            self.close_end(&end);
        }
    }

    /// Closes an in-port end. A source in this process has no connection that would break, so its end is told here.
    pub fn close_end(&self, end: &crate::data::binding::End) {
        if end.close() {
            self.events.changed(
                format!("connector/{}", end.binding.connector),
                format!(
                    "its target {}.{} has gone",
                    end.binding.instance, end.binding.port
                ),
            );
        }
    }
}
