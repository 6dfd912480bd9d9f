//! The store as the controller sees it: one call at a time, in a task of its own.

use std::sync::Arc;

use futures_util::future::BoxFuture;
use tokio::sync::Mutex;

use super::{NodeGeneration, State, Store, StoreError, SystemRecord, Write};

/// A store that is called in turns.
#[derive(Clone)]
pub struct Durable {
    store: Arc<dyn Store>,
    turn: Arc<Mutex<()>>,
}

impl Durable {
    /// Wraps a store.
    pub fn new(store: Arc<dyn Store>) -> Self {
        Self {
            store,
            turn: Arc::new(Mutex::new(())),
        }
    }

    /// See [`Store::check`].
    pub async fn check(&self) -> Result<(), StoreError> {
        self.call(|store| store.check()).await
    }

    /// See [`Store::load`].
    pub async fn load(&self) -> Result<State, StoreError> {
        self.call(|store| store.load()).await
    }

    /// See [`Store::write`].
    pub async fn write(&self, writes: Vec<Write>) -> Result<(), StoreError> {
        self.call(move |store| store.write(writes)).await
    }

    /// Writes a system.
    pub async fn put_system(&self, record: Arc<SystemRecord>) -> Result<(), StoreError> {
        self.write(vec![Write::PutSystem(record)]).await
    }

    /// Forgets a system; no error when it is not there.
    pub async fn remove_system(&self, name: String) -> Result<(), StoreError> {
        self.write(vec![Write::RemoveSystem(name)]).await
    }

    /// Writes a node's generation.
    pub async fn put_node(
        &self,
        node: String,
        generation: NodeGeneration,
    ) -> Result<(), StoreError> {
        self.write(vec![Write::PutNode(node, generation)]).await
    }

    /// Says that revisions up to this one may have been given out.
    pub async fn reserve_revisions(&self, up_to: u64) -> Result<(), StoreError> {
        self.write(vec![Write::Revisions(up_to)]).await
    }

    /// What was begun ends even when its caller goes away; the next one waits for it.
    async fn call<T: Send + 'static>(
        &self,
        work: impl FnOnce(&dyn Store) -> BoxFuture<'_, Result<T, StoreError>> + Send + 'static,
    ) -> Result<T, StoreError> {
        let turn = Arc::clone(&self.turn).lock_owned().await;
        let store = Arc::clone(&self.store);
        let done = tokio::spawn(async move {
            let result = work(store.as_ref()).await;
            drop(turn);
            result
        });
        done.await.unwrap_or_else(|e| Err(StoreError::cut_off(e)))
    }
}
