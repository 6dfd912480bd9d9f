//! Greetings and heartbeats of agents.

use axum::extract::State;
use axum::http::StatusCode;
use rts_agent_api::session::{Heartbeat, SessionGreeting, SessionReply};
use rts_controller_api::Problem;
use rts_http::server::{Json, Principal};

use super::audit::audit;
use super::extract::Segments;
use super::{Answer, App};
use crate::greet::{greet as take_greeting, heartbeat as take_heartbeat};

/// An agent greets; the newest session of a node wins.
#[utoipa::path(
    post, path = "/v1/nodes/{node}/sessions", params(("node" = String, Path,)),
    request_body = SessionGreeting,
    responses(
        (status = 200, body = SessionReply), (status = 409, body = Problem),
        (status = 503, description = "reconcile-stuck", body = Problem)
    )
)]
pub async fn greet(
    State(app): State<App>,
    principal: Principal,
    Segments(node): Segments<String>,
    Json(greeting): Json<SessionGreeting>,
) -> Answer<Json<SessionReply>> {
    audit(&principal, "greet", &format!("node/{node}"));
    Ok(Json(take_greeting(&app.core, &node, greeting)?))
}

/// A sign of life.
#[utoipa::path(
    post, path = "/v1/nodes/{node}/sessions/{session}/heartbeat",
    params(("node" = String, Path,), ("session" = String, Path,)),
    request_body = Heartbeat,
    responses(
        (status = 204), (status = 404, body = Problem), (status = 409, body = Problem),
        (status = 503, description = "reconcile-stuck", body = Problem)
    )
)]
pub async fn heartbeat(
    State(app): State<App>,
    _: Principal,
    Segments((node, session)): Segments<(String, String)>,
    Json(heartbeat): Json<Heartbeat>,
) -> Answer<StatusCode> {
    take_heartbeat(&app.core, &node, &session, heartbeat)?;
    Ok(StatusCode::NO_CONTENT)
}
