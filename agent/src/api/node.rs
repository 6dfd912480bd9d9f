//! The node itself: who it is, what runs, what should run, its modules and logs.

use axum::extract::{Path, Query, State};
use rts_agent_api::messages::{
    ModuleResolution, NodeInfo, NodeSpecEnvelope, NodeSpecReceipt, ResolveRequest,
};
use rts_agent_api::paths;
use rts_http::problem::Problem;
use rts_http::server::{Json, Principal};
use rts_plan::observed::Inventory;
use serde::Deserialize;

use super::{Answer, Shared};
use crate::log_tail;

/// Lines of a log that are given when nothing else was asked for.
const DEFAULT_TAIL: usize = 100;
/// Most types that are resolved at once.
const MAX_TYPES: usize = 10_000;

/// Who the agent is.
#[utoipa::path(get, path = paths::NODE, responses((status = 200, body = NodeInfo)))]
pub(super) async fn node(_: Principal, State(agent): Shared) -> Json<NodeInfo> {
    Json(agent.info())
}

/// What runs on the node now: all managers are asked.
#[utoipa::path(get, path = paths::INVENTORY, responses((status = 200, body = Inventory)))]
pub(super) async fn inventory(_: Principal, State(agent): Shared) -> Json<Inventory> {
    Json(agent.observe().await)
}

/// What the node was told to run.
#[utoipa::path(
    get,
    path = paths::NODE_SPEC,
    responses((status = 200, body = NodeSpecEnvelope), (status = 404, description = "it was told nothing yet", body = Problem))
)]
pub(super) async fn node_spec(
    _: Principal,
    State(agent): Shared,
) -> Answer<Json<NodeSpecEnvelope>> {
    let ledger = agent.ledger.lock().await;
    match ledger.held() {
        Some(held) => Ok(Json(held.clone())),
        None => Err(Problem::not_found("this node was told nothing yet").into()),
    }
}

/// Replaces what the node should run. Durable when it returns.
#[utoipa::path(
    put,
    path = paths::NODE_SPEC,
    request_body = NodeSpecEnvelope,
    responses(
        (status = 200, body = NodeSpecReceipt),
        (status = 409, description = "stale-epoch, stale-generation, digest-mismatch, foreign-cluster", body = Problem),
        (status = 422, description = "digest-mismatch, wrong-node", body = Problem)
    )
)]
pub(super) async fn put_node_spec(
    _: Principal,
    State(agent): Shared,
    Json(envelope): Json<NodeSpecEnvelope>,
) -> Answer<Json<NodeSpecReceipt>> {
    Ok(Json(agent.put_node_spec(envelope).await?))
}

/// Where the modules of types are.
#[utoipa::path(
    post,
    path = paths::RESOLVE,
    request_body = ResolveRequest,
    responses((status = 200, body = Vec<ModuleResolution>))
)]
pub(super) async fn resolve(
    _: Principal,
    State(agent): Shared,
    Json(request): Json<ResolveRequest>,
) -> Answer<Json<Vec<ModuleResolution>>> {
    if request.types.len() > MAX_TYPES {
        let detail = format!("at most {MAX_TYPES} types at once");
        return Err(Problem::invalid("too-many", detail).into());
    }
    let found = request.types.iter().map(|type_name| async {
        let resolution = agent.modules.resolve_described(type_name).await;
        resolution.map_err(|e| Problem::internal(e.to_string()))
    });
    let found = futures_util::future::try_join_all(found).await;
    Ok(Json(found?))
}

/// Which part of a log.
#[derive(Debug, Deserialize)]
pub(super) struct LogQuery {
    /// Number of lines from the end, at most 10000.
    tail: Option<usize>,
}

/// The last lines of a component's log.
#[utoipa::path(
    get,
    path = paths::LOG,
    params(("instance" = String, Path, description = "instance name"), ("tail" = Option<usize>, Query, description = "lines from the end, at most 10000")),
    responses((status = 200, body = String), (status = 404, body = Problem))
)]
pub(super) async fn log(
    _: Principal,
    State(agent): Shared,
    Path(instance): Path<String>,
    Query(query): Query<LogQuery>,
) -> Answer<String> {
    let unknown = || {
        let node = &agent.config.node;
        Problem::not_found(format!("node {node} has no component {instance}"))
    };
    let path = agent.folders.component_log(&instance);
    let lines = query.tail.unwrap_or(DEFAULT_TAIL);
    let read = tokio::task::spawn_blocking(move || log_tail::tail_of_log(&path, lines)).await;
    match read.map_err(std::io::Error::other).flatten() {
        Ok(text) => Ok(text),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            let inventory = agent.observe().await;
            let mut running = inventory.managers.iter().flat_map(|m| &m.components);
            let runs = running.any(|c| c.instance == instance);
            let wanted = agent.wanted_instances().await;
            if runs || wanted.iter().any(|(name, _)| *name == instance) {
                Ok(String::new())
            } else {
                Err(unknown().into())
            }
        }
        Err(e) => Err(Problem::internal(format!("cannot read the log of {instance}: {e}")).into()),
    }
}
