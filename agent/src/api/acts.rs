//! Changes by hand of what runs.

use axum::extract::State;
use rts_agent_api::messages::{ActRequest, Acted};
use rts_agent_api::paths;
use rts_http::problem::Problem;
use rts_http::server::{Json, Principal};

use super::{Answer, Shared};

/// Activates, deactivates, resets or configures a component, or connects or disconnects two ports of this node, or of
/// two nodes as a system has them. Of
/// components with and without a system; what becomes of a change of a system's is told.
#[utoipa::path(
    post,
    path = paths::ACTS,
    request_body = ActRequest,
    responses(
        (status = 200, body = Acted),
        (status = 404, description = "not-found: component, port or connector", body = Problem),
        (status = 409, description = "wrong-state, name-taken, manager-conflict", body = Problem),
        (status = 422, description = "nothing-to-set, unknown-set, unknown-parameter, wrong-direction, data-type-differs, unsupported, invalid-name, manager-invalid, component-failed", body = Problem),
        (status = 502, description = "peer-failed", body = Problem),
        (status = 503, description = "manager-silent", body = Problem),
        (status = 504, description = "deadline", body = Problem)
    )
)]
pub(super) async fn act(
    principal: Principal,
    State(agent): Shared,
    Json(request): Json<ActRequest>,
) -> Answer<Json<Acted>> {
    if !request.dry_run {
        tracing::info!(
            target: "audit",
            uid = principal.uid,
            pid = principal.pid,
            verb = "act-by-hand",
            object = ?request.act,
        );
    }
    Ok(Json(agent.act_by_hand(request).await?))
}
