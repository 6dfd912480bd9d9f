//! Where the time goes: spans with the target [`TARGET`] are kept for a while, so that a user can ask for them.
//!
//! A span has the fields `what` and `of`; without `what` its own name says it. Where no [`Recorder`] is installed, as in a
//! simulation, spans cost nothing and are not kept.

use std::collections::VecDeque;
use std::fmt::Debug;
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::{Duration, Instant};

use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id};
use tracing::{Metadata, Subscriber};
use tracing_subscriber::Layer;
use tracing_subscriber::layer::Context;
use tracing_subscriber::registry::LookupSpan;

/// Target of the spans that are kept.
pub const TARGET: &str = "timing";
/// Spans that are kept; of more, the oldest are forgotten.
const MOST: usize = 4096;

/// When the program began to look at the clock.
static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
static KEPT: Mutex<VecDeque<Kept>> = Mutex::new(VecDeque::new());

/// A span that has ended. Times are since the program began.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kept {
    /// What was done.
    pub what: String,
    /// To whom.
    pub of: String,
    /// Spans around it.
    pub depth: u32,
    /// Its start.
    pub start: Duration,
    /// Its end.
    pub end: Duration,
}

/// Time since the program began.
pub fn now() -> Duration {
    BEGIN.elapsed()
}

/// Spans that ended within this time, in the order of their ends.
pub fn within(age: Duration) -> Vec<Kept> {
    let from = now().saturating_sub(age);
    let kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    let recent = kept.iter().rev().take_while(|span| span.end >= from);
    let mut recent: Vec<Kept> = recent.cloned().collect();
    recent.reverse();
    recent
}

/// True for a span that is kept. Logs leave it out: what they say would begin with the names of all spans around it.
pub fn is_kept(metadata: &Metadata<'_>) -> bool {
    metadata.is_span() && metadata.target() == TARGET
}

/// Keeps the spans.
#[derive(Debug, Clone, Copy, Default)]
pub struct Recorder;

/// A span that has not ended.
struct Open {
    words: Words,
    depth: u32,
    start: Duration,
}

#[derive(Default)]
struct Words {
    what: String,
    of: String,
}

impl Visit for Words {
    fn record_str(&mut self, field: &Field, value: &str) {
        match field.name() {
            "what" => self.what = value.to_owned(),
            "of" => self.of = value.to_owned(),
            _ => {}
        }
    }

    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        self.record_str(field, &format!("{value:?}"));
    }
}

impl<S: Subscriber + for<'a> LookupSpan<'a>> Layer<S> for Recorder {
    fn on_new_span(&self, attributes: &Attributes<'_>, id: &Id, context: Context<'_, S>) {
        let Some(span) = context.span(id) else { return };
        let mut words = Words::default();
        attributes.record(&mut words);
        if words.what.is_empty() {
            span.name().clone_into(&mut words.what);
        }
        let open = Open {
            words,
            depth: u32::try_from(span.scope().skip(1).count()).unwrap_or(u32::MAX),
            start: now(),
        };
        span.extensions_mut().insert(open);
    }

    fn on_close(&self, id: Id, context: Context<'_, S>) {
        let open = context.span(&id);
        let open = open.and_then(|span| span.extensions_mut().remove::<Open>());
        let Some(Open {
            words,
            depth,
            start,
        }) = open
        else {
            return;
        };
        let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() >= MOST {
            kept.pop_front();
        }
        kept.push_back(Kept {
            what: words.what,
            of: words.of,
            depth,
            start,
            // Under the lock, so that ends are in order.
            end: now(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracing::info_span;
    use tracing_subscriber::filter::filter_fn;
    use tracing_subscriber::prelude::*;

    #[test]
    fn spans_of_the_target_are_kept_with_what_is_around_them() {
        let recorder = Recorder.with_filter(filter_fn(is_kept));
        let _guard = tracing_subscriber::registry().with(recorder).set_default();
        {
            let _around = info_span!(target: TARGET, "around", of = "system/x").entered();
            let _other = info_span!("other").entered();
            let _within = info_span!(target: TARGET, "step", what = "Create", of = %"a").entered();
        }
        let kept = within(Duration::from_secs(60));
        let words: Vec<_> = kept
            .iter()
            .map(|kept| (kept.what.as_str(), kept.of.as_str(), kept.depth))
            .collect();
        assert_eq!(words, [("Create", "a", 1), ("around", "system/x", 0)]);
        let [inner, outer] = &kept[..] else { panic!() };
        assert!(outer.start <= inner.start && inner.end <= outer.end);
        assert!(inner.end <= now());
    }
}
