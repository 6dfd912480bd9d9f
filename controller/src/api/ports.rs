//! What goes over a port, looked at or written by hand: passed on between the client and the agent of the node.

use axum::body::Body;
use axum::extract::State;
use axum::response::Response;
use rts_agent_api::messages::{InjectLine, InjectQuery, Injected, PortEvent};
use rts_controller_api::Problem;
use rts_http::server::{Json, Principal};

use super::audit::{audit, ended};
use super::extract::{Params, Segments};
use super::pass::{opened, pass_on};
use super::{Answer, App, managers, of_agent, watch};

/// What an out-port writes, as JSON Lines of PortEvent, for as long as the client stays. Who reads too slowly misses
/// samples, and is told how many; the component never waits.
#[utoipa::path(
    get, path = "/v1/components/{node}/{instance}/ports/{port}/samples",
    params(("node" = String, Path,), ("instance" = String, Path,), ("port" = String, Path,)),
    responses(
        (status = 200, body = PortEvent, content_type = "application/jsonl"),
        (status = 404, description = "not-found: node, component or out-port", body = Problem),
        (status = 409, description = "Too many ports of the manager are looked at", body = Problem),
        (status = 501, description = "upgrade: the agent or the manager is of an older version", body = Problem),
        (status = 503, body = Problem)
    )
)]
pub async fn samples(
    State(app): State<App>,
    _: Principal,
    Segments((node, instance, port)): Segments<(String, String, String)>,
) -> Answer<Response> {
    let permit = watch::permit(&app)?;
    let agent = managers::agent(&app, &node)?;
    let samples = opened(&node, agent.stream_samples(&instance, &port)).await?;
    Ok(pass_on(&app, samples, Some(permit), "application/jsonl"))
}

/// Writes samples to an in-port by hand: JSON Lines of InjectLine, for as long as the client sends. Answered when the
/// component has read all of them, or the time for that is over. Nothing of it is left then.
#[utoipa::path(
    post, path = "/v1/components/{node}/{instance}/ports/{port}/samples",
    params(
        ("node" = String, Path,), ("instance" = String, Path,), ("port" = String, Path,),
        ("dataType" = String, Query, description = "IDL repository id of the samples, which must be that of the port"),
        ("waitMs" = Option<u64>, Query, description = "How long a sample waits for room; with 0 the oldest goes for it"),
        ("lingerMs" = Option<u64>, Query, description = "How long the last samples may wait to be read")
    ),
    request_body(content = InjectLine, content_type = "application/jsonl"),
    responses(
        (status = 200, body = Injected),
        (status = 404, description = "not-found: node, component or in-port", body = Problem),
        (status = 409, description = "Too many ports of the manager are written to", body = Problem),
        (status = 422, description = "manager-invalid: another data type", body = Problem),
        (status = 501, description = "upgrade: the agent or the manager is of an older version", body = Problem),
        (status = 503, body = Problem)
    )
)]
pub async fn inject(
    State(app): State<App>,
    principal: Principal,
    Segments((node, instance, port)): Segments<(String, String, String)>,
    Params(query): Params<InjectQuery>,
    body: Body,
) -> Answer<Json<Injected>> {
    let _permit = watch::permit(&app)?;
    let agent = managers::agent(&app, &node)?;
    let object = format!("component/{instance}.{port}");
    audit(&principal, "inject", &object);
    let body = reqwest::Body::wrap_stream(body.into_data_stream());
    let mut ending = app.ending.clone();
    let injected = tokio::select! {
        injected = agent.inject(&instance, &port, &query, body) => injected.map_err(|e| of_agent(&node, e)),
        _ = ending.wait_for(|ending| *ending) => {
            Err(Problem::unavailable("ending", "the controller ends"))
        }
    };
    let outcome = match &injected {
        Ok(Injected { taken, read, .. }) => format!("{taken} samples, {read} read"),
        Err(problem) => format!("{}: {}", problem.code, problem.detail),
    };
    ended(&principal, "inject", &object, &outcome);
    Ok(Json(injected?))
}
