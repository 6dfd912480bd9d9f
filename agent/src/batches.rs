//! The batches that run and those that ended lately: their results can be read again by the id of their plan.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use bytes::Bytes;
use futures_util::{Stream, StreamExt, stream};
use rts_agent_api::messages::{Batch, BatchEvent, GateReport};
use rts_http::problem::Problem;
use rts_plan::Unfinished;
use tokio::sync::{mpsc, watch};
use tokio::time::Instant;

use crate::agent::Agent;
use crate::events::lock;
use crate::execute::{self, CarryOut, Hands, Queue, Word};
use crate::ledger::Fence;

/// Version of the stream's format.
const API_VERSION: &str = "rtsctl.dev/v1";
/// Most batches that run at once.
const MAX_RUNNING: usize = 8;
/// Most ended batches that are remembered.
const MAX_ENDED: usize = 16;
/// Most steps of a batch.
const MAX_STEPS: usize = 100_000;
/// A batch that runs for longer gets another one beside it, when the agent has something else to heal.
const LONG: Duration = Duration::from_secs(1);
/// Longest deadline of a batch.
pub(crate) const MAX_DEADLINE: Duration = Duration::from_secs(24 * 3600);
/// Most words that wait for a batch.
const WORDS: usize = 256;

/// The batches.
#[derive(Default)]
pub(crate) struct Batches(Mutex<Known>);

#[derive(Default)]
struct Known {
    batches: BTreeMap<String, Arc<Entry>>,
    /// Plan ids of ended batches, the oldest first.
    ended: VecDeque<String>,
}

/// One batch and its results.
pub(crate) struct Entry {
    batch: Batch,
    since: Instant,
    words: mpsc::Sender<Word>,
    events: Mutex<Vec<BatchEvent>>,
    /// Number of events; rings when it grows.
    grown: watch::Sender<usize>,
}

impl Entry {
    fn tell(&self, event: BatchEvent) {
        let count = {
            let mut events = lock(&self.events);
            events.push(event);
            events.len()
        };
        // Not under the lock: who waits may look at the events while the number is locked.
        self.grown.send_modify(|grown| *grown = count.max(*grown));
    }

    /// Waits until it has ended.
    pub async fn over(&self) {
        let mut grown = self.grown.subscribe();
        // The sender lives as long as the entry.
        let _ = grown
            .wait_for(|_| lock(&self.events).last() == Some(&BatchEvent::End))
            .await;
    }

    /// True once it has ended.
    pub fn is_over(&self) -> bool {
        lock(&self.events).last() == Some(&BatchEvent::End)
    }

    /// The results so far.
    pub fn results(&self) -> Vec<BatchEvent> {
        lock(&self.events).clone()
    }

    /// Its steps that have not ended.
    fn unfinished(&self) -> Vec<Unfinished> {
        let (mut started, mut ended) = (BTreeSet::new(), BTreeSet::new());
        for event in lock(&self.events).iter() {
            match event {
                BatchEvent::Started { step } => drop(started.insert(*step)),
                BatchEvent::Finished { step, .. } => drop(ended.insert(*step)),
                _ => {}
            }
        }
        let open = self.batch.steps.iter().filter(|s| !ended.contains(&s.id));
        open.map(|step| Unfinished::of(step, started.contains(&step.id)))
            .collect()
    }

    /// The results from the first on, until the batch has ended.
    pub fn stream(self: Arc<Self>) -> impl Stream<Item = BatchEvent> + Send + use<> {
        let grown = self.grown.subscribe();
        stream::unfold((self, grown, 0), |(entry, mut grown, next)| async move {
            if next > 0 && lock(&entry.events).get(next - 1) == Some(&BatchEvent::End) {
                return None;
            }
            // The sender lives as long as the entry.
            let _ = grown.wait_for(|count| *count > next).await;
            let event = lock(&entry.events).get(next).cloned()?;
            Some((event, (entry, grown, next + 1)))
        })
    }

