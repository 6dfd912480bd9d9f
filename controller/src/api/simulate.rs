//! What would happen to a system under faults.

use axum::extract::State;
use rts_controller_api::Problem;
use rts_controller_api::simulate::{SimulateRequest, Simulated};
use rts_http::server::{Json, Principal};

use super::extract::Segments;
use super::{Answer, App};

/// What would happen if this were applied and these faults came, played through in a simulation of the whole cluster.
/// Nothing changes. One at a time.
#[utoipa::path(
    post, path = "/v1/systems/{name}/simulate", params(("name" = String, Path,)),
    request_body = SimulateRequest,
    responses(
        (status = 200, body = Simulated),
        (status = 409, description = "other-system, instance-clash, terminating", body = Problem),
        (status = 413, description = "too-large", body = Problem),
        (status = 422, description = "bad-fault, bad-limit, and what a plan is refused for", body = Problem),
        (status = 503, description = "simulation-busy, no-simulator", body = Problem),
        (status = 504, description = "It takes too long", body = Problem)
    )
)]
pub async fn simulate(
    State(app): State<App>,
    _: Principal,
    Segments(name): Segments<String>,
    Json(request): Json<SimulateRequest>,
) -> Answer<Json<Simulated>> {
    Ok(Json(
        crate::simulate::simulate(&app.core, &name, request).await?,
    ))
}
