//! Objects of all kinds as clients see them, each published with a revision, and the feed of their changes.
//!
//! Nothing here decides anything: [`crate::publish`] makes the objects.

mod change;
mod events;
mod resource;
mod ring;
mod weight;

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rts_controller_api::objects::{
    Component, Connector, Event, Kind, List, ListMetadata, Manager, Metadata, Node, System,
};
use rts_controller_api::watch::WatchType;
use rts_controller_api::{API_VERSION, Problem};
use tokio::sync::watch;

use self::change::Shown;
pub use self::change::{Change, State};
pub use self::events::Happening;
pub use self::resource::{Resource, key};
pub use self::ring::Ring;
use self::weight::Weigh;

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
    systems: Table<System>,
    nodes: Table<Node>,
    components: Table<Component>,
    connectors: Table<Connector>,
    managers: Table<Manager>,
}

/// Objects of a kind by their keys, shared with the changes that made them.
pub type Table<T> = BTreeMap<String, Arc<T>>;

struct Inner {
    revision: u64,
    tables: Tables,
    events: VecDeque<Arc<Event>>,
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
        for object in objects {
            let key = object.key();
            let before = old.remove(&key);
            new.insert(key, inner.settle(before, object));
        }
        for (_, gone) in old {
            inner.gone(gone);
        }
        *T::table(&mut inner.tables) = new;
        self.tell(&inner);
    }

    /// Puts these objects in the place of those with the same keys; those that are `gone` are taken away.
    pub fn patch<T: Resource>(
        &self,
        objects: impl IntoIterator<Item = T>,
        gone: impl IntoIterator<Item = String>,
    ) {
        let mut inner = self.inner();
        for object in objects {
            let key = object.key();
            let before = T::table(&mut inner.tables).remove(&key);
            let object = inner.settle(before, object);
            T::table(&mut inner.tables).insert(key, object);
        }
        for key in gone {
            if let Some(gone) = T::table(&mut inner.tables).remove(&key) {
                inner.gone(gone);
            }
        }
        self.tell(&inner);
    }

    /// All objects of a kind, sorted by name.
    pub fn list<T: Resource>(&self) -> List<T> {
        let List {
            api_version,
            kind,
            metadata,
            items,
        } = self.shared::<T>();
        List {
            api_version,
            kind,
            metadata,
            items: items.into_iter().map(Arc::unwrap_or_clone).collect(),
        }
    }

    /// The same, and nothing is copied for it.
    pub fn shared<T: Resource>(&self) -> List<Arc<T>> {
        let mut inner = self.inner();
        let items = T::table(&mut inner.tables).values().cloned().collect();
        inner.list(items)
    }

    /// One object by its key ([`Resource::key`]).
    pub fn get<T: Resource>(&self, key: &str) -> Option<T> {
        let mut inner = self.inner();
        let found = T::table(&mut inner.tables).get(key);
        found.map(|object| T::clone(object))
    }

    /// Appends to the event log.
    pub fn record(&self, happening: Happening, now: jiff::Timestamp) {
        let mut inner = self.inner();
        inner.revision += 1;
        let event = Arc::new(happening.into_event(inner.revision, now));
        let weight = event.weight(None);
        inner.push(
            Kind::Event,
            WatchType::Added,
            Arc::clone(&event) as _,
            weight,
        );
        inner.events.push_back(event);
        if inner.events.len() > EVENTS {
            inner.events.pop_front();
        }
        self.tell(&inner);
    }

    /// The event log, oldest first.
    pub fn events(&self) -> List<Event> {
        let inner = self.inner();
        inner.list(
            inner
                .events
                .iter()
                .map(|event| Event::clone(event))
                .collect(),
        )
    }

    /// The same, and nothing is copied for it.
    pub fn shared_events(&self) -> List<Arc<Event>> {
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
        fn added<T: Shown + 'static>(
            kind: Kind,
            list: Vec<Arc<T>>,
            metadata: impl Fn(&T) -> &Metadata,
        ) -> Vec<Arc<Change>> {
            let change = |object: Arc<T>| {
                let version = metadata(&object).resource_version.parse().unwrap_or(0);
                Arc::new(Change::of(WatchType::Added, version, kind, object, 0))
            };
            list.into_iter().map(change).collect()
        }
        fn all<T: Resource>(view: &View) -> Vec<Arc<Change>> {
            added(T::KIND, view.shared::<T>().items, T::metadata)
        }
        let version = self.revision();
        let changes = match kind {
            Kind::System => all::<System>(self),
            Kind::Node => all::<Node>(self),
            Kind::Component => all::<Component>(self),
            Kind::Connector => all::<Connector>(self),
            Kind::Manager => all::<Manager>(self),
            Kind::Event => added(Kind::Event, self.shared_events().items, |event: &Event| {
                &event.metadata
            }),
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
    fn settle<T: Resource>(&mut self, before: Option<Arc<T>>, mut object: T) -> Arc<T> {
        let kind = match &before {
            None => WatchType::Added,
            Some(before) => {
                before
                    .metadata()
                    .resource_version
                    .clone_into(&mut object.metadata_mut().resource_version);
                if before.is_same(&object) {
                    return Arc::new(object);
                }
                WatchType::Modified
            }
        };
        self.revision += 1;
        object.metadata_mut().resource_version = self.revision.to_string();
        let weight = object.weight(before.as_deref());
        let object = Arc::new(object);
        self.push(T::KIND, kind, Arc::clone(&object) as _, weight);
        object
    }

    fn gone<T: Resource>(&mut self, gone: Arc<T>) {
        self.revision += 1;
        let weight = gone.weight(Some(&gone));
        let mut object = Arc::unwrap_or_clone(gone);
        object.metadata_mut().resource_version = self.revision.to_string();
        self.push(T::KIND, WatchType::Deleted, Arc::new(object), weight);
    }

    fn push(&mut self, kind: Kind, what: WatchType, object: Arc<dyn Shown>, weight: usize) {
        let change = Change::of(what, self.revision, kind, object, weight);
        self.ring.push(Arc::new(change));
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

#[cfg(test)]
mod tests;