    /// The same as JSON Lines.
    pub fn lines(self: Arc<Self>) -> impl Stream<Item = Result<Bytes, serde_json::Error>> {
        self.stream().map(|event| {
            let mut line = serde_json::to_vec(&event)?;
            line.push(b'\n');
            Ok(Bytes::from(line))
        })
    }
}

impl Batches {
    fn find(&self, plan_id: &str) -> Option<Arc<Entry>> {
        lock(&self.0).batches.get(plan_id).cloned()
    }

    /// Cancels what has not started in batches that were made for another spec.
    pub fn cancel_others(&self, held: &Fence) {
        let reason = format!("the node spec was replaced by {held}");
        self.cancel_where(&reason, |batch| fence(batch) != *held);
    }

    /// Cancels what has not started anywhere.
    pub fn cancel_all(&self, reason: &str) {
        self.cancel_where(reason, |_| true);
    }

    fn cancel_where(&self, reason: &str, meant: impl Fn(&Batch) -> bool) {
        for entry in lock(&self.0).batches.values() {
            if meant(&entry.batch) {
                let (words, reason) = (entry.words.clone(), reason.to_owned());
                // An ended batch listens no more.
                tokio::spawn(async move { words.send(Word::Cancel(reason)).await });
            }
        }
    }

    /// Cancels what has not started in one batch.
    pub async fn cancel(&self, plan_id: &str, reason: &str) {
        if let Some(entry) = self.find(plan_id) {
            // An ended batch listens no more.
            let _ = entry.words.send(Word::Cancel(reason.to_owned())).await;
        }
    }

    /// What the batches that run have still to do; none when another one cannot begin beside them: there are two, or one
    /// has not run for long.
    pub fn beside(&self) -> Option<Vec<Unfinished>> {
        let known = lock(&self.0);
        let runs = |(id, _): &(&String, &Arc<Entry>)| !known.ended.contains(id);
        let running: Vec<_> = known.batches.iter().filter(runs).collect();
        let mut running = running.into_iter().map(|(_, entry)| entry);
        if running.len() > 1 || running.clone().any(|entry| entry.since.elapsed() < LONG) {
            return None;
        }
        Some(running.next().map_or(Vec::new(), |e| e.unfinished()))
    }

    /// Passes on news of other nodes' steps.
    pub async fn gates(&self, plan_id: &str, report: GateReport) -> Result<(), Problem> {
        let entry = self.find(plan_id).ok_or_else(|| {
            Problem::not_found(format!("no batch of plan {plan_id} is known here"))
        })?;
        // An ended batch needs no news.
        let _ = entry.words.send(Word::Gates(report)).await;
        Ok(())
    }

    /// True while one runs.
    pub fn is_running(&self) -> bool {
        let known = lock(&self.0);
        known.batches.len() > known.ended.len()
    }

    fn add(&self, entry: &Arc<Entry>) -> Result<(), Problem> {
        let mut known = lock(&self.0);
        if known.batches.len() - known.ended.len() >= MAX_RUNNING {
            return Err(Problem::unavailable(
                "too-many-batches",
                format!("{MAX_RUNNING} batches run already; wait for one to end"),
            ));
        }
        known
            .batches
            .insert(entry.batch.plan_id.clone(), entry.clone());
        Ok(())
    }

    fn ended(&self, plan_id: &str) {
        let mut known = lock(&self.0);
        known.ended.push_back(plan_id.to_owned());
        while known.ended.len() > MAX_ENDED {
            if let Some(oldest) = known.ended.pop_front() {
                known.batches.remove(&oldest);
            }
        }
    }
}

/// What a batch was made for.
fn fence(batch: &Batch) -> Fence {
    Fence {
        cluster_uid: batch.cluster_uid.clone(),
        epoch: batch.epoch,
        generation: batch.generation,
    }
}

/// Ends a batch however its task ends, even by a fault of ours: nobody may wait for it for ever.
struct Running {
    agent: Arc<Agent>,
    entry: Arc<Entry>,
}

