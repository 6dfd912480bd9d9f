//! How agents are reached. A simulation passes its own fleet.

use std::sync::Arc;
use std::time::Duration;

use futures_util::future::BoxFuture;
use rts_agent_api::client::HttpAgent;
use rts_agent_api::messages::{Batch, GateReport, ModuleResolution, NodeSpecEnvelope};
use rts_agent_api::{AgentApi, BatchEvents, ClientError, Saving};
use rts_http::client::Client;
use rts_plan::observed::Inventory;

/// Time-out of a single request to an agent; callers set shorter deadlines of their own. Longer than an agent takes for
/// anything that a person does by hand, so that its own answer comes first.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(25);

/// Agents that something is asked of at the same time: of a thousand, the last ones would have waited for their turn for as
/// long as one may take to answer.
pub(crate) const AT_ONCE: usize = 256;

/// [`AgentApi`] behind a pointer: what the rest of this crate drives.
pub trait Agent: Send + Sync + 'static {
    /// See [`AgentApi::inventory`].
    fn inventory(&self) -> BoxFuture<'_, Result<Inventory, ClientError>>;
    /// See [`AgentApi::node_spec`].
    fn node_spec(&self) -> BoxFuture<'_, Result<NodeSpecEnvelope, ClientError>>;
    /// See [`AgentApi::offer_node_spec`].
    fn offer_node_spec<'a>(
        &'a self,
        spec: &'a NodeSpecEnvelope,
    ) -> BoxFuture<'a, Result<Saving, ClientError>>;
    /// See [`AgentApi::run_batch`].
    fn run_batch<'a>(&'a self, batch: &'a Batch)
    -> BoxFuture<'a, Result<BatchEvents, ClientError>>;
    /// See [`AgentApi::release`].
    fn release<'a>(
        &'a self,
        plan_id: &'a str,
        gates: &'a GateReport,
    ) -> BoxFuture<'a, Result<(), ClientError>>;
    /// See [`AgentApi::resolve_modules`].
    fn resolve_modules<'a>(
        &'a self,
        type_names: &'a [String],
    ) -> BoxFuture<'a, Result<Vec<ModuleResolution>, ClientError>>;
}

impl<A: AgentApi> Agent for A {
    fn inventory(&self) -> BoxFuture<'_, Result<Inventory, ClientError>> {
        Box::pin(AgentApi::inventory(self))
    }

    fn node_spec(&self) -> BoxFuture<'_, Result<NodeSpecEnvelope, ClientError>> {
        Box::pin(AgentApi::node_spec(self))
    }

    fn offer_node_spec<'a>(
        &'a self,
        spec: &'a NodeSpecEnvelope,
    ) -> BoxFuture<'a, Result<Saving, ClientError>> {
        Box::pin(AgentApi::offer_node_spec(self, spec))
    }

    fn run_batch<'a>(
        &'a self,
        batch: &'a Batch,
    ) -> BoxFuture<'a, Result<BatchEvents, ClientError>> {
        Box::pin(AgentApi::run_batch(self, batch))
    }

    fn release<'a>(
        &'a self,
        plan_id: &'a str,
        gates: &'a GateReport,
    ) -> BoxFuture<'a, Result<(), ClientError>> {
        Box::pin(AgentApi::release(self, plan_id, gates))
    }

    fn resolve_modules<'a>(
        &'a self,
        type_names: &'a [String],
    ) -> BoxFuture<'a, Result<Vec<ModuleResolution>, ClientError>> {
        Box::pin(AgentApi::resolve_modules(self, type_names))
    }
}

/// Makes agents from the endpoints in their greetings.
pub trait Fleet: Send + Sync + 'static {
    /// The agent at an endpoint. Nothing is dialled yet.
    fn agent(&self, node: &str, endpoint: &str) -> Result<Arc<dyn Agent>, ClientError>;
}

/// Real agents behind Unix sockets.
#[derive(Debug, Clone, Copy, Default)]
pub struct HttpFleet;

impl Fleet for HttpFleet {
    fn agent(&self, _: &str, endpoint: &str) -> Result<Arc<dyn Agent>, ClientError> {
        Ok(Arc::new(http_agent(endpoint)?))
    }
}

/// The HTTP client of an agent, for what is only passed through (logs, samples, the manager service).
pub fn http_agent(endpoint: &str) -> Result<HttpAgent, ClientError> {
    Ok(HttpAgent::new(Client::unix(endpoint, REQUEST_TIMEOUT)?))
}
