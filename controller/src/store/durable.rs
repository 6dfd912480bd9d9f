//! The store as the event loop sees it: one write at a time, on a thread that may block.

use std::sync::Arc;

use tokio::sync::Mutex;

use super::{NodeGeneration, Store, StoreError, SystemRecord};

/// A store whose calls can be awaited.
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
        self.write(|store| store.check()).await
    }

    /// See [`Store::put_system`].
    pub async fn put_system(&self, record: SystemRecord) -> Result<(), StoreError> {
        self.write(move |store| store.put_system(&record)).await
    }

    /// See [`Store::remove_system`].
    pub async fn remove_system(&self, name: String) -> Result<(), StoreError> {
        self.write(move |store| store.remove_system(&name)).await
    }

    /// See [`Store::put_node`].
    pub async fn put_node(
        &self,
        node: String,
        generation: NodeGeneration,
    ) -> Result<(), StoreError> {
        self.write(move |store| store.put_node(&node, &generation))
            .await
    }

    /// See [`Store::reserve_revisions`].
    pub async fn reserve_revisions(&self, up_to: u64) -> Result<(), StoreError> {
        self.write(move |store| store.reserve_revisions(up_to))
            .await
    }

    /// A write that was begun ends even when its caller goes away; the next one waits for it.
    async fn write(
        &self,
        work: impl FnOnce(&dyn Store) -> Result<(), StoreError> + Send + 'static,
    ) -> Result<(), StoreError> {
        let turn = Arc::clone(&self.turn).lock_owned().await;
        let store = Arc::clone(&self.store);
        let done = tokio::task::spawn_blocking(move || {
            let result = work(store.as_ref());
            drop(turn);
            result
        });
        done.await.unwrap_or_else(|e| {
            Err(StoreError::Failed {
                what: "write",
                path: "state/controller.redb".into(),
                source: Box::new(e),
            })
        })
    }
}
