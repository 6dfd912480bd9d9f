//! Batches of steps.

use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use rts_agent_api::messages::{Batch, GateReport};
use rts_agent_api::paths;
use rts_http::problem::Problem;
use rts_http::server::{Json, Principal};

use super::{Answer, Shared};

/// Media type of the results.
const JSON_LINES: &str = "application/jsonl";

/// Starts a batch and streams its results, one JSON object a line. A dropped stream does not stop the batch; the same
/// batch sent again gives the results from the first on.
#[utoipa::path(
    post,
    path = paths::BATCHES,
    request_body = Batch,
    responses(
        (status = 200, description = "lines of BatchEvent", content_type = "application/jsonl"),
        (status = 409, description = "stale-generation, plan-differs", body = Problem),
        (status = 422, description = "invalid-batch", body = Problem),
        (status = 503, description = "too-many-batches", body = Problem)
    )
)]
pub(super) async fn run_batch(
    _: Principal,
    State(agent): Shared,
    Json(batch): Json<Batch>,
) -> Answer<Response> {
    let entry = agent.submit(batch).await?;
    let body = Body::from_stream(entry.lines());
    Ok(([(header::CONTENT_TYPE, JSON_LINES)], body).into_response())
}

/// Tells a batch that steps of other nodes have started, succeeded or failed.
#[utoipa::path(
    post,
    path = paths::BATCH_GATES,
    params(("plan" = String, Path, description = "id of the plan")),
    request_body = GateReport,
    responses((status = 204, description = "taken"), (status = 404, body = Problem))
)]
pub(super) async fn release(
    _: Principal,
    State(agent): Shared,
    Path(plan): Path<String>,
    Json(report): Json<GateReport>,
) -> Answer<StatusCode> {
    agent.batches.gates(&plan, report).await?;
    Ok(StatusCode::NO_CONTENT)
}
