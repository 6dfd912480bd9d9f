//! An agent as the controller reaches it.

use std::sync::Arc;
use std::time::Duration;

use futures_util::future::BoxFuture;
use rts_agent::LocalAgent;
use rts_agent_api::messages::{
    Batch, BindRequest, Bound, GateReport, LedgerFence, ModuleResolution, NodeSpecEnvelope,
    NodeSpecReceipt,
};
use rts_agent_api::{AgentApi, BatchEvents, ClientError, Saving};
use rts_plan::observed::Inventory;
use tokio::task::yield_now;
use tokio::time::timeout;

use super::{Hosts, Node, batch, too_late, unreachable};
use crate::life::Life;
use crate::truth::Happened;

/// As the controller's client has it.
const REQUEST: Duration = Duration::from_secs(25);
/// As the client of another agent has it.
const PEER: Duration = Duration::from_secs(3);
/// Turns of others until all that happened before is told.
const TURNS: u32 = 16;

/// The agent of a node, for a life of the controller. It is whoever serves there when a request comes.
#[derive(Clone)]
pub(super) struct Remote {
    pub hosts: Hosts,
    pub life: Life,
    pub node: String,
    pub endpoint: String,
}

type Work<T> = BoxFuture<'static, Result<T, ClientError>>;

impl Remote {
    async fn ask<T: Send + 'static>(
        &self,
        work: impl Fn(Node) -> Work<T> + Send + 'static,
    ) -> Result<T, ClientError> {
        let (hosts, node) = (self.hosts.clone(), self.node.clone());
        let serve = Box::new(move || {
            let node = hosts.node(&node)?;
            Some((node.life.clone(), work(node)))
        });
        let answer = self.hosts.0.net.ask(&self.life, &self.node, serve).await;
        answer.unwrap_or_else(|reset| Err(unreachable(&self.endpoint, reset)))
    }

    async fn soon<T: Send + 'static>(
        &self,
        work: impl Fn(Node) -> Work<T> + Send + 'static,
    ) -> Result<T, ClientError> {
        let answer = timeout(REQUEST, self.ask(work)).await;
        answer.unwrap_or_else(|_| Err(too_late(&self.endpoint)))
    }
}

impl Remote {
    /// What another agent asks.
    pub async fn bind(&self, request: Arc<BindRequest>) -> Result<Bound, ClientError> {
        let work = move |node: Node| -> Work<_> {
            let request = Arc::clone(&request);
            Box::pin(async move { node.api.bind(&request).await })
        };
        let answer = timeout(PEER, self.ask(work)).await;
        answer.unwrap_or_else(|_| Err(too_late(&self.endpoint)))
    }
}

impl AgentApi for Remote {
    async fn inventory(&self) -> Result<Inventory, ClientError> {
        self.soon(|node| Box::pin(async move { node.api.inventory().await }))
            .await
    }

    async fn node_spec(&self) -> Result<NodeSpecEnvelope, ClientError> {
        self.soon(|node| Box::pin(async move { node.api.node_spec().await }))
            .await
    }

    async fn put_node_spec(&self, spec: &NodeSpecEnvelope) -> Result<NodeSpecReceipt, ClientError> {
        let (spec, hosts) = (Arc::new(spec.clone()), self.hosts.clone());
        self.soon(move |node| {
            let (spec, hosts) = (Arc::clone(&spec), hosts.clone());
            Box::pin(async move { put(&hosts, &node.life, &node.api, &spec).await })
        })
        .await
    }

    async fn offer_node_spec(&self, spec: &NodeSpecEnvelope) -> Result<Saving, ClientError> {
        let offered = Arc::new(spec.clone());
        let work = move |node: Node| -> Work<_> {
            let spec = Arc::clone(&offered);
            // It is made durable whether somebody waits for that or not.
            Box::pin(async move { node.api.offer_node_spec(&spec).await.map(drop) })
        };
        self.soon(work).await?;
        let (agent, spec) = (self.clone(), spec.clone());
        Ok(Box::pin(async move { agent.put_node_spec(&spec).await }))
    }

    async fn run_batch(&self, batch: &Batch) -> Result<BatchEvents, ClientError> {
        let (batch, hosts) = (Arc::new(batch.clone()), self.hosts.clone());
        let caller = self.life.clone();
        let work = move |node: Node| -> Work<_> {
            let (batch, hosts, caller) = (Arc::clone(&batch), hosts.clone(), caller.clone());
            Box::pin(async move { batch::begin(&hosts, node, &caller, &batch).await })
        };
        let line = self.ask(work).await?;
        Ok(batch::events(line, self.endpoint.clone()))
    }

    async fn release(&self, plan_id: &str, gates: &GateReport) -> Result<(), ClientError> {
        let news = Arc::new((plan_id.to_owned(), gates.clone()));
        self.soon(move |node| {
            let news = Arc::clone(&news);
            Box::pin(async move { node.api.release(&news.0, &news.1).await })
        })
        .await
    }

    async fn resolve_modules(
        &self,
        type_names: &[String],
    ) -> Result<Vec<ModuleResolution>, ClientError> {
        let names = Arc::new(type_names.to_vec());
        self.soon(move |node| {
            let names = Arc::clone(&names);
            Box::pin(async move { node.api.resolve_modules(&names).await })
        })
        .await
    }
}

/// Stores a set, and tells that it was acknowledged.
async fn put(
    hosts: &Hosts,
    life: &Life,
    api: &LocalAgent,
    spec: &NodeSpecEnvelope,
) -> Result<NodeSpecReceipt, ClientError> {
    let receipt = api.put_node_spec(spec).await?;
    // Steps that began before are told by tasks whose turn has not come yet.
    for _ in 0..TURNS {
        yield_now().await;
    }
    hosts.0.truth.tell(&Happened::LedgerAcked {
        node: life.host().to_owned(),
        fence: LedgerFence {
            cluster_uid: spec.cluster_uid.clone(),
            epoch: spec.epoch,
            generation: spec.generation,
            digest: spec.digest.clone(),
        },
        systems: spec
            .spec
            .systems
            .iter()
            .map(|s| s.system.uid.clone())
            .collect(),
    });
    Ok(receipt)
}
