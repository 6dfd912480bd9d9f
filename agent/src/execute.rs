//! Carrying out a batch: steps start when what they need is done, at most so many at once, all within a deadline.
//!
//! Which step may start is [`queue::Queue`]'s business; what a step does is [`CarryOut`]'s.

pub(crate) mod activate;
mod component;
pub(crate) mod connector;
mod hang;
mod in_vain;
mod manager;
mod module;
mod queue;
mod realtime;
mod stand_in;
mod unbind;
mod verb;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;

use rts_agent_api::messages::{Batch, BatchEvent, GateReport, StepOutcome};
use rts_host::timing::TARGET;
use rts_plan::plan::{Step, StepId};
use tokio::sync::mpsc;
use tokio::task::{Id, JoinSet};
use tokio::time::{Instant, sleep_until, timeout_at};
use tracing::{Instrument, info_span};

use queue::Armed;
#[cfg(test)]
use queue::BatchFault;
pub(crate) use queue::Queue;
pub(crate) use verb::{Hands, StepError, Verb, limit, usual_limit};

use crate::manager_link::GRACE;

/// The future of one step.
pub(crate) type Carrying = Pin<Box<dyn Future<Output = Result<(), StepError>> + Send>>;

/// Carries out single steps.
pub(crate) trait CarryOut: Send + Sync + 'static {
    /// How long a step of this kind may take.
    fn limit(&self, step: &Step) -> Duration;
    /// Carries it out within `limit`; finds what is so already and succeeds.
    fn carry_out(&self, step: Step, limit: Duration) -> Carrying;
    /// A batch begins or ends.
    fn work(&self, _begins: bool) {}
}

/// What a running batch is told.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Word {
    /// News of other nodes' steps.
    Gates(GateReport),
    /// Start nothing more.
    Cancel(String),
}

/// Runs a batch to its end. Each event goes to `tell` as it happens; the last is `End`.
pub(crate) async fn run(
    batch: Batch,
    queue: Queue,
    hands: Arc<dyn CarryOut>,
    words: mpsc::Receiver<Word>,
    tell: impl Fn(BatchEvent) + Send + Sync,
) {
    let end = Instant::now() + Duration::from_millis(batch.deadline_ms);
    let _at_work = AtWork::begin(hands.clone());
    let runner = Runner {
        parallelism: batch.parallelism.max(1) as usize,
        steps: batch.steps.into_iter().map(|s| (s.id, s)).collect(),
        queue,
        hands,
        tell: &tell,
        end,
        sleeping: BTreeSet::new(),
        limits: BTreeSet::new(),
        ready: BTreeSet::new(),
        running: JoinSet::new(),
        names: HashMap::new(),
    };
    runner.run(words).await;
    tell(BatchEvent::End);
}

/// A batch that runs.
struct AtWork(Arc<dyn CarryOut>);

impl AtWork {
    fn begin(hands: Arc<dyn CarryOut>) -> Self {
        hands.work(true);
        Self(hands)
    }
}

impl Drop for AtWork {
    fn drop(&mut self) {
        self.0.work(false);
    }
}

struct Runner<'a> {
    parallelism: usize,
    steps: BTreeMap<StepId, Step>,
    queue: Queue,
    hands: Arc<dyn CarryOut>,
    tell: &'a (dyn Fn(BatchEvent) + Send + Sync),
    end: Instant,
    /// Steps whose needs are met and that wait out their `wait_ms`.
    sleeping: BTreeSet<(Instant, StepId)>,
    /// Limits whose time runs.
    limits: BTreeSet<(Instant, StepId, usize)>,
    /// Steps that may start as soon as there is room.
    ready: BTreeSet<StepId>,
    running: JoinSet<(StepId, StepOutcome, Duration)>,
    names: HashMap<Id, StepId>,
}

