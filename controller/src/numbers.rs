//! Numbers that the store gives out, each once: indexes of changes, and revisions.

use std::sync::atomic::Ordering;

use crate::core::{Core, REVISIONS};
use crate::store::{Restored, StoreError, SystemRecord, Write};

impl Core {
    /// Gives a system that is to be changed its index, and what is to be written with it. The caller holds
    /// [`Core::admission`].
    pub fn number(&self, record: &mut SystemRecord) -> Write {
        let last = self.indexes.fetch_add(1, Ordering::Relaxed);
        record.index = last.saturating_add(1);
        Write::Indexes(record.index)
    }

    /// A user said what is stored already: since a restore that is more than the backup's word. The caller holds
    /// [`Core::admission`].
    pub async fn confirm(&self, name: &str) -> Result<(), StoreError> {
        let Some(said) = self.said(name) else {
            return Ok(());
        };
        let write = Write::Restored(Some(said.clone()));
        self.store.write(vec![write]).await?;
        self.registry().restored = Some(said);
        Ok(())
    }

    /// What a restored store remembers of itself once a user has spoken of this system; none when that is so already.
    pub(crate) fn said(&self, name: &str) -> Option<Restored> {
        let mut restored = self.registry().restored.clone()?;
        restored.said.insert(name.to_owned()).then_some(restored)
    }

    /// Reserves revisions before they run out.
    pub async fn reserve_revisions(&self) {
        let reserved = self.reserved.load(Ordering::Relaxed);
        let revision = self.view.revision();
        if revision + REVISIONS / 2 < reserved {
            return;
        }
        match self.store.reserve_revisions(revision + REVISIONS).await {
            Ok(()) => self.reserved.store(revision + REVISIONS, Ordering::Relaxed),
            Err(e) => {
                tracing::error!(error = %rts_host::error::chain(&e), "revisions cannot be reserved");
            }
        }
    }
}
