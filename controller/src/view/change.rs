//! A change of an object: it becomes JSON only when somebody watches.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use rts_controller_api::objects::{Kind, Metadata, Object};
use rts_controller_api::watch::{WatchEvent, WatchType};
use serde::Serialize;

/// JSON that is kept for the next watcher, in bytes; what is larger is written for each. As many changes as are remembered
/// make 64 MiB of it at most.
const KEPT: usize = 16 * 1024;

/// One change.
pub struct Change {
    /// Version after it.
    pub revision: u64,
    /// Kind of the object.
    pub kind: Kind,
    what: WatchType,
    object: Arc<dyn Shown>,
    weight: usize,
    json: OnceLock<String>,
}

/// An object as watchers get it.
pub trait Shown: Send + Sync {
    /// It as a [`WatchEvent`]; without its spec for who asks only for its state.
    fn event(&self, what: WatchType, revision: u64, with_spec: bool) -> String;
}

/// An object without its spec.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct State<'a, Status> {
    api_version: &'a str,
    kind: Kind,
    metadata: &'a Metadata,
    status: &'a Status,
}

impl<'a, Spec, Status> From<&'a Object<Spec, Status>> for State<'a, Status> {
    fn from(object: &'a Object<Spec, Status>) -> Self {
        Self {
            api_version: &object.api_version,
            kind: object.kind,
            metadata: &object.metadata,
            status: &object.status,
        }
    }
}

impl<Spec, Status> Shown for Object<Spec, Status>
where
    Spec: Serialize + Send + Sync,
    Status: Serialize + Send + Sync,
{
    fn event(&self, what: WatchType, revision: u64, with_spec: bool) -> String {
        match with_spec {
            true => written(what, revision, self),
            false => written(what, revision, State::from(self)),
        }
    }
}

impl std::fmt::Debug for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.json(true))
    }
}

impl Change {
    /// A change that made an object this one, which takes about so many bytes that nobody else holds.
    pub fn of(
        what: WatchType,
        revision: u64,
        kind: Kind,
        object: Arc<dyn Shown>,
        weight: usize,
    ) -> Self {
        Self {
            revision,
            kind,
            what,
            object,
            weight,
            json: OnceLock::new(),
        }
    }

    /// Bytes that are held for its sake.
    pub fn weight(&self) -> usize {
        self.weight
    }

    /// It as a [`WatchEvent`], with or without the object's spec.
    pub fn json(&self, with_spec: bool) -> Cow<'_, str> {
        if let Some(json) = self.json.get().filter(|_| with_spec) {
            return Cow::Borrowed(json);
        }
        let json = self.object.event(self.what, self.revision, with_spec);
        if with_spec && json.len() <= KEPT {
            return Cow::Borrowed(self.json.get_or_init(|| json));
        }
        Cow::Owned(json)
    }
}

fn written(what: WatchType, revision: u64, object: impl Serialize) -> String {
    let event = WatchEvent {
        kind: what,
        resource_version: revision.to_string(),
        object: Some(object),
    };
    serde_json::to_string(&event).unwrap_or_else(|e| {
        tracing::error!(error = %e, "an object cannot be written as JSON");
        String::from("{}")
    })
}

#[cfg(test)]
impl Shown for () {
    fn event(&self, _: WatchType, _: u64, _: bool) -> String {
        String::new()
    }
}
