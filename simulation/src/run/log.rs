//! What the programs log, with the time of the run.

use std::fmt::{Debug, Write};
use std::sync::atomic::{AtomicU64, Ordering};

use tokio::time::Instant;
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record};
use tracing::subscriber::DefaultGuard;
use tracing::{Event, Level, Metadata, Subscriber};

use crate::trace::Trace;

/// Writes what is logged in this thread into a trace until the guard is dropped.
pub(super) fn begin(trace: &Trace) -> DefaultGuard {
    tracing::subscriber::set_default(Log {
        trace: trace.clone(),
        begin: Instant::now(),
        spans: AtomicU64::new(1),
    })
}

struct Log {
    trace: Trace,
    begin: Instant,
    spans: AtomicU64,
}

#[derive(Default)]
struct Words(String);

impl Visit for Words {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        // A string takes all.
        let _ = match field.name() {
            "message" => write!(self.0, " {value:?}"),
            name => write!(self.0, " {name}={value:?}"),
        };
    }
}

impl Subscriber for Log {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        *metadata.level() <= Level::INFO && metadata.target().starts_with("rts")
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(self.spans.fetch_add(1, Ordering::Relaxed))
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, event: &Event<'_>) {
        let mut words = Words::default();
        event.record(&mut words);
        let metadata = event.metadata();
        let line = format!("  [{} {}]{}", metadata.level(), metadata.target(), words.0);
        self.trace.write(self.begin.elapsed(), &line);
    }

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}
