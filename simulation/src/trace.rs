//! All that happened in a run, as text: to be read, and to be compared with that of another run.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::truth::{Happened, Subject, Witness};

/// What was written down. Clones are the same.
#[derive(Clone, Default)]
pub struct Trace(Arc<Mutex<Inner>>);

#[derive(Default)]
struct Inner {
    lines: u64,
    hash: DefaultHasher,
    /// Kept lines; none are kept where only the hash is wanted.
    text: Option<Vec<String>>,
}

impl Trace {
    /// One that keeps its lines.
    pub fn kept() -> Self {
        let trace = Self::default();
        trace.lock().text = Some(Vec::new());
        trace
    }

    /// Writes a line.
    pub fn write(&self, at: Duration, words: &str) {
        let mut inner = self.lock();
        inner.lines += 1;
        (at, words).hash(&mut inner.hash);
        if let Some(text) = &mut inner.text {
            text.push(format!("{:>11.6} {words}", at.as_secs_f64()));
        }
    }

    /// Lines so far.
    pub fn lines(&self) -> u64 {
        self.lock().lines
    }

    /// Names the whole text.
    pub fn hash(&self) -> u64 {
        self.lock().hash.clone().finish()
    }

    /// The text, as far as it is kept.
    pub fn text(&self) -> Vec<String> {
        self.lock().text.clone().unwrap_or_default()
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Witness for Trace {
    fn see(&mut self, at: Duration, what: &Happened) {
        self.write(at, &words(what));
    }
}

fn who(subject: &Subject) -> String {
    let Subject {
        node,
        manager,
        instance,
        incarnation,
        ..
    } = subject;
    let short = incarnation.get(..8).unwrap_or(incarnation);
    format!("{node} {}/{instance} ({short})", manager.display_name())
}

/// What happened, in a line.
pub fn words(what: &Happened) -> String {
    match what {
        Happened::ProcessStarted {
            node,
            manager,
            process,
        } => {
            format!(
                "{node} process of {} started ({})",
                manager.display_name(),
                short(process)
            )
        }
        Happened::ProcessEnded {
            node,
            manager,
            process,
            cause,
        } => {
            let name = manager.display_name();
            format!(
                "{node} process of {name} ended ({}): {cause:?}",
                short(process)
            )
        }
        Happened::Created(of) => format!("{} created", who(of)),
        Happened::Deleted(of, cause) => format!("{} deleted: {cause:?}", who(of)),
        Happened::State {
            of,
            from,
            to,
            cause,
        } => {
            format!("{} {from} to {to}: {cause:?}", who(of))
        }
        Happened::Connected { of, connector } => format!("{} connected {connector}", who(of)),
        Happened::Disconnected {
            of,
            connector,
            cause,
        } => {
            format!("{} disconnected {connector}: {cause:?}", who(of))
        }
        Happened::Blemished {
            node,
            process,
            instance,
            what,
        } => {
            let whom = instance.as_deref().unwrap_or("process");
            format!("{node} {whom} of {} hit: {what}", short(process))
        }
        Happened::LedgerAcked {
            node,
            fence,
            systems,
        } => format!(
            "{node} ledger acknowledged: epoch {} generation {} ({}), {} systems",
            fence.epoch,
            fence.generation,
            short(&fence.digest),
            systems.len()
        ),
        Happened::LedgerRead { node, fence } => match fence {
            Some(fence) => format!(
                "{node} ledger read: epoch {} generation {} ({})",
                fence.epoch,
                fence.generation,
                short(&fence.digest)
            ),
            None => format!("{node} ledger read: none"),
        },
        Happened::StepBegan {
            node,
            epoch,
            generation,
            step,
            ..
        } => {
            format!("{node} step {step} (epoch {epoch} generation {generation})")
        }
        Happened::DesiredAcked { system, generation } => match generation {
            Some(generation) => format!("user: {system} generation {generation} acknowledged"),
            None => format!("user: deletion of {system} acknowledged"),
        },
        Happened::StoreRead { epoch, systems } => {
            format!("controller read its store: epoch {epoch}, {systems:?}")
        }
        Happened::Crashed { host, life } => format!("{host} #{life} crashed"),
        Happened::DidNotStart { host, why } => format!("{host} does not come up: {why}"),
        Happened::Started { host, life } => format!("{host} #{life} started"),
        Happened::Rebooted { node } => format!("{node} lost its power"),
        Happened::Note(words) => words.clone(),
    }
}

fn short(id: &str) -> &str {
    id.get(..8).unwrap_or(id)
}
