//! Objects of all kinds as clients see them, each published with a revision, and the feed of their changes.
//!
//! Nothing here decides anything: [`crate::publish`] makes the objects.

mod events;
mod resource;
mod ring;

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rts_controller_api::objects::{
    Component, Connector, Event, Kind, List, ListMetadata, Manager, Node, System,
};
use rts_controller_api::watch::{WatchEvent, WatchType};
use rts_controller_api::{API_VERSION, Problem};
use tokio::sync::watch;

pub use self::events::Happening;
pub use self::resource::{Resource, key};
pub use self::ring::{Change, Ring};

/// Changes that a watcher can still resume from.
const RING: usize = 4096;
/// Most bytes of these changes.
const RING_BYTES: usize = 64 * 1024 * 1024;
/// Events that are kept.
const EVENTS: usize = 1000;

/// The objects.
pub struct View {
    inner: Mutex<Inner>,
    latest: watch::Sender<u64>,
}

/// Objects by kind and key.
#[derive(Default)]
pub struct Tables {
    systems: BTreeMap<String, System>,
    nodes: BTreeMap<String, Node>,
    components: BTreeMap<String, Component>,
    connectors: BTreeMap<String, Connector>,
    managers: BTreeMap<String, Manager>,
}

struct Inner {
    revision: u64,
    tables: Tables,
    events: VecDeque<Event>,
    ring: Ring,
}

impl View {
    /// An empty view whose first revision is above `start`.
    pub fn new(start: u64) -> Self {
        Self {
            inner: Mutex::new(Inner {
                revision: start,
                tables: Tables::default(),
                events: VecDeque::new(),
                ring: Ring::new(RING, RING_BYTES, start),
            }),
            latest: watch::Sender::new(start),
        }
    }

    /// The newest revision.
    pub fn revision(&self) -> u64 {
        self.inner().revision
    }

    /// Makes these the only objects of their kind. What differs only in counters gets no new version.
    pub fn replace<T: Resource>(&self, objects: impl IntoIterator<Item = T>) {
        let mut inner = self.inner();
        let mut old = std::mem::take(T::table(&mut inner.tables));
        let mut new = BTreeMap::new();
        for mut object in objects {
            let key = object.key();
            let before = old.remove(&key);
            inner.settle(before, &mut object);
            new.insert(key, object);
        }
        for (_, gone) in old {
            inner.gone(gone);
        }
        *T::table(&mut inner.tables) = new;
        self.tell(&inner);
    }

    /// All objects of a kind, sorted by name.
    pub fn list<T: Resource>(&self) -> List<T> {
        let mut inner = self.inner();
        let items = T::table(&mut inner.tables).values().cloned().collect();
        inner.list(items)
    }

    /// One object by its key ([`Resource::key`]).
    pub fn get<T: Resource>(&self, key: &str) -> Option<T> {
        T::table(&mut self.inner().tables).get(key).cloned()
    }

    /// Appends to the event log.
    pub fn record(&self, happening: Happening, now: jiff::Timestamp) {
        let mut inner = self.inner();
        inner.revision += 1;
        let event = happening.into_event(inner.revision, now);
        inner.push(Kind::Event, WatchType::Added, &event);
        inner.events.push_back(event);
        if inner.events.len() > EVENTS {
            inner.events.pop_front();
        }
        self.tell(&inner);
    }

    /// The event log, oldest first.
    pub fn events(&self) -> List<Event> {
        let inner = self.inner();
        inner.list(inner.events.iter().cloned().collect())
    }

    /// Changes of a kind after a version, oldest first, and the version up to which that is all.
    pub fn changes(&self, kind: Kind, after: u64) -> Result<(Vec<Arc<Change>>, u64), Problem> {
        let inner = self.inner();
        let expired = |why: &str| {
            Problem::new(
                410,
                "expired",
                "expired",
                format!("version {after} {why}; list again and watch from the list's version"),
            )
        };
        if after > inner.revision {
            return Err(expired("is newer than this controller's newest"));
        }
        let changes = inner
            .ring
            .after(kind, after)
            .ok_or_else(|| expired("is too old to go on from"))?;
        Ok((changes, inner.revision))
    }

    /// Tells of new revisions.
    pub fn subscribe(&self) -> watch::Receiver<u64> {
        self.latest.subscribe()
    }

    /// The changes that would make the present objects of a kind: what a watch without a version begins with.
    pub fn snapshot(&self, kind: Kind) -> (Vec<Arc<Change>>, u64) {
        fn added<T: Resource>(list: Vec<T>) -> Vec<Arc<Change>> {
            list.iter()
                .map(|object| {
                    let version = object.metadata().resource_version.parse().unwrap_or(0);
                    change(T::KIND, WatchType::Added, version, object)
                })
                .collect()
        }
        let version = self.revision();
        let changes = match kind {
            Kind::System => added(self.list::<System>().items),
            Kind::Node => added(self.list::<Node>().items),
            Kind::Component => added(self.list::<Component>().items),
            Kind::Connector => added(self.list::<Connector>().items),
            Kind::Manager => added(self.list::<Manager>().items),
            Kind::Event => self
                .events()
                .items
                .iter()
                .map(|event| {
                    let version = event.metadata.resource_version.parse().unwrap_or(0);
                    change(Kind::Event, WatchType::Added, version, event)
                })
                .collect(),
        };
        (changes, version)
    }

    fn tell(&self, inner: &Inner) {
        self.latest.send_if_modified(|latest| {
            let newer = inner.revision > *latest;
            *latest = inner.revision;
            newer
        });
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inner {
    /// Gives an object its version: the old one when only counters differ.
    fn settle<T: Resource>(&mut self, before: Option<T>, object: &mut T) {
        let kind = match &before {
            None => WatchType::Added,
            Some(before) => {
                before
                    .metadata()
                    .resource_version
                    .clone_into(&mut object.metadata_mut().resource_version);
                if before.is_same(object) {
                    return;
                }
                WatchType::Modified
            }
        };
        self.revision += 1;
        object.metadata_mut().resource_version = self.revision.to_string();
        self.push(T::KIND, kind, object);
    }

    fn gone<T: Resource>(&mut self, mut object: T) {
        self.revision += 1;
        object.metadata_mut().resource_version = self.revision.to_string();
        self.push(T::KIND, WatchType::Deleted, &object);
    }

    fn push<T: serde::Serialize + Clone>(&mut self, kind: Kind, what: WatchType, object: &T) {
        self.ring.push(change(kind, what, self.revision, object));
    }

    fn list<T>(&self, items: Vec<T>) -> List<T> {
        List {
            api_version: API_VERSION.to_owned(),
            kind: "List".to_owned(),
            metadata: ListMetadata {
                resource_version: self.revision.to_string(),
            },
            items,
        }
    }
}

fn change<T: serde::Serialize + Clone>(
    kind: Kind,
    what: WatchType,
    revision: u64,
    object: &T,
) -> Arc<Change> {
    let event = WatchEvent {
        kind: what,
        resource_version: revision.to_string(),
        object: Some(object.clone()),
    };
    let json = serde_json::to_string(&event).unwrap_or_else(|e| {
        tracing::error!(error = %e, "an object cannot be written as JSON");
        String::from("{}")
    });
    Arc::new(Change {
        revision,
        kind,
        json,
    })
}

#[cfg(test)]
mod tests;
