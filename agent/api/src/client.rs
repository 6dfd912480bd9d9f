//! HTTP client of an agent.

use futures_util::stream;
use reqwest::{Body, Method, RequestBuilder, Response};
use rts_http::client::{Client, ClientError, segment};
use rts_http::lines::Lines;
use rts_http::problem::Problem;
use rts_plan::observed::Inventory;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use crate::messages::{
    ActRequest, Acted, Batch, BatchEvent, BindRequest, Bound, CreateByHand, CreatedByHand, Factory,
    GateReport, InjectQuery, Injected, LogQuery, ModuleRequest, ModuleResolution, NodeInfo,
    NodeSpecEnvelope, NodeSpecReceipt, ResolveRequest, Timings, TimingsQuery,
};
use crate::{AgentApi, BatchEvents, Saving, paths};

/// An agent behind a Unix socket.
#[derive(Debug, Clone)]
pub struct HttpAgent {
    http: Client,
}

impl HttpAgent {
    /// An agent that listens on the client's socket.
    pub fn new(http: Client) -> Self {
        Self { http }
    }

    /// Who it is.
    pub async fn node(&self) -> Result<NodeInfo, ClientError> {
        self.http.get(paths::NODE).await
    }

    /// A component's log as it comes; it has no time-out.
    pub async fn stream_log(
        &self,
        instance: &str,
        query: &LogQuery,
    ) -> Result<Response, ClientError> {
        self.http.accept(self.log_request(instance, query)).await
    }

    /// The last `tail` lines of a component's log.
    pub async fn log(&self, instance: &str, tail: usize) -> Result<String, ClientError> {
        let query = LogQuery {
            tail: Some(tail),
            ..LogQuery::default()
        };
        self.http.text(self.log_request(instance, &query)).await
    }

    fn log_request(&self, instance: &str, query: &LogQuery) -> RequestBuilder {
        let path = paths::LOG.replace("{instance}", &segment(instance));
        self.http.request(Method::GET, &path).query(query)
    }

    /// What an out-port writes, as it comes: JSON Lines of [`PortEvent`](crate::messages::PortEvent). It has no time-out.
    pub async fn stream_samples(
        &self,
        instance: &str,
        port: &str,
    ) -> Result<Response, ClientError> {
        let path = of_port(instance, port);
        let request = self.http.request(Method::GET, &path);
        let response = self.http.accept(request).await;
        response.map_err(|e| e.or_upgrade("agent", &path))
    }

    /// Writes to an in-port what the body brings, JSON Lines of [`InjectLine`](crate::messages::InjectLine). It has no
    /// time-out.
    pub async fn inject(
        &self,
        instance: &str,
        port: &str,
        query: &InjectQuery,
        body: Body,
    ) -> Result<Injected, ClientError> {
        let path = of_port(instance, port);
        let request = self.http.request(Method::POST, &path).query(query);
        let injected = self.http.unhurried(request.body(body)).await;
        injected.map_err(|e| e.or_upgrade("agent", &path))
    }

    /// Loads a module by hand.
    pub async fn load_module(
        &self,
        manager: &str,
        request: &ModuleRequest,
    ) -> Result<Factory, ClientError> {
        self.at_manager(Method::POST, paths::MANAGER_MODULES, manager, request)
            .await
    }

    /// Unloads a module.
    pub async fn unload_module(&self, manager: &str, type_name: &str) -> Result<(), ClientError> {
        self.delete(
            &of_manager(paths::MANAGER_MODULE, manager).replace("{type}", &segment(type_name)),
        )
        .await
    }

    /// Modules that a manager has opened.
    pub async fn factories(&self, manager: &str) -> Result<Vec<Factory>, ClientError> {
        self.http
            .get(&of_manager(paths::MANAGER_FACTORIES, manager))
            .await
    }

    /// Creates a component by hand.
    pub async fn create(
        &self,
        manager: &str,
        request: &CreateByHand,
    ) -> Result<CreatedByHand, ClientError> {
        self.at_manager(Method::POST, paths::MANAGER_COMPONENTS, manager, request)
            .await
    }

    /// Deletes a component that was created by hand.
    pub async fn delete_component(&self, manager: &str, instance: &str) -> Result<(), ClientError> {
        let path = of_manager(paths::MANAGER_COMPONENT, manager);
        self.delete(&path.replace("{instance}", &segment(instance)))
            .await
    }

