//! Whose a node is: adopt or take over one whose ledger is another controller's, forget one that is no node any more.

use axum::extract::State;
use axum::http::StatusCode;
use rts_controller_api::Problem;
use rts_controller_api::requests::{NodeClaimed, TakeOver};
use rts_http::server::{Json, Principal};

use super::audit::audit;
use super::extract::Segments;
use super::{Answer, App};
use crate::forget;
use crate::ledger::claim;

/// Makes what runs on a node of another controller this controller's. Nothing restarts.
#[utoipa::path(
    post, path = "/v1/nodes/{node}/adopt", params(("node" = String, Path,)),
    responses(
        (status = 200, body = NodeClaimed), (status = 404, body = Problem),
        (status = 409, description = "name-taken, terminating, instance-clash, would-restart, ledger-changed, stale-controller", body = Problem),
        (status = 503, body = Problem), (status = 507, description = "The disk of the store is full", body = Problem)
    )
)]
pub async fn adopt(
    State(app): State<App>,
    principal: Principal,
    Segments(node): Segments<String>,
) -> Answer<Json<NodeClaimed>> {
    audit(&principal, "adopt", &format!("node/{node}"));
    Ok(Json(claim::adopt(&app.core, &node).await?))
}

/// Replaces what a node runs for another controller by this controller's set.
#[utoipa::path(
    post, path = "/v1/nodes/{node}/take-over", params(("node" = String, Path,)),
    request_body = TakeOver,
    responses(
        (status = 200, body = NodeClaimed), (status = 404, body = Problem),
        (status = 409, description = "ledger-changed, stale-controller", body = Problem),
        (status = 503, body = Problem)
    )
)]
pub async fn take_over(
    State(app): State<App>,
    principal: Principal,
    Segments(node): Segments<String>,
    Json(request): Json<TakeOver>,
) -> Answer<Json<NodeClaimed>> {
    audit(&principal, "take-over", &format!("node/{node}"));
    Ok(Json(claim::take_over(&app.core, &node, request).await?))
}

/// Forgets a node whose agent is away, or that is reached by SSH, and on which no system is. It is there again when its
/// agent greets.
#[utoipa::path(
    delete, path = "/v1/nodes/{name}", params(("name" = String, Path,)),
    responses(
        (status = 204), (status = 404, body = Problem),
        (status = 409, description = "systems-run, node-lives", body = Problem)
    )
)]
pub async fn forget(
    State(app): State<App>,
    principal: Principal,
    Segments(name): Segments<String>,
) -> Answer<StatusCode> {
    audit(&principal, "forget", &format!("node/{name}"));
    forget::forget(&app.core, &name)?;
    Ok(StatusCode::NO_CONTENT)
}