impl Drop for Running {
    fn drop(&mut self) {
        let plan_id = &self.entry.batch.plan_id;
        if lock(&self.entry.events).last() != Some(&BatchEvent::End) {
            tracing::error!(plan_id, "batch was broken off");
            self.entry.tell(BatchEvent::End);
        }
        self.agent.batches.ended(plan_id);
        self.agent.has_acted();
        tracing::info!(plan_id, "batch ended");
    }
}

impl Agent {
    /// Starts a batch, or finds the very same one started before.
    pub async fn submit(self: &Arc<Self>, batch: Batch) -> Result<Arc<Entry>, Problem> {
        if let Some(seen) = &batch.seen
            && self.batches.find(&batch.plan_id).is_none()
        {
            self.refuse_outdated(seen).await?;
        }
        let hands = Arc::new(Hands {
            agent: self.clone(),
            fence: fence(&batch),
        });
        self.submit_with(batch, hands).await
    }

    async fn submit_with(
        self: &Arc<Self>,
        batch: Batch,
        hands: Arc<dyn CarryOut>,
    ) -> Result<Arc<Entry>, Problem> {
        // Held to the end: a newer spec must find this batch, or this batch that spec.
        let ledger = self.ledger.lock().await;
        if let Some(entry) = self.batches.find(&batch.plan_id) {
            if entry.batch == batch {
                return Ok(entry);
            }
            return Err(Problem::conflict(
                "plan-differs",
                format!("another batch of plan {} was sent before", batch.plan_id),
            ));
        }
        let (meant, held) = (fence(&batch), ledger.fence());
        if held.as_ref() != Some(&meant) {
            let held = held.map_or("none".to_owned(), |fence| fence.to_string());
            return Err(Problem::conflict(
                "stale-generation",
                format!(
                    "the batch is for the node spec of {meant}; this node has {held}: plan again"
                ),
            ));
        }
        self.check(&batch)?;
        let queue = Queue::new(&batch.steps, &batch.gates)
            .map_err(|e| Problem::invalid("invalid-batch", e.to_string()))?;
        let (words, heard) = mpsc::channel(WORDS);
        let entry = Arc::new(Entry {
            words,
            events: Mutex::default(),
            grown: watch::Sender::new(0),
            since: Instant::now(),
            batch,
        });
        self.batches.add(&entry)?;
        entry.tell(BatchEvent::Accepted {
            api_version: API_VERSION.to_owned(),
            plan_id: entry.batch.plan_id.clone(),
        });
        let running = Running {
            agent: self.clone(),
            entry: entry.clone(),
        };
        tokio::spawn(async move {
            let batch = running.entry.batch.clone();
            let plan_id = batch.plan_id.clone();
            let count = batch.steps.len();
            tracing::info!(plan_id, count, "batch started");
            execute::run(batch, queue, hands, heard, |event| {
                log(&plan_id, &event);
                running.entry.tell(event);
            })
            .await;
        });
        Ok(entry)
    }

    fn check(&self, batch: &Batch) -> Result<(), Problem> {
        let node = &self.config.node;
        let invalid = |detail: String| Err(Problem::invalid("invalid-batch", detail));
        if batch.steps.len() > MAX_STEPS {
            return invalid(format!("a batch may have {MAX_STEPS} steps"));
        }
        if u128::from(batch.deadline_ms) > MAX_DEADLINE.as_millis() {
            let hours = MAX_DEADLINE.as_secs() / 3600;
            return invalid(format!("a batch may take {hours} hours"));
        }
        match batch.steps.iter().find(|s| s.node != *node) {
            Some(step) => invalid(format!(
                "step {} is for node {}; this is node {node}",
                step.id, step.node
            )),
            None => Ok(()),
        }
    }
}

fn log(plan_id: &str, event: &BatchEvent) {
    use rts_agent_api::messages::StepOutcome;
    if let BatchEvent::Finished {
        step,
        outcome: StepOutcome::Failed { reason },
        ..
    } = event
    {
        tracing::warn!(plan_id, step, "step failed: {reason}");
    } else {
        tracing::debug!(plan_id, ?event);
    }
}