impl Runner<'_> {
    async fn run(mut self, mut words: mpsc::Receiver<Word>) {
        let mut talking = true;
        loop {
            // Here, not only where the alarm rings: a step that ends at that very moment may be seen first.
            if self.end <= Instant::now() {
                self.cancel("the batch ran out of time");
            }
            // What has ended counts before any time that is over just now.
            while let Some(joined) = self.running.try_join_next_with_id() {
                self.joined(joined);
            }
            self.wake();
            self.start();
            if self.queue.is_over() && self.running.is_empty() {
                return;
            }
            let alarm = self.alarm();
            let expired = self.end <= Instant::now();
            tokio::select! {
                // What has ended, and any time that is over, is looked at above each time.
                biased;
                word = words.recv(), if talking => match word {
                    Some(Word::Gates(report)) => self.gates(&report),
                    Some(Word::Cancel(reason)) => self.cancel(&reason),
                    None => talking = false,
                },
                Some(joined) = self.running.join_next_with_id() => self.joined(joined),
                () = sleep_until(alarm), if !expired => {}
            }
        }
    }

    /// When time alone changes something next.
    fn alarm(&self) -> Instant {
        let sleeping = self.sleeping.first().map(|(at, _)| *at);
        let limit = self.limits.first().map(|(at, ..)| *at);
        let times = sleeping.into_iter().chain(limit);
        times.fold(self.end, Instant::min)
    }

    /// Moves steps on whose needs are met, or whose wait is over.
    fn wake(&mut self) {
        let now = Instant::now();
        self.expire(now);
        for Armed { step, limit, ms } in self.queue.take_armed() {
            let end = now + Duration::from_millis(ms.into());
            self.limits.insert((end, step, limit));
        }
        for id in self.queue.take_ready() {
            let wait = Duration::from_millis(self.steps[&id].wait_ms.into());
            self.sleeping.insert((now + wait, id));
        }
        while let Some((at, id)) = self.sleeping.first().copied()
            && at <= now
        {
            self.sleeping.pop_first();
            self.ready.insert(id);
        }
    }

    /// Ends the waits that have a limit and took that long.
    fn expire(&mut self, now: Instant) {
        while let Some((at, id, limit)) = self.limits.first().copied()
            && at <= now
        {
            self.limits.pop_first();
            let missing = self.queue.expire(id, limit);
            if !missing.is_empty() {
                let reason = in_vain::reason(&self.steps, id, limit, &missing);
                self.finished(id, failed(reason), Duration::ZERO);
            }
        }
    }

    fn start(&mut self) {
        while self.running.len() < self.parallelism
            && let Some(id) = self.ready.pop_first()
        {
            let step = self.steps[&id].clone();
            self.queue.started(id);
            (self.tell)(BatchEvent::Started { step: id });
            let now = Instant::now();
            let limit = self.hands.limit(&step).min(self.end - now);
            let end = (now + limit + GRACE).min(self.end);
            let what = what(&step);
            let span =
                info_span!(target: TARGET, "step", what = step.work.kind(), of = step.target);
            let work = self.hands.carry_out(step, limit).instrument(span);
            let task = self.running.spawn(async move {
                let outcome = match timeout_at(end, work).await {
                    Ok(Ok(())) => StepOutcome::Succeeded,
                    Ok(Err(e @ StepError::Replaced)) => StepOutcome::Skipped {
                        because_of: None,
                        reason: e.to_string(),
                    },
                    Ok(Err(e)) => failed(format!("{what}: {e}")),
                    Err(_) => failed(format!(
                        "{what} did not end within {} ms",
                        (end - now).as_millis()
                    )),
                };
                (id, outcome, now.elapsed())
            });
            self.names.insert(task.id(), id);
            // Steps that only wait for the start of this one.
            self.wake();
        }
    }

    fn joined(
        &mut self,
        joined: Result<(Id, (StepId, StepOutcome, Duration)), tokio::task::JoinError>,
    ) {
        match joined {
            Ok((task, (id, outcome, took))) => {
                self.names.remove(&task);
                self.finished(id, outcome, took);
            }
            Err(e) => {
                if let Some(id) = self.names.remove(&e.id()) {
                    let outcome = failed(format!("the agent failed: {e}"));
                    self.finished(id, outcome, Duration::ZERO);
                }
            }
        }
    }

    fn finished(&mut self, step: StepId, outcome: StepOutcome, took: Duration) {
        let succeeded = outcome == StepOutcome::Succeeded;
        (self.tell)(BatchEvent::Finished {
            step,
            outcome,
            micros: took.as_micros().try_into().unwrap_or(u64::MAX),
        });
        if succeeded {
            self.queue.succeeded(step);
        } else {
            let skipped = self.queue.failed(step);
            self.skip(skipped);
        }
    }

    fn gates(&mut self, report: &GateReport) {
        // Of the steps that are here we know better.
        let theirs = |ids: &[StepId]| {
            let ids = ids.iter().copied();
            ids.filter(|id| !self.steps.contains_key(id))
                .collect::<Vec<_>>()
        };
        let (started, succeeded) = (theirs(&report.started), theirs(&report.succeeded));
        let failed = theirs(&report.failed);
        for id in started.iter().chain(&succeeded) {
            self.queue.started(*id);
        }
        for id in succeeded {
            self.queue.succeeded(id);
        }
        for id in failed {
            let skipped = self.queue.failed(id);
            self.skip(skipped);
        }
    }

    /// Tells of steps that will not be tried because of a failure: (step, the step that failed).
    fn skip(&mut self, skipped: Vec<(StepId, StepId)>) {
        for (step, because_of) in skipped {
            // It may have been ready, but it has not started.
            self.ready.remove(&step);
            self.sleeping.retain(|(_, id)| *id != step);
            self.tell_skipped(step, Some(because_of), format!("step {because_of} failed"));
        }
    }

    fn cancel(&mut self, reason: &str) {
        self.ready.clear();
        self.sleeping.clear();
        self.limits.clear();
        for step in self.queue.cancel() {
            self.tell_skipped(step, None, reason.to_owned());
        }
    }

    fn tell_skipped(&self, step: StepId, because_of: Option<StepId>, reason: String) {
        (self.tell)(BatchEvent::Finished {
            step,
            outcome: StepOutcome::Skipped { because_of, reason },
            micros: 0,
        });
    }
}

/// A step in words.
fn what(step: &Step) -> String {
    format!("{} {}", step.work.kind(), step.target)
}

fn failed(reason: String) -> StepOutcome {
    StepOutcome::Failed { reason }
}

#[cfg(test)]
mod tests;
