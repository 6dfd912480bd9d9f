//! Systems: apply, plan, delete.

use std::sync::Arc;

use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use rts_controller_api::Problem;
use rts_controller_api::objects::System;
use rts_controller_api::requests::{ApplyRequest, ApplyResult, PlanResult};
use rts_http::server::{Json, Principal};

use super::audit::audit;
use super::extract::{Params, Segments};
use super::objects::{OneQuery, system_as_asked, with_etag};
use super::{Answer, App};
use crate::admit::{self, Admitted};
use crate::apply::{Precondition, apply_if, delete_but, find, missing};

/// One system.
#[utoipa::path(
    get, path = "/v1/systems/{name}",
    params(
        ("name" = String, Path,),
        ("spec" = Option<bool>, Query, description = "`false`: without its spec, for those who follow how it is")
    ),
    responses(
        (status = 200, body = System, headers(("ETag" = String, description = "The resourceVersion"))),
        (status = 404, body = Problem)
    )
)]
pub async fn get(
    State(app): State<App>,
    _: Principal,
    Segments(name): Segments<String>,
    Params(query): Params<OneQuery>,
) -> Answer<Response> {
    system_as_asked(find(&app.core, &name)?, &query)
}

/// Applies a system. 202: stored as a new generation; 200: the very same is stored already.
#[utoipa::path(
    put, path = "/v1/systems/{name}",
    params(
        ("name" = String, Path,),
        ("If-Match" = Option<String>, Header, description = "ETags of which the stored system must have one, or *"),
        ("If-None-Match" = Option<String>, Header, description = "`*`: there must be no such system")
    ),
    request_body = ApplyRequest,
    responses(
        (status = 200, body = ApplyResult), (status = 202, body = ApplyResult),
        (status = 409, description = "stale-plan, would-restart, other-system, instance-clash, terminating", body = Problem),
        (status = 412, body = Problem),
        (status = 413, description = "too-large", body = Problem), (status = 422, body = Problem),
        (status = 503, body = Problem), (status = 507, description = "The disk of the store is full", body = Problem)
    )
)]
pub async fn put(
    State(app): State<App>,
    principal: Principal,
    Segments(name): Segments<String>,
    headers: HeaderMap,
    Json(request): Json<ApplyRequest>,
) -> Answer<Response> {
    audit(&principal, "apply", &format!("system/{name}"));
    let precondition = Precondition {
        if_match: if_match(&headers).map(str::to_owned),
        absent: must_be_absent(&headers)?,
    };
    let result = apply_if(&app.core, &name, request, precondition).await?;
    let status = if result.changed {
        StatusCode::ACCEPTED
    } else {
        StatusCode::OK
    };
    Ok((status, Json(result)).into_response())
}

/// What applying would do. Nothing changes.
#[utoipa::path(
    post, path = "/v1/systems/{name}/plan", params(("name" = String, Path,)),
    request_body = ApplyRequest,
    responses(
        (status = 200, body = PlanResult),
        (status = 409, description = "stale-plan, would-restart, other-system, instance-clash, terminating", body = Problem),
        (status = 413, description = "too-large", body = Problem), (status = 422, body = Problem),
        (status = 503, body = Problem)
    )
)]
pub async fn plan(
    State(app): State<App>,
    _: Principal,
    Segments(name): Segments<String>,
    Json(request): Json<ApplyRequest>,
) -> Answer<Json<PlanResult>> {
    let admitted = admit::admit(&app.core, &name, &request).await?;
    Ok(Json(planned(admitted)))
}

/// Plan of the stored systems as of now; empty when nothing is to be done.
#[utoipa::path(
    get, path = "/v1/systems/{name}/plan", params(("name" = String, Path,)),
    responses((status = 200, body = PlanResult), (status = 404, body = Problem))
)]
pub async fn stored_plan(
    State(app): State<App>,
    _: Principal,
    Segments(name): Segments<String>,
) -> Answer<Json<PlanResult>> {
    let admitted = admit::stored(&app.core, &name).await;
    Ok(Json(planned(admitted.ok_or_else(|| missing(&name))?)))
}

fn planned(admitted: Admitted) -> PlanResult {
    PlanResult {
        index: admitted.record.index,
        digest: admitted.digest(),
        plan: Arc::unwrap_or_clone(admitted.plan),
        notes: admitted.notes,
    }
}

/// Nodes of a DELETE's query that are not waited for.
fn forgotten(query: Vec<(String, String)>) -> Answer<Vec<String>> {
    let known = |(key, node): (String, String)| match key.as_str() {
        "forgetNode" => Ok(node),
        other => Err(Problem::bad_request(format!(
            "{other} is not known here: write forgetNode=NODE"
        ))
        .into()),
    };
    query.into_iter().map(known).collect()
}

/// Asks for a system's end. It is gone when it is answered with 404.
#[utoipa::path(
    delete, path = "/v1/systems/{name}",
    params(
        ("name" = String, Path,),
        ("forgetNode" = Option<Vec<String>>, Query,
            description = "Unknown nodes whose part is not waited for; when they come back, it is stopped"),
        ("If-Match" = Option<String>, Header, description = "ETags of which the stored system must have one, or *")
    ),
    responses(
        (status = 202, body = System, headers(("ETag" = String, description = "The resourceVersion"))),
        (status = 404, body = Problem), (status = 409, description = "A node to be forgotten is not Unknown", body = Problem),
        (status = 412, body = Problem), (status = 503, body = Problem),
        (status = 507, description = "The disk of the store is full", body = Problem)
    )
)]
pub async fn delete(
    State(app): State<App>,
    principal: Principal,
    Segments(name): Segments<String>,
    Params(query): Params<Vec<(String, String)>>,
    headers: HeaderMap,
) -> Answer<Response> {
    audit(&principal, "delete", &format!("system/{name}"));
    let forgotten = forgotten(query)?;
    let system = delete_but(&app.core, &name, if_match(&headers), forgotten).await?;
    let mut response = with_etag(system);
    *response.status_mut() = StatusCode::ACCEPTED;
    Ok(response)
}

/// `If-Match`: the request is meant for these versions only. What is no text matches none.
fn if_match(headers: &HeaderMap) -> Option<&str> {
    let value = headers.get(header::IF_MATCH)?;
    Some(value.to_str().unwrap_or_default())
}

/// `If-None-Match: *`: the request is meant to make a new system. Versions say nothing useful there.
fn must_be_absent(headers: &HeaderMap) -> Answer<bool> {
    match headers.get(header::IF_NONE_MATCH).map(HeaderValue::as_bytes) {
        None => Ok(false),
        Some(b"*") => Ok(true),
        Some(_) => Err(Problem::bad_request(
            "If-None-Match takes only * here (the system must not be there); to change one version use If-Match",
        )
        .into()),
    }
}
