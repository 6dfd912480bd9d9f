//! The store in a file, off the event loop: its calls block, and are made on threads that may.

use std::sync::Arc;

use futures_util::future::BoxFuture;

use super::{RedbStore, State, Store, StoreError, Write};

/// A store whose calls can be awaited. What was begun ends even when its caller goes away.
pub struct OffLoop(Arc<RedbStore>);

impl OffLoop {
    /// Wraps a store.
    pub fn new(store: RedbStore) -> Self {
        Self(Arc::new(store))
    }

    fn call<T: Send + 'static>(
        &self,
        work: impl FnOnce(&RedbStore) -> Result<T, StoreError> + Send + 'static,
    ) -> BoxFuture<'_, Result<T, StoreError>> {
        let store = Arc::clone(&self.0);
        Box::pin(async move {
            let done = tokio::task::spawn_blocking(move || work(&store));
            done.await.unwrap_or_else(|e| Err(StoreError::cut_off(e)))
        })
    }
}

impl Store for OffLoop {
    fn check(&self) -> BoxFuture<'_, Result<(), StoreError>> {
        self.call(RedbStore::check)
    }

    fn load(&self) -> BoxFuture<'_, Result<State, StoreError>> {
        self.call(RedbStore::load)
    }

    fn write(&self, writes: Vec<Write>) -> BoxFuture<'_, Result<(), StoreError>> {
        self.call(move |store| store.write(&writes))
    }
}
