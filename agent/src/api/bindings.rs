//! In-ports for connectors of other nodes.

use axum::extract::State;
use rts_agent_api::messages::{BindRequest, Bound};
use rts_agent_api::paths;
use rts_http::problem::Problem;
use rts_http::server::{Json, Principal};

use super::{Answer, Shared};

/// Lets a connector of another node come to an in-port of this one, if this node was told of it, and says where its
/// manager takes it. The agent of its out-port asks before it connects; the same again changes nothing.
#[utoipa::path(
    post,
    path = paths::BINDINGS,
    request_body = BindRequest,
    responses(
        (status = 200, body = Bound),
        (status = 404, description = "not-found: component or in-port", body = Problem),
        (status = 409, description = "not-expected, manager-conflict", body = Problem),
        (status = 503, description = "no-manager, manager-silent", body = Problem)
    )
)]
pub(super) async fn bind(
    _: Principal,
    State(agent): Shared,
    Json(request): Json<BindRequest>,
) -> Answer<Json<Bound>> {
    Ok(Json(agent.bind_for_peer(request).await?))
}
