//! A change of a system: it counts at once, and is made durable while the loop carries it out. Nobody is told of it before
//! that; a change that cannot be stored is taken back, and the same loop undoes what was begun of it.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use rts_host::timing::TARGET;
use tracing::{Instrument, info_span};

use crate::core::Core;
use crate::node_numbers::{self, Numbers};
use crate::store::{Restored, StoreError, SystemRecord, Write};
use crate::view::Happening;

/// What is written with a change.
struct Change {
    record: Arc<SystemRecord>,
    /// What was stored before.
    before: Option<Arc<SystemRecord>>,
    said: Option<Restored>,
    /// The first numbers of nodes: they count once they are durable.
    firsts: Numbers,
    /// Numbers that may be sent at once.
    numbers: Numbers,
}

impl Core {
    /// Stores a change of a system under a new index; durable, and known to all, when it returns with the index. After an
    /// error nothing is changed, or what was begun is being undone. The caller holds [`Core::admission`], and must not be
    /// dropped before.
    pub async fn store_change(&self, mut record: SystemRecord) -> Result<u64, StoreError> {
        let indexes = self.number(&mut record);
        let index = record.index;
        let lags = self.may_lag(&record);
        let change = self.begin(Arc::new(record), lags);
        let mut writes = vec![indexes];
        writes.push(Write::PutSystem(Arc::clone(&change.record)));
        writes.extend(change.said.clone().map(|said| Write::Restored(Some(said))));
        writes.extend(node_numbers::writes(&change.firsts));
        writes.extend(node_numbers::writes(&change.numbers));
        let of = format!("system/{}", change.record.name());
        let span = info_span!(target: TARGET, "store", of);
        let stored = self.store.write(writes).instrument(span).await;
        self.store_failed.store(stored.is_err(), Ordering::Relaxed);
        match stored {
            Ok(()) => {
                self.settle(change);
                if lags {
                    // The loop is at it already, and need not begin again.
                    self.publish();
                    self.wake.notify_one();
                } else {
                    self.desired_changed();
                }
                Ok(index)
            }
            Err(e) => {
                if lags {
                    self.take_back(change, &e);
                }
                Err(e)
            }
        }
    }

    /// Waits until the last change of a system is durable, or was taken back.
    pub async fn durable(&self, name: &str) {
        let mut settled = self.settled.subscribe();
        while self.registry().pending.contains(name) && settled.changed().await.is_ok() {}
    }

    /// True for a change that may count before it is durable: the store works and was not put back, and nothing is moved
    /// away from a node, which must not forget that.
    fn may_lag(&self, record: &SystemRecord) -> bool {
        let registry = self.registry();
        let before = registry.systems.get(record.name());
        let stays = before.map_or(record.left.is_empty(), |before| before.left == record.left);
        stays && registry.restored.is_none() && !self.store_failed.load(Ordering::Relaxed)
    }

    /// Gives the nodes that are told of a change their numbers; it counts when it `lags`.
    fn begin(&self, record: Arc<SystemRecord>, lags: bool) -> Change {
        let name = record.name().to_owned();
        let said = self.said(&name);
        let placed = self.place_with(Arc::clone(&record));
        let mut registry = self.registry();
        let before = registry.systems.get(&name).cloned();
        let all = self.next_numbers(&registry, &placed);
        let known = |node: &String| registry.nodes.contains_key(node);
        let (numbers, firsts) = all.into_iter().partition(|(node, _)| known(node));
        let mut change = Change {
            record,
            before,
            said,
            firsts,
            numbers,
        };
        if lags {
            registry.number_ahead(&change.numbers);
            registry.pending.insert(name.clone());
            registry.systems.insert(name, Arc::clone(&change.record));
            drop(registry);
            self.desired_changed();
        } else {
            // The loop gives them.
            change.numbers.clear();
            change.firsts.clear();
        }
        change
    }

    /// A change is durable.
    fn settle(&self, change: Change) {
        let name = change.record.name().to_owned();
        let mut registry = self.registry();
        registry.pending.remove(&name);
        registry.systems.insert(name, change.record);
        registry.numbered(&change.firsts);
        registry.numbered(&change.numbers);
        if change.said.is_some() {
            registry.restored = change.said;
        }
        drop(registry);
        self.settled.send_modify(|n| *n = n.wrapping_add(1));
    }

    /// A change counted, and cannot be stored: what was desired before is desired again.
    fn take_back(&self, change: Change, error: &StoreError) {
        let name = change.record.name().to_owned();
        let mut registry = self.registry();
        registry.pending.remove(&name);
        match change.before {
            Some(mut before) => {
                // What was begun there is to be undone there.
                let nodes = change.record.nodes.iter().cloned();
                Arc::make_mut(&mut before).nodes.extend(nodes);
                registry.systems.insert(name.clone(), before);
            }
            None => drop(registry.systems.remove(&name)),
        }
        drop(registry);
        let message = format!("what was begun of a change is undone: {error}");
        let event = Happening::warning("TakenBack", &format!("system/{name}"), message);
        self.record(event.of(Some(&name)));
        self.settled.send_modify(|n| *n = n.wrapping_add(1));
        self.desired_changed();
    }
}
