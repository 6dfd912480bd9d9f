//! Results of batches: told as they come about, and sent to whoever asked.

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};

use futures_util::{StreamExt, stream};
use rts_agent_api::messages::{Batch, BatchEvent};
use rts_agent_api::{AgentApi, BatchEvents, ClientError};
use rts_plan::plan::StepId;

use super::{Hosts, Node, unreachable};
use crate::life::Life;
use crate::net::{Line, Teller, line};
use crate::truth::Happened;

type Event = Result<BatchEvent, Arc<ClientError>>;

/// Hands a batch over to an agent. What comes of it is sent to the caller.
pub(super) async fn begin(
    hosts: &Hosts,
    node: Node,
    caller: &Life,
    batch: &Batch,
) -> Result<Line<Event>, ClientError> {
    let events = node.api.run_batch(batch).await?;
    let (teller, line) = line(&hosts.0.net, &node.life, caller);
    let mut told = node.told.lock().unwrap_or_else(PoisonError::into_inner);
    let first = told.insert(batch.plan_id.clone());
    drop(told);
    let pump = Pump {
        hosts: hosts.clone(),
        life: node.life.clone(),
        batch: batch.clone(),
        tells: first,
        teller: Some(teller),
    };
    tokio::spawn(pump.run(events));
    Ok(line)
}

/// The results as the caller sees them.
pub(super) fn events(line: Line<Event>, endpoint: String) -> BatchEvents {
    let events = stream::unfold(
        (line, endpoint, false),
        |(mut line, endpoint, over)| async move {
            if over {
                return None;
            }
            let (event, over) = match line.next().await? {
                Ok(Ok(event)) => (Ok(event), false),
                Ok(Err(e)) => (Err(again(&e)), true),
                Err(reset) => (Err(unreachable(&endpoint, reset)), true),
            };
            Some((event, (line, endpoint, over)))
        },
    );
    Box::pin(events)
}

fn again(error: &ClientError) -> ClientError {
    ClientError::Protocol {
        socket: Default::default(),
        reason: error.to_string(),
    }
}

/// Reads the results at the agent, whether anybody listens or not.
struct Pump {
    hosts: Hosts,
    life: Life,
    batch: Batch,
    /// It tells what really happens: the first one of a batch does.
    tells: bool,
    teller: Option<Teller<Event>>,
}

impl Pump {
    async fn run(mut self, mut events: BatchEvents) {
        let words: BTreeMap<StepId, String> = self
            .batch
            .steps
            .iter()
            .map(|step| (step.id, format!("{} {}", step.work.kind(), step.target)))
            .collect();
        loop {
            let event = tokio::select! {
                biased;
                () = self.life.over() => return,
                event = events.next() => event,
            };
            let Some(event) = event else { return };
            if let Ok(BatchEvent::Started { step }) = &event
                && self.tells
            {
                self.hosts.0.truth.tell(&Happened::StepBegan {
                    node: self.life.host().to_owned(),
                    cluster: self.batch.cluster_uid.clone(),
                    epoch: self.batch.epoch,
                    generation: self.batch.generation,
                    step: words.get(step).cloned().unwrap_or_default(),
                });
            }
            let listens = self
                .teller
                .as_mut()
                .is_some_and(|t| t.say(event.map_err(Arc::new)));
            if !listens {
                self.teller = None;
            }
        }
    }
}
