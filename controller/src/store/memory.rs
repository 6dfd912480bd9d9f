//! A store in memory, for tests and simulations. Clones share their contents, so a "restart" can be played.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use futures_util::future::BoxFuture;

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

    /// Everything in it.
    pub fn held(&self) -> State {
        self.state().clone()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Store for MemoryStore {
    fn load(&self) -> BoxFuture<'_, Result<State, StoreError>> {
        Box::pin(async { Ok(self.held()) })
    }

    fn write(&self, writes: Vec<Write>) -> BoxFuture<'_, Result<(), StoreError>> {
        Box::pin(async {
            let mut state = self.state();
            for write in writes {
                state.change(write);
            }
            Ok(())
        })
    }
}
