//! The controller's store: writes are whole or not at all, and may fail, be slow, or be overtaken by a crash.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use futures_util::future::BoxFuture;
use jiff::Timestamp;
use rts_controller::store::{State, Store, StoreError, SystemRecord, Write};
use tokio::time::sleep;

use crate::life::Life;
use crate::seed::{Seed, Stream};

/// Usual time of a write, in microseconds.
const USUAL: (u64, u64) = (100, 2000);
/// States that are kept for backups.
const KEPT: usize = 64;

/// The store's disk. Clones are the same.
#[derive(Clone)]
pub struct SimStore(Arc<Inner>);

struct Inner {
    contents: Mutex<Contents>,
    stream: Stream,
    taken_in: OnceLock<TakenIn>,
}

/// Told of each system that was taken in from a node's ledger.
pub type TakenIn = Box<dyn Fn(&SystemRecord) + Send + Sync>;

struct Contents {
    state: State,
    /// States of before, the oldest first.
    before: Vec<State>,
    fails: u32,
    /// Longest additional time of a write.
    slow: Vec<Duration>,
    writes: u64,
    failed: u64,
}

impl SimStore {
    /// An empty store.
    pub fn new(seed: Seed, cluster_uid: &str) -> Self {
        let state = State {
            cluster_uid: cluster_uid.to_owned(),
            epoch: 1,
            ..State::default()
        };
        Self::holding(state, seed.stream("store"))
    }

    fn holding(state: State, stream: Stream) -> Self {
        let contents = Contents {
            state,
            before: Vec::new(),
            fails: 0,
            slow: Vec::new(),
            writes: 0,
            failed: 0,
        };
        Self(Arc::new(Inner {
            contents: Mutex::new(contents),
            stream,
            taken_in: OnceLock::new(),
        }))
    }

    /// The store in the hands of a program.
    pub fn grip(&self, life: &Life) -> Grip {
        Grip {
            store: self.clone(),
            life: life.clone(),
        }
    }

    /// Tells of systems that are taken in from ledgers from now on.
    pub fn tell(&self, taken_in: TakenIn) {
        // Only the first one hears of it.
        let _ = self.0.taken_in.set(taken_in);
    }

    /// What is in it.
    pub fn state(&self) -> State {
        self.contents().state.clone()
    }

    /// Writes and failed writes so far.
    pub fn counts(&self) -> (u64, u64) {
        let contents = self.contents();
        (contents.writes, contents.failed)
    }

    /// Writes fail from now on, or one reason less for it.
    pub fn fail(&self, fails: bool) {
        let fails_now = &mut self.contents().fails;
        *fails_now = if fails {
            *fails_now + 1
        } else {
            fails_now.saturating_sub(1)
        };
    }

    /// Writes take up to so much longer.
    pub fn slow(&self, delay: Duration) {
        self.contents().slow.push(delay);
    }

    /// They no longer do.
    pub fn quick(&self, delay: Duration) {
        let slow = &mut self.contents().slow;
        if let Some(at) = slow.iter().position(|d| *d == delay) {
            slow.remove(at);
        }
    }

    /// A new store from a backup that was made `ago` writes before the last one, as `rtsctl controller restore` makes it.
    pub fn restored(&self, seed: Seed, ago: usize, take_over: bool, now: Timestamp) -> Self {
        let contents = self.contents();
        let at = contents.before.len().checked_sub(ago.max(1));
        let backup = at.and_then(|at| contents.before.get(at));
        let mut state = backup.unwrap_or(&contents.state).clone();
        let old = &contents.state;
        state.epoch = state.epoch.max(old.epoch).saturating_add(1);
        // Well above all that was given out: the real one takes a number by the time.
        state.revisions = state.revisions.max(old.revisions) + (1 << 30);
        state.indexes = state.indexes.max(old.indexes) + 1000;
        state.restore(now, take_over, old.nodes.keys().cloned());
        let name = format!("store/{}", state.epoch);
        Self::holding(state, seed.stream(&name))
    }

