//! The node itself: who it is, what runs, what should run, its modules and logs.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::{Path, Query, State};
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use rts_agent_api::messages::{
    LogQuery, ModuleResolution, NodeInfo, NodeSpecEnvelope, NodeSpecReceipt, ResolveRequest,
};
use rts_agent_api::paths;
use rts_http::problem::Problem;
use rts_http::server::{Json, Principal};
use rts_plan::observed::Inventory;
use tokio::sync::Semaphore;

use super::{Answer, Shared};
use crate::agent::Agent;
use crate::ledger::Sealed;
use crate::log_tail::{LogReader, ReadError, Step, Wanted};

/// Logs that may be followed at once.
const MAX_FOLLOWERS: usize = 64;
/// One for each log that is followed; an agent is a process.
static FOLLOWERS: Semaphore = Semaphore::const_new(MAX_FOLLOWERS);
/// How often a log that is followed is looked at.
const POLL: Duration = Duration::from_millis(200);

/// Who the agent is.
#[utoipa::path(get, path = paths::NODE, responses((status = 200, body = NodeInfo)))]
pub(super) async fn node(_: Principal, State(agent): Shared) -> Json<NodeInfo> {
    Json(agent.info())
}

/// What runs on the node now: all managers are asked.
#[utoipa::path(get, path = paths::INVENTORY, responses((status = 200, body = Inventory)))]
pub(super) async fn inventory(_: Principal, State(agent): Shared) -> Json<Arc<Inventory>> {
    Json(agent.observe().await)
}

/// What the node was told to run.
#[utoipa::path(
    get,
    path = paths::NODE_SPEC,
    responses((status = 200, body = NodeSpecEnvelope), (status = 404, description = "it was told nothing yet", body = Problem))
)]
pub(super) async fn node_spec(_: Principal, State(agent): Shared) -> Answer<Json<Arc<Sealed>>> {
    Ok(Json(agent.node_spec().await?))
}

/// Replaces what the node should run. It counts, and batches may be sent for it, once the status is there; the body
/// follows when it is durable, and is a problem when it cannot be made so: then it is to be sent again.
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
    Json(offered): Json<Sealed>,
) -> Answer<Response> {
    let saving = agent.offer_node_spec(offered).await?;
    let body = stream::once(async move {
        match saving.await {
            Ok(receipt) => serde_json::to_vec(&receipt),
            Err(problem) => serde_json::to_vec(&problem),
        }
    });
    let kind = [(CONTENT_TYPE, "application/json")];
    Ok((kind, Body::from_stream(body)).into_response())
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
    Ok(Json(agent.modules.resolve_all(&request.types).await?))
}

/// A component's log as text: its last lines, those of the incarnation before, or those since a time, and what is added
/// to it for as long as the client stays.
#[utoipa::path(
    get,
    path = paths::LOG,
    params(
        ("instance" = String, Path, description = "instance name"),
        ("tail" = Option<usize>, Query, description = "lines from the end, at most 10000; none for 200, or for all with `since` or `previous`"),
        ("follow" = Option<bool>, Query, description = "stay, and send what is added, across rotations and restarts"),
        ("previous" = Option<bool>, Query, description = "of the incarnation before the newest only; not with `follow`"),
        ("since" = Option<String>, Query, description = "only lines from this time on, RFC 3339")
    ),
    responses(
        (status = 200, body = String, content_type = "text/plain"),
        (status = 400, description = "bad-request", body = Problem),
        (status = 404, description = "not-found, no-previous", body = Problem),
        (status = 503, description = "too-many-followers", body = Problem)
    )
)]
pub(super) async fn log(
    _: Principal,
    State(agent): Shared,
    Path(instance): Path<String>,
    Query(query): Query<LogQuery>,
) -> Answer<Response> {
    let wanted = wanted(&query)?;
    let permit = if wanted.follow {
        let permit = FOLLOWERS.try_acquire().map_err(|_| {
            let detail = format!("{MAX_FOLLOWERS} logs are followed already; end one of them");
            Problem::unavailable("too-many-followers", detail)
        })?;
        Some(permit)
    } else {
        None
    };
    let failed = |e: ReadError| match e {
        ReadError::NoPrevious => Problem::new(
            404,
            "no-previous",
            "no previous incarnation",
            format!("component {instance}: {e}"),
        ),
        ReadError::Io(e) => Problem::internal(format!("cannot read the log of {instance}: {e}")),
    };
    let path = agent.folders.component_log(&instance);
    let open = move || Ok(LogReader::open(&path, wanted)?);
    let reader = blocking(open).await.map_err(failed)?;
    if !reader.is_there() && !is_known(&agent, &instance).await {
        let node = &agent.config.node;
        return Err(Problem::not_found(format!("node {node} has no component {instance}")).into());
    }
    // What fails at once is answered with a problem.
    let (first, reader) = step(reader).await.map_err(failed)?;
    let text = stream::try_unfold(
        (Some(first), reader, permit),
        |(first, mut reader, permit)| async move {
            let mut next = first;
            loop {
                match next.take() {
                    Some(Step::Text(text)) => {
                        return Ok::<_, io::Error>(Some((text, (None, reader, permit))));
                    }
                    Some(Step::End) => return Ok(None),
                    Some(Step::Nothing) => tokio::time::sleep(POLL).await,
                    None => {}
                }
                let (step, again) = step(reader).await.map_err(io::Error::other)?;
                (next, reader) = (Some(step), again);
            }
        },
    );
    let kind = [(CONTENT_TYPE, "text/plain; charset=utf-8")];
    Ok((kind, Body::from_stream(text)).into_response())
}

/// What a query asks for.
fn wanted(query: &LogQuery) -> Result<Wanted, Problem> {
    if query.follow && query.previous {
        let detail = "nothing is added to the log of a previous incarnation: leave out `follow`";
        return Err(Problem::bad_request(detail));
    }
    let since = query.since.as_deref().map(|text| {
        text.parse()
            .map_err(|e| Problem::bad_request(format!("since={text:?} is no RFC 3339 time: {e}")))
    });
    Ok(Wanted {
        tail: query.tail,
        follow: query.follow,
        previous: query.previous,
        since: since.transpose()?,
    })
}

/// It runs, or should.
async fn is_known(agent: &Arc<Agent>, instance: &str) -> bool {
    let inventory = agent.observe().await;
    let mut running = inventory.managers.iter().flat_map(|m| &m.components);
    let wanted = agent.wanted_instances().await;
    running.any(|c| c.instance == instance) || wanted.iter().any(|(name, _)| name == instance)
}

/// The next step of a reader, off the event loop.
async fn step(mut reader: LogReader) -> Result<(Step, LogReader), ReadError> {
    blocking(move || Ok((reader.next()?, reader))).await
}

async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> Result<T, ReadError> + Send + 'static,
) -> Result<T, ReadError> {
    let done = tokio::task::spawn_blocking(work).await;
    done.unwrap_or_else(|e| Err(io::Error::other(e).into()))
}