    /// Changes by hand what runs.
    pub async fn act(&self, request: &ActRequest) -> Result<Acted, ClientError> {
        self.http.send(Method::POST, paths::ACTS, request).await
    }

    /// Lets a connector of another node come to an in-port.
    pub async fn bind(&self, request: &BindRequest) -> Result<Bound, ClientError> {
        self.http.send(Method::POST, paths::BINDINGS, request).await
    }

    /// Where the time went lately.
    pub async fn timings(&self, query: &TimingsQuery) -> Result<Timings, ClientError> {
        let request = self.http.request(Method::GET, paths::TIMINGS);
        self.http.json(request.query(query)).await
    }

    async fn at_manager<B: Serialize, T: DeserializeOwned>(
        &self,
        method: Method,
        path: &str,
        manager: &str,
        body: &B,
    ) -> Result<T, ClientError> {
        self.http
            .send(method, &of_manager(path, manager), body)
            .await
    }

    async fn delete(&self, path: &str) -> Result<(), ClientError> {
        self.http
            .text(self.http.request(Method::DELETE, path))
            .await
            .map(drop)
    }
}

/// What follows once a NodeSpec counts.
#[derive(Deserialize)]
#[serde(untagged)]
enum Receipt {
    Durable(NodeSpecReceipt),
    Failed(Problem),
}

fn of_port(instance: &str, port: &str) -> String {
    let path = paths::SAMPLES.replace("{instance}", &segment(instance));
    path.replace("{port}", &segment(port))
}

fn of_manager(path: &str, manager: &str) -> String {
    path.replace("{manager}", &segment(manager))
}

impl AgentApi for HttpAgent {
    async fn inventory(&self) -> Result<Inventory, ClientError> {
        self.http.get(paths::INVENTORY).await
    }

    async fn node_spec(&self) -> Result<NodeSpecEnvelope, ClientError> {
        self.http.get(paths::NODE_SPEC).await
    }

    async fn put_node_spec(&self, spec: &NodeSpecEnvelope) -> Result<NodeSpecReceipt, ClientError> {
        self.offer_node_spec(spec).await?.await
    }

    async fn offer_node_spec(&self, spec: &NodeSpecEnvelope) -> Result<Saving, ClientError> {
        let request = self.http.request(Method::PUT, paths::NODE_SPEC).json(spec);
        // An agent that does not answer once and for all is given up by the caller, or with its session.
        let response = self.http.accept(request).await?;
        let http = self.http.clone();
        Ok(Box::pin(async move {
            let receipt: Receipt = http.decode(response).await?;
            match receipt {
                Receipt::Durable(receipt) => Ok(receipt),
                Receipt::Failed(problem) => Err(problem.into()),
            }
        }))
    }

    async fn run_batch(&self, batch: &Batch) -> Result<BatchEvents, ClientError> {
        let response = self
            .http
            .accept(self.http.request(Method::POST, paths::BATCHES).json(batch))
            .await?;
        let lines = Lines::of(response);
        let socket = self.http.socket().to_owned();
        Ok(Box::pin(stream::try_unfold(
            (lines, socket),
            |(mut lines, socket)| async move {
                let Some(line) = lines.next().await else {
                    return Ok(None);
                };
                let line = line.map_err(|e| ClientError::Unreachable {
                    socket: socket.clone(),
                    reason: e.to_string(),
                })?;
                let event: BatchEvent =
                    serde_json::from_str(&line).map_err(|e| ClientError::Protocol {
                        socket: socket.clone(),
                        reason: e.to_string(),
                    })?;
                Ok(Some((event, (lines, socket))))
            },
        )))
    }

    async fn release(&self, plan_id: &str, gates: &GateReport) -> Result<(), ClientError> {
        let path = paths::BATCH_GATES.replace("{plan}", &segment(plan_id));
        self.http
            .text(self.http.request(Method::POST, &path).json(gates))
            .await
            .map(drop)
    }

    async fn resolve_modules(
        &self,
        type_names: &[String],
    ) -> Result<Vec<ModuleResolution>, ClientError> {
        let request = ResolveRequest {
            types: type_names.to_vec(),
        };
        self.http.send(Method::POST, paths::RESOLVE, &request).await
    }
}
