//! The API of an agent within its own process: what its HTTP API does, without a socket.

use std::sync::Arc;

use futures_util::StreamExt;
use rts_agent_api::messages::{
    ActRequest, Acted, Batch, BindRequest, Bound, GateReport, ModuleResolution, NodeInfo,
    NodeSpecEnvelope, NodeSpecReceipt,
};
use rts_agent_api::{AgentApi, BatchEvents, ClientError, Saving};
use rts_http::problem::Problem;
use rts_plan::observed::Inventory;

use crate::agent::Agent;
use crate::ledger::Sealed;

/// An agent in this process.
#[derive(Clone)]
pub struct LocalAgent(Arc<Agent>);

impl LocalAgent {
    pub(crate) fn new(agent: Arc<Agent>) -> Self {
        Self(agent)
    }

    /// Who it is.
    pub fn node(&self) -> NodeInfo {
        self.0.info()
    }

    /// Its HTTP API, for a server.
    pub fn router(&self) -> axum::Router {
        crate::api::router(self.0.clone())
    }

    /// Lets a connector of another node come to an in-port.
    pub async fn bind(&self, request: &BindRequest) -> Result<Bound, ClientError> {
        Ok(self.0.bind_for_peer(request.clone()).await?)
    }

    /// Changes by hand what runs.
    pub async fn act(&self, request: &ActRequest) -> Result<Acted, ClientError> {
        Ok(self.0.act_by_hand(request.clone()).await?)
    }
}

impl AgentApi for LocalAgent {
    async fn inventory(&self) -> Result<Inventory, ClientError> {
        Ok(Arc::unwrap_or_clone(self.0.observe().await))
    }

    async fn node_spec(&self) -> Result<NodeSpecEnvelope, ClientError> {
        Ok(self.0.node_spec().await?.envelope().clone())
    }

    async fn put_node_spec(&self, spec: &NodeSpecEnvelope) -> Result<NodeSpecReceipt, ClientError> {
        let sealed = Sealed::of(spec).map_err(|e| Problem::bad_request(e.to_string()))?;
        Ok(self.0.put_node_spec(sealed).await?)
    }

    async fn offer_node_spec(&self, spec: &NodeSpecEnvelope) -> Result<Saving, ClientError> {
        let sealed = Sealed::of(spec).map_err(|e| Problem::bad_request(e.to_string()))?;
        let saving = self.0.offer_node_spec(sealed).await?;
        Ok(Box::pin(async move { Ok(saving.await?) }))
    }

    async fn run_batch(&self, batch: &Batch) -> Result<BatchEvents, ClientError> {
        let entry = self.0.submit(batch.clone()).await?;
        Ok(Box::pin(entry.stream().map(Ok)))
    }

    async fn release(&self, plan_id: &str, gates: &GateReport) -> Result<(), ClientError> {
        Ok(self.0.batches.gates(plan_id, gates.clone()).await?)
    }

    async fn resolve_modules(
        &self,
        type_names: &[String],
    ) -> Result<Vec<ModuleResolution>, ClientError> {
        Ok(self.0.modules.resolve_all(type_names).await?)
    }
}
