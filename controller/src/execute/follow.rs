//! Follows the results of one node's batch to their end.

use std::sync::Arc;
use std::time::Duration;

use futures_util::StreamExt;
use futures_util::stream::{self, BoxStream};
use rts_agent_api::messages::{Batch, BatchEvent};
use rts_agent_api::{BatchEvents, ClientError};
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};

use super::run::Peer;
use crate::fault::Fault;
use crate::fleet::Agent;

/// Time after its deadline in which the agent must have said so.
const GRACE: Duration = Duration::from_secs(5);
/// Time for an agent to accept a batch.
pub(super) const ACCEPT: Duration = Duration::from_secs(5);
/// Silence after which the results are asked for anew, at first and at most: what was sent may have been lost on the
/// way while the session lived on.
const SILENCE: (Duration, Duration) = (Duration::from_secs(5), Duration::from_secs(40));

/// Something that came from one node.
pub(super) enum Report {
    Event(String, BatchEvent),
    /// The stream ended: regularly, or the reason why not.
    Over(String, Option<Broken>),
}

/// Why a batch was broken off.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Broken {
    /// Its agent, or the way to it, was lost: that says nothing about the steps.
    Lost(String),
    /// Its agent refused it, or did not end it in time.
    Failed(String),
}

impl Broken {
    /// For people.
    pub fn reason(&self) -> &str {
        let (Self::Lost(reason) | Self::Failed(reason)) = self;
        reason
    }

    /// What that says of the node.
    pub fn fault(&self) -> Fault {
        match self {
            Self::Lost(reason) => Fault::silent(reason),
            Self::Failed(reason) => Fault::refused(reason),
        }
    }
}

/// The reports of one node's batch, with an end in any case: loss of the agent and the deadline included. One event may
/// be told several times. So many batches are sent at a time as `turns` has permits.
pub(super) fn follow(
    node: String,
    batch: Batch,
    peer: Peer,
    turns: Arc<Semaphore>,
) -> BoxStream<'static, Report> {
    let Peer { agent, lost, .. } = peer;
    let limit = Duration::from_millis(batch.deadline_ms) + GRACE;
    let results = Results {
        node: node.clone(),
        batch,
        agent,
        turns,
        events: None,
        silence: SILENCE.0,
        accepted: false,
    };
    let results = stream::unfold(results, |mut results| async move {
        let event = results.next().await;
        Some((event, results))
    });
    // Whatever ends it first says why; an `End` is the regular one.
    let cut_off = stream::once(async move {
        tokio::select! {
            biased;
            () = lost => Err(Broken::Lost("its agent was lost".to_owned())),
            () = sleep(limit) => {
                let reason = format!("its batch did not end within {} s", limit.as_secs());
                Err(Broken::Failed(reason))
            }
        }
    });
    let merged = stream::select(results.boxed(), cut_off.boxed()).map(move |event| match event {
        Ok(BatchEvent::End) => Report::Over(node.clone(), None),
        Ok(event) => Report::Event(node.clone(), event),
        Err(reason) => Report::Over(node.clone(), Some(reason)),
    });
    until_over(merged.boxed())
}

/// The results of a batch, as its agent tells them.
struct Results {
    node: String,
    batch: Batch,
    agent: Arc<dyn Agent>,
    turns: Arc<Semaphore>,
    /// None when they are to be asked for.
    events: Option<BatchEvents>,
    silence: Duration,
    accepted: bool,
}

impl Results {
    /// The next one, or why there are no more.
    async fn next(&mut self) -> Result<BatchEvent, Broken> {
        loop {
            let Some(events) = &mut self.events else {
                self.attach().await?;
                continue;
            };
            match timeout(self.silence, events.next()).await {
                Ok(Some(Ok(event))) => return Ok(event),
                Ok(Some(Err(e))) => {
                    let reason = format!("the results of its steps stopped: {e}");
                    return Err(Broken::Lost(reason));
                }
                Ok(None) => {
                    return Err(Broken::Lost("its agent closed the stream early".to_owned()));
                }
                Err(_) => {
                    self.silence = (self.silence * 2).min(SILENCE.1);
                    self.events = None;
                }
            }
        }
    }

    /// Sends the batch: the first time to have it carried out, then to hear its results from the first on.
    async fn attach(&mut self) -> Result<(), Broken> {
        let node = &self.node;
        let _turn = self.turns.acquire().await;
        match timeout(ACCEPT, self.agent.run_batch(&self.batch)).await {
            Ok(Ok(events)) => {
                self.accepted = true;
                self.events = Some(events);
                Ok(())
            }
            Ok(Err(e @ ClientError::Problem(_))) => Err(Broken::Failed(format!(
                "the agent of node {node} refused the steps: {e}"
            ))),
            Ok(Err(e)) if !self.accepted => Err(Broken::Lost(format!(
                "the agent of node {node} was not sent the steps: {e}"
            ))),
            Err(_) if !self.accepted => Err(Broken::Lost(format!(
                "the agent of node {node} did not accept the steps within {} s",
                ACCEPT.as_secs()
            ))),
            // It has them; only its loss or the deadline ends the waiting.
            _ => {
                sleep(self.silence).await;
                Ok(())
            }
        }
    }
}

/// Ends a stream with its first [`Report::Over`].
fn until_over(reports: BoxStream<'static, Report>) -> BoxStream<'static, Report> {
    stream::unfold(Some(reports), |reports| async move {
        let mut reports = reports?;
        let report = reports.next().await?;
        let over = matches!(report, Report::Over(..));
        Some((report, (!over).then_some(reports)))
    })
    .boxed()
}