    fn contents(&self) -> MutexGuard<'_, Contents> {
        self.0
            .contents
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// The disk is asked: it takes its time, and says whether it works.
    async fn wait(&self) {
        let slow = self.contents().slow.iter().max().copied();
        let usual = self.0.stream.between(USUAL.0, USUAL.1);
        let slow = slow.map_or(0, |slow| u64::try_from(slow.as_micros()).unwrap_or(0));
        let more = self.0.stream.between(0, 1000) * slow / 1000;
        sleep(Duration::from_micros(usual + more)).await;
    }

    fn write_now(&self, writes: Vec<Write>) -> Result<(), StoreError> {
        let contents = &mut *self.contents();
        contents.writes += 1;
        if contents.fails > 0 {
            contents.failed += 1;
            let path = "controller.redb".into();
            return Err(StoreError::Full { path });
        }
        // A user's change is of a system alone, what is taken in comes with the node's generation.
        let takes_in = writes
            .iter()
            .any(|write| matches!(write, Write::PutNode(..)));
        for write in writes.iter().filter(|_| takes_in) {
            if let (Write::PutSystem(record), Some(tell)) = (write, self.0.taken_in.get()) {
                tell(record);
            }
        }
        let before = contents.state.clone();
        for write in writes {
            contents.state.change(write);
        }
        if contents.before.len() >= KEPT {
            contents.before.remove(0);
        }
        contents.before.push(before);
        Ok(())
    }
}

/// A store in the hands of a program, whose crash may come before a write has its effect, or after.
pub struct Grip {
    store: SimStore,
    life: Life,
}

impl Store for Grip {
    fn check(&self) -> BoxFuture<'_, Result<(), StoreError>> {
        Box::pin(self.life.call(async {
            self.store.wait().await;
            self.store.write_now(Vec::new())
        }))
    }

    fn load(&self) -> BoxFuture<'_, Result<State, StoreError>> {
        Box::pin(self.life.call(async {
            self.store.wait().await;
            Ok(self.store.state())
        }))
    }

    fn write(&self, writes: Vec<Write>) -> BoxFuture<'_, Result<(), StoreError>> {
        Box::pin(async {
            self.life.call(self.store.wait()).await;
            // The effect is in a call of its own: a crash comes before it, or after it and before the program knows.
            let write = async { self.store.write_now(writes) };
            self.life.call(write).await
        })
    }
}

#[cfg(test)]
mod tests {
    use tokio::time::timeout;

    use super::*;

    fn epoch(epoch: u64) -> Vec<Write> {
        vec![Write::Epoch(epoch)]
    }

    #[tokio::test(start_paused = true)]
    async fn a_write_that_fails_changes_nothing() {
        let store = SimStore::new(Seed(1), "c");
        let grip = store.grip(&Life::new("controller", 1));
        grip.write(epoch(2)).await.unwrap();
        store.fail(true);
        assert!(grip.write(epoch(3)).await.is_err());
        store.fail(false);
        assert_eq!(grip.load().await.unwrap().epoch, 2);
    }

    #[tokio::test(start_paused = true)]
    async fn a_crash_comes_before_a_write_or_after_it() {
        for (calls, after) in [(1, 1), (2, 1), (3, 1), (4, 2)] {
            let store = SimStore::new(Seed(1), "c");
            let life = Life::new("controller", 1);
            life.burn(calls);
            let grip = store.grip(&life);
            let write = grip.write(epoch(2));
            assert!(timeout(Duration::from_secs(9), write).await.is_err());
            assert_eq!(store.state().epoch, after, "{calls}");
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_restored_store_is_of_before_and_has_a_higher_epoch() {
        let store = SimStore::new(Seed(1), "c");
        let grip = store.grip(&Life::new("controller", 1));
        for index in 1..4 {
            grip.write(vec![Write::Indexes(index)]).await.unwrap();
        }
        let restored = store
            .restored(Seed(1), 2, true, Timestamp::UNIX_EPOCH)
            .state();
        assert_eq!((restored.epoch, restored.indexes), (2, 1003));
        assert!(restored.restored.unwrap().take_over);
        assert_eq!(store.state().epoch, 1);
    }
}
