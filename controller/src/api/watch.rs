//! Watching a kind by server-sent events.
//!
//! A reader has no queue of its own: it walks along the view's ring, and is cut off when the ring overtakes it.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use rts_controller_api::Problem;
use rts_controller_api::objects::Kind;
use rts_controller_api::watch::{WatchEvent, WatchType};
use tokio::sync::{OwnedSemaphorePermit, watch as signal};
use tokio::time::{Instant, Interval};

use super::{Answer, App};
use crate::core::Core;
use crate::view::Change;

/// Time between bookmarks.
const BOOKMARK: Duration = Duration::from_secs(10);
/// Time of silence after which a comment is sent.
const KEEP_ALIVE: Duration = Duration::from_secs(5);

struct Reader {
    core: Arc<Core>,
    kind: Kind,
    /// Everything up to this version was sent, or is pending.
    after: u64,
    pending: VecDeque<Arc<Change>>,
    /// What is pending are the objects as they were when the watch began. They are not in the order of their versions,
    /// so only the bookmark after the last of them says from where to go on.
    snapshot: bool,
    /// Objects are sent with their spec.
    with_spec: bool,
    latest: signal::Receiver<u64>,
    ending: signal::Receiver<bool>,
    bookmark: Interval,
    _permit: OwnedSemaphorePermit,
}

/// Answers with a stream that begins after a version, or with all objects as they are; with their spec or without.
pub fn watch(app: &App, kind: Kind, from: Option<u64>, with_spec: bool) -> Answer<Response> {
    let permit = permit(app)?;
    let latest = app.core.view.subscribe();
    let (pending, after) = match from {
        Some(version) => app.core.view.changes(kind, version)?,
        None => app.core.view.snapshot(kind),
    };
    let reader = Reader {
        core: Arc::clone(&app.core),
        kind,
        after,
        pending: pending.into(),
        snapshot: from.is_none(),
        with_spec,
        latest,
        ending: app.ending.clone(),
        bookmark: tokio::time::interval_at(Instant::now() + BOOKMARK, BOOKMARK),
        _permit: permit,
    };
    let events = stream::unfold(reader, |mut reader| async move {
        let event = reader.next().await?;
        Some((Ok::<_, Infallible>(event), reader))
    });
    let keep_alive = KeepAlive::new().interval(KEEP_ALIVE);
    Ok(Sse::new(events).keep_alive(keep_alive).into_response())
}

/// Room for one more stream that has no end of its own.
pub fn permit(app: &App) -> Result<OwnedSemaphorePermit, Problem> {
    Arc::clone(&app.watches)
        .try_acquire_owned()
        .map_err(|_| Problem::unavailable("too-many-watches", "too many watches are open"))
}

impl Reader {
    /// The next event; none when the program ends or the reader is too slow.
    async fn next(&mut self) -> Option<Event> {
        loop {
            if let Some(change) = self.pending.pop_front() {
                let event = match self.snapshot {
                    true => Event::default(),
                    false => Event::default().id(change.revision.to_string()),
                };
                return Some(event.data(change.json(self.with_spec)));
            }
            if std::mem::take(&mut self.snapshot) {
                return self.mark();
            }
            let (changes, after) = self.core.view.changes(self.kind, self.after).ok()?;
            self.after = after;
            self.pending.extend(changes);
            if !self.pending.is_empty() {
                continue;
            }
            let mark = tokio::select! {
                changed = self.latest.changed() => {
                    changed.ok()?;
                    false
                }
                _ = self.bookmark.tick() => true,
                _ = self.ending.wait_for(|ending| *ending) => return None,
            };
            if mark {
                return self.mark();
            }
        }
    }

    fn mark(&self) -> Option<Event> {
        let mark = WatchEvent::<()> {
            kind: WatchType::Bookmark,
            resource_version: self.after.to_string(),
            object: None,
        };
        let json = serde_json::to_string(&mark).ok()?;
        Some(Event::default().id(self.after.to_string()).data(json))
    }
}
