//! A store in memory, for tests and simulations. Clones share their contents, so a "restart" can be played.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::{State, Store, StoreError, Write};

/// The store.
#[derive(Debug, Clone, Default)]
pub struct MemoryStore {
    state: Arc<Mutex<State>>,
}

impl MemoryStore {
    /// An empty store.
    pub fn new(cluster_uid: impl Into<String>) -> Self {
        Self::holding(State {
            cluster_uid: cluster_uid.into(),
            epoch: 1,
            ..State::default()
        })
    }

    /// A store that holds this.
    pub fn holding(state: State) -> Self {
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

    fn write(&self, writes: &[Write]) -> Result<(), StoreError> {
        let mut state = self.state();
        for write in writes {
            state.change(write.clone());
        }
        Ok(())
    }
}
