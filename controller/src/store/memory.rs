//! A store in memory, for tests and simulations. Clones share their contents, so a "restart" can be played.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{NodeGeneration, State, Store, StoreError, SystemRecord};

/// The store.
#[derive(Debug, Clone, Default)]
pub struct MemoryStore {
    state: Arc<Mutex<State>>,
}

impl MemoryStore {
    /// An empty store.
    pub fn new(cluster_uid: impl Into<String>) -> Self {
        let state = State {
            cluster_uid: cluster_uid.into(),
            epoch: 1,
            ..State::default()
        };
        Self {
            state: Arc::new(Mutex::new(state)),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Store for MemoryStore {
    fn load(&self) -> Result<State, StoreError> {
        Ok(self.state().clone())
    }

    fn put_system(&self, record: &SystemRecord) -> Result<(), StoreError> {
        let name = record.name().to_owned();
        self.state().systems.insert(name, record.clone());
        Ok(())
    }

    fn remove_system(&self, name: &str) -> Result<(), StoreError> {
        self.state().systems.remove(name);
        Ok(())
    }

    fn put_node(&self, node: &str, generation: &NodeGeneration) -> Result<(), StoreError> {
        self.state()
            .nodes
            .insert(node.to_owned(), generation.clone());
        Ok(())
    }

    fn reserve_revisions(&self, up_to: u64) -> Result<(), StoreError> {
        let mut state = self.state();
        state.revisions = state.revisions.max(up_to);
        Ok(())
    }
}
