//! Controllers with other stores.

use std::time::Duration;

use jiff::Timestamp;
use rts_controller::store::{MemoryStore, State};

use super::Cluster;

/// A controller with this store meets the agents that are there.
pub fn meets(old: Cluster, store: MemoryStore) -> Cluster {
    let fleet = old.fleet.clone();
    drop(old);
    let mut cluster = Cluster::start(fleet, store);
    cluster.join("local", "next");
    cluster
}

/// As `restore` leaves a store.
pub fn restored(mut state: State, epoch: u64, take_over: bool) -> MemoryStore {
    state.epoch = epoch;
    state.restore(Timestamp::UNIX_EPOCH, take_over, []);
    MemoryStore::holding(state)
}

/// Waits, in the test's time.
pub async fn until(what: impl Fn() -> bool) {
    let wait = async {
        while !what() {
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    let waited = tokio::time::timeout(Duration::from_secs(60), wait).await;
    waited.expect("it never came to that");
}
